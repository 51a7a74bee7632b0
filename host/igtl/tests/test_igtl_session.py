#!/usr/bin/env python3
"""Tests that pyigtl, an OpenIGTLink client by other authors, receives a session as the session's report, picture and
replay show it. Clients that disturb the server change no bit of the session. Prints TAP."""

import json
import os
import random
import socket
import subprocess
import sys
import tempfile
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.normpath(os.path.join(HERE, "..", "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "host", "python", "tests"))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import prepare  # noqa: E402
import tap  # noqa: E402

REQUIREMENTS = os.path.join(HERE, "requirements.txt")
if os.environ.get("COURNAND_IGTL_TEST") != "1":
    os.makedirs(os.path.join(prepare.BUILD, "igtl"), exist_ok=True)
    PYTHON = prepare.environment(os.path.join(prepare.BUILD, "igtl", "venv"), REQUIREMENTS)
    sys.stdout.flush()
    os.execve(PYTHON, [PYTHON, os.path.abspath(__file__)], dict(os.environ, COURNAND_IGTL_TEST="1"))

import numpy as np  # noqa: E402
import pyigtl  # noqa: E402

PROGRAM = os.path.join(prepare.BUILD, "bin", "cournand")
SIZE = 256
SCRIPT = """needs scene aorta
needs tool j_wire
begin inserted 5 mm
follow tip
fluoro on
c-arm LAO 20 CRA 10
advance 90 mm at 60 mm/s while rotate 90 deg
follow off
advance 40 mm at 60 mm/s
wait %s s
"""
FLOAT_MM = 2e-4  # messages hold 32-bit floats: 6e-5 mm at 1 m
TO_RAS = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])  # docs/slicer.md


class Watcher:
    """Collects every message that pyigtl gives, by the name of the device, until the server ends."""

    def __init__(self, port):
        self.seen = {}
        self.client = pyigtl.OpenIGTLinkClient("127.0.0.1", port)
        self.must_end = False
        self.thread = threading.Thread(target=self.watch)
        self.thread.start()

    def watch(self):
        while not self.must_end:
            self.take()
            time.sleep(0.002)

    def take(self):
        for message in self.client.get_latest_messages():
            self.seen.setdefault(message.device_name, []).append(message)

    def end(self):
        """Waits a moment, so that the client reads what the server sent before it ended."""
        time.sleep(0.3)
        self.must_end = True
        self.thread.join()
        self.client.stop()
        self.take()
        return self.seen


def silence(port):
    """A client that never reads."""
    deaf = socket.socket()
    deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    deaf.connect(("127.0.0.1", port))
    return deaf


def noise(port):
    """A client that sends random bytes and never reads."""
    noisy = socket.socket()
    noisy.connect(("127.0.0.1", port))
    noisy.setblocking(False)
    try:
        noisy.send(random.Random(23).randbytes(200000))
    except BlockingIOError:
        pass
    return noisy


def run(words):
    words = [PROGRAM] + words
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)


def run_well(words):
    ended = run(words)
    if ended.returncode != 0:
        sys.exit(ended.stdout)


class Session:
    """Runs one session twice: without the server, and with the server and its clients."""

    def __init__(self, folder):
        self.folder = folder
        self.script = self.path("watched.session")
        self.write_script()
        run_well(self.words("alone"))
        self.watched, self.seen = self.watch()
        self.report = self.json("watched")
        self.tick = self.report["ticks"]

    def path(self, name):
        return os.path.join(self.folder, name)

    def words(self, name):
        words = ["run", self.script, "--quiet", "--size", str(SIZE), "--json", self.path(name + ".json")]
        return words + ["--record", self.path(name + ".rec"), "--png", self.path(name + ".png")]

    def json(self, name):
        with open(self.path(name + ".json"), encoding="utf-8") as file:
            return json.load(file)

    def bytes(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def write_script(self):
        """Makes the session end at a full second. At a full second the session makes a picture, so the last pose and
        the report belong to the same tick."""
        rest_s = 0.5
        for is_measured in (False, True):
            if is_measured:
                run_well(self.words("alone")[:-2])  # without a picture
                rest_s += -self.json("alone")["ticks"] % 1000 / 1000.0
            with open(self.script, "w", encoding="ascii") as file:
                file.write(SCRIPT % rest_s)

    def watch(self):
        words = [PROGRAM] + self.words("watched") + ["--igtl", "0"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as program:
            told = program.stdout.readline()
            port = int(told.split("127.0.0.1:")[1].split(",")[0])
            others = [silence(port), noise(port)]
            watcher = Watcher(port)
            rest = program.stdout.read()
        seen = watcher.end()
        for other in others:
            other.close()
        return (program.returncode, told, rest), seen

    def last(self, name):
        return self.seen[name][-1]

    def picture(self, name):
        """Returns the pixels (row, column, colour) of a PNG file, read by ffmpeg."""
        words = ["ffmpeg", "-v", "error", "-i", self.path(name), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
        raw = subprocess.run(words, stdout=subprocess.PIPE, check=True).stdout
        return np.frombuffer(raw, dtype=np.uint8).reshape(SIZE, SIZE, 3)


def open_display():
    """Starts a virtual display, and returns its process and its display name."""
    read, write = os.pipe()
    words = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x1024x24", "-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(words, pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as pipe:
        return server, ":" + pipe.readline().strip()


def tick_of(message):
    return round(message.timestamp * 1000)


def complain(*words):
    print("#", *words)
    return False


def the_session_ends_well_and_says_where_it_can_be_watched():
    code, told, rest = SESSION.watched
    good = code == 0 and told.startswith("OpenIGTLink: waits for clients at 127.0.0.1:")
    return good and "from this machine only" in told or complain(code, told, rest)


def report_recording_and_picture_are_those_of_the_session_without_the_server():
    same = [SESSION.bytes("alone." + end) == SESSION.bytes("watched." + end) for end in ("rec", "png", "json")]
    return all(same) or complain("rec, png, json:", same)


def the_tip_is_where_the_report_says_at_the_same_tick():
    tip = SESSION.last("Tool1Tip")
    expected = TO_RAS @ np.array(SESSION.report["tip"]["position_mm"])
    off = np.abs(tip.matrix[:3, 3] - expected).max()
    if tick_of(tip) != SESSION.tick or off > FLOAT_MM:
        return complain("tick", tick_of(tip), SESSION.tick, "off by", off, "mm, allowed", FLOAT_MM)
    turn = tip.matrix[:3, :3]
    return np.allclose(turn.T @ turn, np.eye(3), atol=1e-6) and np.linalg.det(turn) > 0.999


def the_tip_moves_while_the_session_runs():
    ticks = [tick_of(message) for message in SESSION.seen["Tool1Tip"]]
    heights = [message.matrix[2, 3] for message in SESSION.seen["Tool1Tip"]]
    print("# %d poses, from tick %d to tick %d" % (len(ticks), ticks[0], ticks[-1]))
    return len(ticks) >= 3 and ticks == sorted(ticks) and max(heights) - min(heights) > 5.0


def the_c_arm_turns_to_its_angles():
    """At LAO 20 CRA 10 the detector is at the front, towards the patient's left and head."""
    primary, secondary = np.radians([20.0, 10.0])
    to_detector = [np.sin(primary) * np.cos(secondary), np.sin(secondary), np.cos(primary) * np.cos(secondary)]
    off = np.abs(SESSION.last("CArm").matrix[:3, 2] - TO_RAS @ np.array(to_detector)).max()
    return off < 1e-6 or complain("off by", off)


def the_picture_is_that_of_the_session():
    """The picture in the PNG file is partly covered by texts and curves, but its middle is free."""
    image = SESSION.last("Fluoroscopy").image
    shown = SESSION.picture("watched.png")
    if image.shape != (1, SIZE, SIZE) or image.dtype != np.uint8:
        return complain(image.shape, image.dtype)
    same = (shown == image[0][:, :, None]).all(axis=2)
    middle = same[SIZE // 3 : SIZE // 2, SIZE // 4 : 3 * SIZE // 4]
    print("# %.1f %% of all pixels are equal" % (100.0 * same.mean()))
    return middle.all() and image.std() > 10.0


def the_pixel_in_line_with_source_and_tip_shows_the_wire():
    """The X-ray source is 750 mm behind the isocentre on the C-arm's axis (docs/slicer.md)."""
    image = SESSION.last("Fluoroscopy")
    place = image.ijk_to_world_matrix
    source = (SESSION.last("CArm").matrix @ np.array([0.0, 0.0, -750.0, 1.0]))[:3]
    ray = SESSION.last("Tool1Tip").matrix[:3, 3] - source
    # source + t * ray = origin + i * column + j * row
    i, j, _ = np.linalg.solve(np.column_stack([place[:3, 0], place[:3, 1], -ray]), source - place[:3, 3])
    column, row = round(i), round(j)
    pixels = image.image[0].astype(float)
    near = pixels[row - 2 : row + 3, column - 2 : column + 3].min()
    round_about = np.median(pixels[row - 20 : row + 21, column - 20 : column + 21])
    print("# the tip is at column %.1f, row %.1f: grey %.0f, median round about %.0f" % (i, j, near, round_about))
    is_beside_the_middle = abs(row - SIZE / 2) > 20
    return (
        near < round_about - 30.0 and is_beside_the_middle and abs(np.linalg.norm(place[:3, 0]) - 320.0 / SIZE) < 1e-4
    )


def a_port_in_use_ends_the_program_before_the_first_tick():
    with socket.socket() as taken, tempfile.TemporaryDirectory() as folder:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port, record = taken.getsockname()[1], os.path.join(folder, "a.rec")
        ended = run(["run", "demo", "--igtl", str(port), "--record", record])
        good = ended.returncode == 1 and "127.0.0.1:%d: Address already in use" % port in ended.stdout
        return good and "Remedy:" in ended.stdout and not os.listdir(folder) or complain(ended.stdout)


def a_wrong_address_is_wrong_usage():
    ended = run(["run", "demo", "--igtl", "65536"])
    return ended.returncode == 2 and "'65536' is not PORT, HOST:PORT" in ended.stdout or complain(ended.stdout)


def a_replay_shows_the_same_tip():
    words = [PROGRAM, "replay", SESSION.path("watched.rec"), "--igtl", "127.0.0.1:0", "--size", "64", "--verify"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as program:
        watcher = Watcher(int(program.stdout.readline().split("127.0.0.1:")[1].split(",")[0]))
        said = program.stdout.read()
    tip, first = watcher.end()["Tool1Tip"][-1], SESSION.last("Tool1Tip")
    same = tick_of(tip) == tick_of(first) and (tip.matrix == first.matrix).all()
    return same and program.returncode == 0 and "verified:" in said or complain(said)


def the_window_shows_its_session_too():
    server, name = open_display()
    words = [PROGRAM, "view", "--scene", "aorta", "--tool", "j_wire", "--no-record", "--fluoro", "--frames", "60"]
    words += ["--size", "64", "--igtl", "0"]
    try:
        with subprocess.Popen(
            words,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=dict(os.environ, DISPLAY=name),
        ) as program:
            watcher = Watcher(int(program.stdout.readline().split("127.0.0.1:")[1].split(",")[0]))
            said = program.stdout.read()
    finally:
        server.kill()
        server.wait()
    seen = watcher.end()
    good = program.returncode == 0 and {"Tool1Tip", "CArm", "Fluoroscopy"} <= set(seen)
    return good and seen["Fluoroscopy"][-1].image.std() > 5.0 and tick_of(seen["Tool1Tip"][-1]) >= 900 or complain(said)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as WORK:
        SESSION = Session(WORK)
        tap.run(
            [
                the_session_ends_well_and_says_where_it_can_be_watched,
                report_recording_and_picture_are_those_of_the_session_without_the_server,
                the_tip_is_where_the_report_says_at_the_same_tick,
                the_tip_moves_while_the_session_runs,
                the_c_arm_turns_to_its_angles,
                the_picture_is_that_of_the_session,
                the_pixel_in_line_with_source_and_tip_shows_the_wire,
                a_port_in_use_ends_the_program_before_the_first_tick,
                a_wrong_address_is_wrong_usage,
                a_replay_shows_the_same_tip,
                the_window_shows_its_session_too,
            ]
        )
