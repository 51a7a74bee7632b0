#!/usr/bin/env python3
"""These tests check the following. Every picture in README and docs stores the version of the core and the
command that made it. No picture is older than its inputs."""

import os
import shutil
import struct
import sys
import tempfile
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "..", "docs"))
import pictures  # noqa: E402

JPEG = b"\xff\xd8\xff\xe0\x00\x04ab\xff\xda\x00\x02scan\xff\xd9"


def png():
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0))
        + chunk(b"IDAT", zlib.compress(b"\0\0"))
        + chunk(b"IEND", b"")
    )


class Tap:
    def __init__(self):
        self.count, self.failed = 0, 0

    def claim(self, ok, name, why=""):
        self.count += 1
        self.failed += not ok
        print("%sok %d - %s" % ("" if ok else "not ", self.count, name))
        for line in [] if ok else why.splitlines():
            print("# " + line)


def sample(folder):
    """Makes a manifest with one picture of a session, and the file of this picture with its stamp (core version and
    command)."""
    session, picture = os.path.join(folder, "a.session"), os.path.join(folder, "a.jpg")
    with open(session, "w", encoding="utf-8") as file:
        file.write("advance 10 mm\n")
    with open(picture, "wb") as file:
        file.write(JPEG)
    manifest = {
        "film": {"a": {"scene": "s", "tools": [], "session": session, "tip": "ascending aorta"}},
        "picture": [{"file": picture, "film": "a", "frames": [1]}],
    }
    entry = manifest["picture"][0]
    pictures.put_stamp(
        picture,
        {
            "core": "14",
            "command": pictures.command_of(manifest, entry),
            "inputs": pictures.inputs_hash(manifest, entry),
            "shows": "ascending aorta",
        },
    )
    return manifest, session, picture


def check_rules(tap):
    """The test first shows that each rule finds the fault in a bad sample."""
    with tempfile.TemporaryDirectory() as folder:
        manifest, session, picture = sample(folder)
        linked = {picture}
        tap.claim(pictures.problems(manifest, linked, "14") == [], "a picture with today's stamp is current")
        tap.claim(
            "made by core 14" in str(pictures.problems(manifest, linked, "15")), "a picture of an older core is refused"
        )
        still = dict(manifest, picture=[dict(manifest["picture"][0], still=True)])
        tap.claim(
            "made by core 14" not in str(pictures.problems(still, linked, "15")),
            "a picture without a tool may be of an older core",
        )
        shell = dict(manifest, picture=[{"file": picture, "shell": ["true"]}])
        tap.claim(
            "made by core 14" in str(pictures.problems(shell, linked, "15")),
            "a picture of a window or a program is refused, too, when an older core made it",
        )
        tap.claim(
            "shown in the documents but" in str(pictures.problems(manifest, linked | {"b.jpg"}, "14")),
            "a picture that nothing makes is refused",
        )
        tap.claim(
            "shown in no document" in str(pictures.problems(manifest, set(), "14")),
            "a picture that nobody shows is refused",
        )
        with open(session, "a", encoding="utf-8") as file:
            file.write("advance 20 mm\n")
        tap.claim(
            "changed since" in str(pictures.problems(manifest, linked, "14")),
            "a picture of an older session is refused",
        )
        manifest, session, picture = sample(folder)
        pictures.put_stamp(picture, dict(pictures.read_stamp(picture), shows="left subclavian artery"))
        tap.claim(
            "instead of 'ascending aorta'" in str(pictures.problems(manifest, linked, "14")),
            "a picture of the wrong vessel is refused",
        )
        with open(picture, "wb") as file:
            file.write(JPEG)
        tap.claim("no stamp" in str(pictures.problems(manifest, linked, "14")), "a picture without a stamp is refused")
        check_stamps(tap, folder)


def check_moments(tap):
    report = {
        "ticks": 60000,
        "expected": [{"at_s": 12.5}],
        "room": {
            "irradiations": [
                {"kind": "fluoroscopy", "run": 0, "begin_s": 0.0, "end_s": 9.0},
                {"kind": "fluoroscopy", "run": 0, "begin_s": 20.0, "end_s": 22.0},
                {"kind": "cine", "run": 2, "begin_s": 40.0, "end_s": 44.0},
            ]
        },
    }
    maker = pictures.Maker({})
    maker.reports["a"] = report
    picture = {"file": "a.jpg", "film": "a"}
    found = [maker.moment(picture, at) for at in (7.5, "expect 1", "run 2 at 1.5", "fluoroscopy 2 at 1.5", "end")]
    tap.claim(
        found == [7.5, 12.5, 41.5, 21.5, 59.9],
        "a moment is seconds, an expectation, a place in a run or in a fluoroscopy, or the end",
        str(found),
    )
    for at, why in (
        (67.3, "ends after 60.0 s"),
        ("run 2 at 5", "no X-ray run 2"),
        ("run 1 at 1", "no X-ray run 1"),
        ("fluoroscopy 2 at 3", "no X-ray fluoroscopy 2"),
        ("soon", "is no moment"),
    ):
        try:
            tap.claim(False, "no picture is taken at %s" % at, "at %s s" % maker.moment(picture, at))
        except pictures.PictureError as error:
            tap.claim(why in str(error), "no picture is taken at %s" % at, str(error))


def check_stamps(tap, folder):
    fields = {"core": "14", "command": "make run", "inputs": "0123456789ab", "shows": "-"}
    for name, data in (("a.jpg", JPEG), ("a.png", png())):
        path = os.path.join(folder, name)
        with open(path, "wb") as file:
            file.write(data)
        for core in ("13", "14"):  # the second replaces the first
            pictures.put_stamp(path, dict(fields, core=core))
        grown = os.path.getsize(path) - len(data)
        tap.claim(
            pictures.read_stamp(path) == fields and grown < 120,
            "a stamp in %s is read as it was written" % name[2:].upper(),
        )
    shutil.rmtree(folder, ignore_errors=True)


def main():
    tap = Tap()
    check_rules(tap)
    check_moments(tap)
    found = pictures.problems(
        pictures.read_manifest(), pictures.linked_pictures(pictures.documents()), pictures.core_version()
    )
    tap.claim(not found, "every picture of README and docs is current", "\n".join(found))
    print("1..%d" % tap.count)
    return 1 if tap.failed else 0


if __name__ == "__main__":
    sys.exit(main())
