#!/usr/bin/env python3
"""Tests how programs write and read files from a user's point of view. Programs check their output paths before long
work begins and read a scene only with its own bodies. Programs never report a truncated recording as verified. No text
from a file can move the terminal's cursor. Prints TAP.

The good inputs, and the class that runs the test cases, come from test_bad_input.py."""
import os
import re
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import test_bad_input as bad  # noqa: E402

BODY = '[[body]]\nname = "%s"\nmesh = "lumen"\nmaterial = "cortical_bone"\n'
# The text has a title, a red line over the last line, a C1 control character, and a letter that reverses the
# direction of writing.
HOSTILE = "\x1b]0;owned\x07\x1b[31m\x9b2J\u202ex"
ALLOWED = re.compile(rb"[\x00-\x09\x0b-\x1f\x7f]|\xc2[\x80-\x9f]|\xe2\x80[\xa8-\xae]|\xe2\x81[\xa6-\xa9]")


def bake(name, *more):
    return ["bake", name + ".toml", "-o", name + ".scene", "--poses", "0", "--points", "100", *more]


def run_in(name, *more):
    return bad.session_run(scene=name + ".scene", more=["--size", "64", *more])


# --- outputs ---------------------------------------------------------------------------------------------------------
def outputs(bench):
    bench.write("good.session", bad.SESSION)
    bench.write("good.scene", bad.scene_file())
    for option in ("--record", "--json", "--score", "--png", "--png16", "--mp4", "--dicom"):
        bench.bad("an empty %s is refused as usage" % option, bad.session_run(more=[option, ""]), 2,
                  "%s.* is empty" % option)
        bench.bad("%s into a missing folder is refused before the first tick" % option,
                  bad.session_run(more=["--record", "early.rec", option + "=good.session/x/y"
                                        if option == "--dicom" else option + "=no/x"]
                                  if option != "--record" else ["--png", "early.rec", option, "no/x"]),
                  1, "cannot be written", "early.rec")
    bench.bad("an empty scene is refused as usage", bad.session_run(scene=""), 2, "--scene.* is empty")
    bench.good("a recording to replay", bad.session_run(more=["--record", "good.rec"]))
    for option in ("--png", "--png16", "--mp4", "--dicom"):
        bench.bad("a replay with an empty %s is refused as usage" % option,
                  ["cournand", "replay", "good.rec", option, ""], 2, "%s.* is empty" % option)
    bench.bad("a replay into a missing folder is refused at once",
              ["cournand", "replay", "good.rec", "--png", "no/x.png"], 1, "no/x.png: cannot be written")
    for option in ("--record", "--screenshot", "--dicom"):
        bench.bad("a window with an empty %s is refused as usage" % option,
                  ["cournand", "view", "--instrument", bad.WIRE, option, ""], 2, "%s.* is empty" % option)
    bench.bad("a window with a recording into a missing folder is refused before it opens",
              ["cournand", "view", "--instrument", bad.WIRE, "--record", "no/x.rec"], 1, "no/x.rec: cannot be written")
    bench.write("lumen.stl", bad.stl(bad.LUMEN))
    bench.write("good.toml", bad.scene_text())
    bench.bad("a bake into an empty name is refused as usage", ["bake", "good.toml", "-o", ""], 2, "output.* is empty")
    bench.bad("a bake with its surface in a missing folder is refused first", bake("good", "--surface", "no/x.ply"),
              1, "no/x.ply: cannot be written")
    bench.bad("an anatomy into an empty folder name is refused as usage", ["anatomy", "phantom", "-o", ""], 2,
              "output.* is empty")


def read_only(bench):
    """Tests output paths at which no file can be written. The paths are in /proc, because /proc refuses even root, who
    may write almost everywhere else."""
    bench.bad("a recording where nobody may write is refused", bad.session_run(more=["--record", "/proc/x.rec"]), 1,
              "/proc/x.rec: cannot be written")
    bench.bad("a score where nobody may write is refused before the first tick",
              bad.session_run(more=["--record", "early.rec", "--score", "/proc/x.html"]), 1,
              "/proc/x.html: cannot be written", "early.rec")


# --- a scene and its bodies ------------------------------------------------------------------------------------------
def pairs(bench):
    bench.write("lumen.stl", bad.stl(bad.LUMEN))
    bench.write("one.toml", bad.scene_text(body=BODY % "bone"))
    bench.write("two.toml", bad.scene_text(name='"another"', body=BODY % "bone"))
    bench.write("good.session", bad.SESSION)
    bench.good("one scene is baked with its bodies", bake("one"))
    bench.good("another scene is baked with its bodies", bake("two"))
    bench.good("a scene is run with its own bodies", run_in("one", "--png", "x.png", "--record", "one.rec"))
    strangers = r"two\.bodies: these bodies were not baked with one\.scene.*CRC-32.*bake one\.scene again.*--bodies"
    bench.bad("a run with another scene's bodies is refused",
              run_in("one", "--png", "x.png", "--bodies", "two.bodies"), 1, strangers)
    bench.bad("a run that makes no picture is refused alike, for it names the branch of every tip",
              run_in("one", "--json", "x.json", "--bodies", "two.bodies"), 1,
              strangers)
    bench.bad("a replay with another scene's bodies is refused",
              ["cournand", "replay", "one.rec", "--size", "64", "--png", "x.png", "--bodies", "two.bodies"], 1,
              strangers)
    shutil.copy(os.path.join(bench.folder, "two.bodies"), os.path.join(bench.folder, "one.bodies"))
    bench.bad("another scene's bodies under its name are refused too", run_in("one", "--png", "x.png"), 1,
              "one.bodies: these bodies were not baked with")
    old = bench.read("two.bodies")
    bench.write("two.bodies", without_partner(old))
    bench.bad("bodies of an older bake are refused with what to do", run_in("two", "--png", "x.png"), 1,
              "does not say which scene.*bake two.scene again")
    full_disk(bench)


def without_partner(data):
    """Returns the body file as an older version of bake wrote it, without the last section and without this section's
    row in the table."""
    count = struct.unpack_from("<I", data, 20)[0]
    table = [list(struct.unpack_from("<4I", data, 32 + 16 * i)) for i in range(count)]
    assert table[-1][0] == 19 and table[-1][2] == 8, table
    parts = [data[row[1] : row[1] + row[2]] for row in table[:-1]]
    offset, rows, body = 32 + 16 * len(parts), b"", b""
    for row, part in zip(table, parts):
        rows += struct.pack("<4I", row[0], offset + len(body), len(part), zlib.crc32(part))
        body += part + b"\0" * (-len(part) % 16)
    header = lambda crc: struct.pack("<8s2H5I", b"CRN-SCN\0", 1, 1, 2, offset + len(body), len(parts), crc, 0)
    return header(zlib.crc32(header(0) + rows)) + rows + body


def full_disk(bench):
    """Tests a disk that has space for the file of bodies but not for the scene. The program must keep both old files,
    and must leave no other file behind."""
    bench.good("the scene is baked before the disk is full", bake("one"))
    before = {name: bench.read(name) for name in ("one.scene", "one.bodies")}
    room = (len(before["one.bodies"]) + len(before["one.scene"])) // 2
    findings = []
    if len(before["one.bodies"]) + 1000 > len(before["one.scene"]):
        findings.append("the sample's scene must be the larger file")
    bench.write("one.toml", bad.scene_text(name='"renamed"', body=BODY % "rib"))
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))
    done = subprocess.run([os.path.join(bad.BIN, "bake"), *bake("one")[1:]], cwd=bench.folder, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT,
                          preexec_fn=limit, check=False)
    said = done.stdout.decode("utf-8", "replace")
    if done.returncode != 1 or "make room on the disk" not in said:
        findings.append("exit code %s: %s" % (done.returncode, said[-500:]))
    findings += ["%s has changed" % name for name, data in before.items() if bench.read(name) != data]
    findings += ["%s was left" % name for name in os.listdir(bench.folder) if ".part" in name]
    bench.report.check("a bake on a full disk leaves the old scene and the old bodies", findings)


# --- recordings ------------------------------------------------------------------------------------------------------
def chunks(data):
    """Yields the pair (kind, payload) of every chunk of a recording (docs/session.md)."""
    at = 8
    while at < len(data):
        kind, size = struct.unpack_from("<2I", data, at)
        yield kind, data[at + 8 : at + 8 + size]
        at += 12 + size


def sealed(parts):
    out = b"CRN-REC6"
    for kind, payload in parts:
        head = struct.pack("<2I", kind, len(payload))
        out += head + payload + struct.pack("<I", zlib.crc32(head + payload))
    return out


def recordings(bench):
    good = bench.read("good.rec")
    bench.good("a whole recording is verified", ["cournand", "replay", "good.rec", "--verify"])
    parts = list(chunks(good))
    bench.write("cut.rec", sealed([part for part in parts if part[0] != 6]))
    bench.bad("a recording without its end is not verified, though every tick of it agrees",
              ["cournand", "replay", "cut.rec", "--verify"], 1,
              r"verified up to tick \d+, but the recording was cut off")
    bench.write("torn.rec", good[:-30])
    bench.bad("nor is one that was torn off in a chunk", ["cournand", "replay", "torn.rec", "--verify"], 1, "cut off")
    bench.good("it is replayed all the same where nobody asks for a proof", ["cournand", "replay", "cut.rec"])


def old_recordings(bench):
    """Tests that the program refuses a recording of the previous protocol version and names the remedy. The program
    must convert an old recording completely or not at all."""
    with open(os.path.join(bad.tree.ROOT, "host", "session", "tests", "protocol_4.rec"), "rb") as file:
        old = file.read()
    bench.write("old.rec", old)
    upgrade = ["cournand", "replay", "--upgrade"]
    remedy = r"version '3'.*cournand replay --upgrade old\.rec -o NEW\.rec"
    for command in ("replay", "info", "surface"):
        more = ["-o", "old.obj", "--at", "0"] if command == "surface" else []
        bench.bad(
            "%s names what converts an old recording" % command, ["cournand", command, "old.rec"] + more, 1, remedy
        )
    bench.good("an old recording is converted", upgrade + ["old.rec", "-o", "converted.rec"])
    bench.good("what was converted can be read", ["cournand", "info", "converted.rec"])
    bench.bad(
        "and is played by the core that made it",
        ["cournand", "replay", "converted.rec", "--verify"],
        1,
        r"made by core version 15, this device has version \d+.*use the release that recorded it",
    )
    bench.bad("it is not converted again", upgrade + ["converted.rec", "-o", "again.rec"], 1, "already", "again.rec")
    bench.write("damaged.rec", old[:20000] + bytes([old[20000] ^ 1]) + old[20001:])
    bench.bad(
        "a damaged old recording is not converted", upgrade + ["damaged.rec", "-o", "no.rec"], 1, "damaged", "no.rec"
    )
    bench.bad("nor is one onto itself", upgrade + ["old.rec", "-o", "old.rec"], 2, "overwrite")
    bench.bad("a conversion needs a name for the new one", upgrade + ["old.rec"], 2, "output")
    findings = [] if bench.read("old.rec") == old else ["old.rec has changed"]
    bench.report.check("the old recording stays as it was", findings)


# --- text from files -------------------------------------------------------------------------------------------------
def text_field(text):
    data = text.encode("utf-8", "surrogateescape")
    return struct.pack("<H", len(data)) + data


def hostile_recording(good):
    """Returns a recording whose scene path, script path and tool name contain characters that move a terminal's
    cursor."""
    (kind, head), *rest = list(chunks(good))
    at, fields = 20, []
    for _ in range(2):
        size = struct.unpack_from("<H", head, at)[0]
        fields.append(head[at + 2 : at + 2 + size])
        at += 2 + size
    tools = head[at : at + 1]
    size = struct.unpack_from("<H", head, at + 1)[0]
    tail = head[at + 3 + size :]
    changed = head[:20] + text_field(HOSTILE + "scene") + text_field(HOSTILE + "session") + tools
    changed += text_field(HOSTILE + "\nwire") + tail
    return sealed([(kind, changed)] + rest)


def shows_clean(bench, name, command, expected=None):
    program = os.path.join(bad.BIN, command[0])
    done = subprocess.run([program] + command[1:], cwd=bench.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT,
                          check=False, timeout=bad.TIME_LIMIT_S)
    found = ALLOWED.findall(done.stdout)
    findings = ["it prints %r in %r" % (found[:4], done.stdout[-600:])] if found else []
    if expected and not re.search(expected, done.stdout.decode("utf-8", "replace")):
        findings.append("it does not print /%s/: %r" % (expected, done.stdout[-600:]))
    bench.report.check(name, findings)


def hostile_texts(bench):
    bench.write("evil.rec", hostile_recording(bench.read("good.rec")))
    shown = r"\\x1b\]0;owned\\x07"
    shows_clean(bench, "info shows a recording's names as letters", ["cournand", "info", "evil.rec"], shown)
    shows_clean(bench, "a replay shows a tool's name as letters",
                ["cournand", "replay", "evil.rec", "--scene", "good.scene"], shown)
    shows_clean(bench, "a scene that is not where a recording says is told in letters",
                ["cournand", "replay", "evil.rec"], shown)
    with open(bad.WIRE, encoding="utf-8") as file:
        wire = file.read()
    name = r'"\u001b]0;owned\u0007\u001b[31m wire"'
    bench.write("evil.toml", re.sub(r'^name = ".*"$', lambda _: "name = " + name, wire, count=1, flags=re.M))
    shows_clean(bench, "an instrument's name is shown as letters", ["cournand", "info", "evil.toml"], shown)
    shows_clean(bench, "so it is in the list of instruments", ["cournand", "instruments", "evil.toml"])
    shows_clean(bench, "and at the end of a run", bad.session_run(wire="evil.toml"), shown)
    bench.write("evil.session", "advance 10 mm\n%s 3 mm\n" % HOSTILE)
    shows_clean(bench, "a word of a script is shown as letters", bad.session_run(session="evil.session"), r"\\x1b")
    bench.write("evil_scene.toml", bad.scene_text(body=BODY.replace('"%s"',
        r'"\u001b[31mbone"') + 'inside = "\\u001b[2Jskin"\n'))
    shows_clean(bench, "a body's name is refused by bake in letters", ["bake", "evil_scene.toml", "-o", "evil.scene"],
                "holds a control character")
    bench.write("evil_key.toml", bad.scene_text(more='"\\u001b[31mkey" = 1'))
    shows_clean(bench, "so is a key that nobody knows", ["bake", "evil_key.toml", "-o", "evil.scene"], r"\\x1b")
    bench.write("evil.mrk.json", bad.curve([4.0] * 8).replace('"Curve"', r'"\u001b[31mCurve"'))
    bench.write("evil_line.toml", bad.scene_text(mesh='centrelines = ["evil.mrk.json"]', unit="", position="[0, 5, 0]"))
    shows_clean(bench, "and a word of a centreline's file", ["bake", "evil_line.toml", "-o", "evil.scene"])


def main():
    if not os.path.isdir(bad.BIN):
        print("1..1\nnot ok 1 - the programs are built\n# %s does not exist: run `make`" % bad.BIN)
        return 1
    folder = tempfile.mkdtemp()
    try:
        bench = bad.Bench(folder)
        outputs(bench)
        read_only(bench)
        pairs(bench)
        recordings(bench)
        old_recordings(bench)
        hostile_texts(bench)
        bench.report.end()
    finally:
        shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
