"""Lets many stations send their sessions to one PostgreSQL server at once, while stations and server are killed at
random moments (SIGKILL). At the end the server must have each stored session exactly once, with the same contents as
the station."""

import collections
import json
import os
import random
import signal
import subprocess
import tempfile
import time

import postgres_server

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
BUILD = os.path.join(ROOT, os.environ.get("BUILD") or "build")
PROGRAM = os.path.join(BUILD, "bin/cournand")
STATION = os.path.join(BUILD, "test/records_station")


class Station:
    """Runs one station, which is started again after each kill and continues after its last reported session."""

    def __init__(self, number, folder, url, count):
        self.number, self.url, self.count = number, url, count
        self.file = os.path.join(folder, "station%d.db" % number)
        self.hold = os.path.join(folder, "hold")  # while this file exists, the station goes on shipping
        self.log = os.path.join(folder, "station%d.log" % number)
        self.process = None

    def stored(self):
        if not os.path.exists(self.log):
            return 0
        numbers = [int(line.split()[1]) for line in open(self.log) if line.startswith("stored ") and line[-1] == "\n"]
        return max(numbers) + 1 if numbers else 0

    def known(self):
        return sum(int(line.split()[3]) for line in open(self.log) if line.startswith("shipped "))

    def start(self):
        command = [STATION, self.file, self.url, str(self.number), str(self.stored()), str(self.count), self.hold]
        with open(self.log, "a") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=log)

    def is_done(self):
        return self.process.poll() == 0

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


def sessions(place):
    command = [PROGRAM, "records", "export", "--format", "json", "--records", place]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit("Bail out! " + done.stderr)
    return json.loads(done.stdout)["sessions"]


def kill(kind, rng, server, stations):
    """Kills one station, one connection or the whole server; a killed station or server is started again. Returns False
    if nothing of this kind was running."""
    if kind == "servers":
        server.kill()
        time.sleep(rng.uniform(0.0, 0.5))
        server.start()
        return True
    if kind == "stations":
        running = [station for station in stations if station.process.poll() is None]
        if running:
            station = rng.choice(running)
            station.kill()
            station.start()
        return bool(running)
    backends = server.backends()
    try:
        os.kill(rng.choice(backends), signal.SIGKILL)
    except (IndexError, ProcessLookupError):  # no connection at this moment
        return False
    return True


def run(stations_count, sessions_each, seed, kills):
    """Prints TAP; `kills` states the number of kills of each kind, which are made in a random order. The kills are
    distributed over the number of stored sessions, not over time, so that fast and slow machines suffer equally
    many."""
    rng = random.Random(seed)
    print("# seed %d" % seed)
    begun = time.monotonic()
    wanted = stations_count * sessions_each
    planned = [kind for kind, count in sorted(kills.items()) for _ in range(count)]
    rng.shuffle(planned)
    moments = sorted(rng.uniform(0.0, 0.9) * wanted for _ in planned)  # in stored sessions
    killed = collections.Counter()
    with tempfile.TemporaryDirectory(prefix="cournand-stations-") as folder, postgres_server.Server() as server:
        stations = [Station(number, folder, server.url, sessions_each) for number in range(stations_count)]
        open(stations[0].hold, "w").close()
        for station in stations:
            station.start()
        while not all(station.is_done() for station in stations):
            time.sleep(0.005)
            if time.monotonic() - begun > 550:
                logs = "".join(open(one.log).read()[-300:] for one in stations if not one.is_done())
                raise SystemExit("Bail out! the stations do not end: " + logs)
            for station in stations:
                if station.process.poll() not in (None, 0):
                    raise SystemExit("Bail out! a station gave up: " + open(station.log).read()[-2000:])
            if planned and sum(station.stored() for station in stations) >= moments[sum(killed.values())]:
                if kill(planned[0], rng, server, stations):
                    killed[planned.pop(0)] += 1
                if not planned:
                    os.remove(stations[0].hold)
        judge(server, stations, wanted, killed, kills)
    print("# %.0f s" % (time.monotonic() - begun))


def judge(server, stations, wanted, killed, kills):
    own = [session for station in stations for session in sessions(station.file)]
    central = sessions(server.url)
    repeats = sum(station.known() for station in stations)
    print("# killed: %(stations)d stations, %(connections)d connections, %(servers)d servers" % killed)
    print("# %d sessions were shipped a second time, and recognised" % repeats)
    counts = collections.Counter(session["id"] for session in central)
    by_id = {session["id"]: session for session in central}
    rows = server.query("SELECT (SELECT count(*) FROM metric), (SELECT count(*) FROM event)")
    claims = [
        (
            "all %d planned kills took place" % sum(kills.values()),
            killed == kills,
        ),
        ("the stations' own files have %d sessions (%d)" % (wanted, len(own)), len(own) == wanted),
        (
            "none is lost (%d)" % sum(session["id"] not in by_id for session in own),
            all(session["id"] in by_id for session in own),
        ),
        ("none is double (%d)" % sum(count > 1 for count in counts.values()), len(central) == wanted == len(counts)),
        ("each has the same contents at the server", all(by_id.get(session["id"]) == session for session in own)),
        ("no part of a session is lost or double (%s)" % rows, rows == "%d|%d" % (3 * wanted, 4 * wanted)),
    ]
    print("1..%d" % len(claims))
    for number, (claim, is_true) in enumerate(claims, 1):
        print("%s %d - %s" % ("ok" if is_true else "not ok", number, claim))
    if not all(is_true for _, is_true in claims):
        raise SystemExit(1)
