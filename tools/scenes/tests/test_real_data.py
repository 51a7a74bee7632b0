#!/usr/bin/env python3
"""These tests check the following. Data of a real patient are taken from the mirror if they have the SHA-256 of the
list, else from the network; an interrupted download goes on, and wrong data are refused with a remedy. The list names
every file that the patients' scenes use, with address, licence and credit. Prints TAP.

A server of this test on 127.0.0.1 stands in for the network.
"""

import functools
import hashlib
import http.server
import os
import re
import sys
import tempfile
import threading

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools", "scenes"), os.path.join(ROOT, "tools", "check")]
import real_patient  # noqa: E402
import tree  # noqa: E402

DATA = bytes(range(256)) * 40
ENTRY = {"name": "bone.stl", "remote": "a bone (1).stl", "bytes": len(DATA), "sha256": hashlib.sha256(DATA).hexdigest()}


class Quiet(http.server.SimpleHTTPRequestHandler):
    asked = []

    def do_GET(self):
        Quiet.asked.append(self.headers.get("Range"))
        wanted = re.fullmatch(r"bytes=(\d+)-", self.headers.get("Range") or "")
        if not wanted:
            return super().do_GET()
        with open(self.translate_path(self.path), "rb") as file:
            rest = file.read()[int(wanted[1]) :]
        self.send_response(206)
        self.send_header("Content-Length", str(len(rest)))
        self.end_headers()
        return self.wfile.write(rest)

    def log_message(self, *_):
        pass


class Place:
    """A mirror, a server's folder and a goal, all empty."""

    def __init__(self, folder, address):
        self.mirror, self.goal = os.path.join(folder, "mirror"), os.path.join(folder, "goal")
        self.source = {"folder": "set", "address": address}
        self.file = os.path.join(self.goal, "set", "bone.stl")

    def write(self, folder, data, name="bone.stl"):
        os.makedirs(os.path.join(folder, "set"), exist_ok=True)
        with open(os.path.join(folder, "set", name), "wb") as file:
            file.write(data)

    def take(self):
        try:
            return real_patient.take(self.source, ENTRY, self.mirror, self.goal)
        except real_patient.Fault as fault:
            return str(fault)

    def holds_the_data(self):
        return real_patient.hash_of(self.file) == ENTRY["sha256"]


def wrong(got, *expected):
    return [] if all(part in got for part in expected) else ["'%s' does not hold %s" % (got, list(expected))]


def check_taking(report, folder, address):
    place = Place(os.path.join(folder, "a"), address)
    place.write(place.mirror, DATA)
    came = [place.take(), place.take()]
    report.check("a file comes from the mirror once", [] if came == ["mirror", "here"] else [str(came)])
    place = Place(os.path.join(folder, "b"), address)
    place.write(place.mirror, b"another file")
    came = place.take()
    report.check("a wrong file in the mirror is passed over", [] if came == "network" else [came])
    place = Place(os.path.join(folder, "c"), address)
    place.write(place.goal, DATA[:5000], "bone.stl.part")
    Quiet.asked.clear()
    came = place.take()
    well = came == "network" and place.holds_the_data() and Quiet.asked == ["bytes=5000-"]
    report.check("an interrupted download goes on where it stopped", [] if well else [came, str(Quiet.asked)])


def check_refusals(report, folder, address):
    place = Place(os.path.join(folder, "d"), address + "wrong/")
    faults = wrong(place.take(), "its SHA-256 is", ENTRY["sha256"], "DATA=FOLDER")
    report.check("a file that has changed at its source is refused", faults)
    report.check("and is not kept", [f for f in (place.file, place.file + ".part") if os.path.exists(f)])
    place = Place(os.path.join(folder, "e"), "http://127.0.0.1:9/")
    faults = wrong(place.take(), "bone.stl is not there", "127.0.0.1:9/a%20bone%20%281%29.stl", "DATA=FOLDER")
    report.check("without mirror and network the message names file, address and remedy", faults)


def check_list(report):
    faults = []
    for patient, ending in (("male", ""), ("female", "_female")):
        with open(os.path.join(ROOT, "shared/examples/real_patient%s.toml" % ending), encoding="utf-8") as file:
            used = set(re.findall(r'"data:([^"]+)"', file.read()))
        sources = real_patient.sources_of(patient)
        listed = {source["folder"] + "/" + entry["name"] for source in sources for entry in source["file"]}
        faults += ["%s: %s is used, not listed" % (patient, name) for name in sorted(used - listed)]
        faults += [source["folder"] for source in sources if not (source["licence"] and source["credit"])]
    report.check("the list names every file of both patients, with licence and credit", faults)


def main():
    with tempfile.TemporaryDirectory() as folder:
        served = os.path.join(folder, "served")
        os.makedirs(os.path.join(served, "wrong"))
        for name, data in (("a bone (1).stl", DATA), ("wrong/a bone (1).stl", DATA[::-1])):
            with open(os.path.join(served, name), "wb") as file:
                file.write(data)
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=served))
        threading.Thread(target=server.serve_forever, daemon=True).start()
        report = tree.Report()
        address = "http://127.0.0.1:%d/" % server.server_port
        check_taking(report, folder, address)
        check_refusals(report, folder, address)
        check_list(report)
        server.shutdown()
        report.end()


if __name__ == "__main__":
    main()
