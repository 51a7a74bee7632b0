#!/usr/bin/env python3
"""Tests how the programs refuse malformed files and command lines. Every program must end with the documented exit code
(1 for unusable input, 2 for usage) and a message about the cause. The program must not write an output file, and
it must not crash. Prints TAP.

Each bad input is a good input with one fault. The test first shows that the program accepts the good input, so that
only the fault can be the reason for a refusal."""
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

BIN = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"), "bin")
TIME_LIMIT_S = 120
SANITIZER = re.compile(r"AddressSanitizer|runtime error|terminate called|Assertion .* failed|core dumped")


# --- meshes ---------------------------------------------------------------------------------------------------------
def box(low, high, faces=range(12)):
    """Returns the triangles of a closed box, counter-clockwise as seen from outside."""
    corners = [tuple((high if i >> axis & 1 else low)[axis] for axis in range(3)) for i in range(8)]
    triangles = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6),
                 (0, 6, 2),
                 (1, 3, 7), (1, 7, 5)]
    return [tuple(corners[v] for v in triangles[f]) for f in faces]


def stl(triangles):
    lines = ["solid sample"]
    for triangle in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex %s %s %s" % vertex for vertex in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join(lines + ["endsolid sample", ""])


def binary_stl(triangles):
    facets = [struct.pack("<12fH", 0, 0, 0, *[c for vertex in triangle for c in vertex], 0) for triangle in triangles]
    return b"\0" * 80 + struct.pack("<I", len(triangles)) + b"".join(facets)


LUMEN = box((-10, -60, -10), (10, 60, 10))


def scene_text(**changes):
    """Returns the text of a good scene in which some parts are replaced by the given texts."""
    parts = {"name": '"sample"', "mesh": 'mesh = "lumen.stl"', "unit": 'unit = "mm"', "more": "",
             "position": "[0, -40, 0]", "direction": "[0, 1, 0]", "body": ""}
    parts.update(changes)
    return ('[scene]\nname = %(name)s\n[lumen]\n%(mesh)s\n%(unit)s\n%(more)s\n'
            '[entry]\nposition_mm = %(position)s\ndirection = %(direction)s\n%(body)s\n' % parts)


def curve(radii, points=None):
    """Returns the text of a 3D Slicer markups file with a curve along y."""
    points = points or [[0, 10.0 * i, 0] for i in range(8)]
    markup = {"type": "Curve", "coordinateSystem": "LPS", "coordinateUnits": "mm",
              "controlPoints": [{"id": str(i), "label": "p%d" % i, "position": p} for i, p in enumerate(points)],
              "measurements": [{"name": "Radius", "enabled": True, "controlPointValues": radii}] if radii else []}
    return json.dumps({"markups": [markup]})


# --- the bench of cases ----------------------------------------------------------------------------------------------
class Bench:
    """Runs the test cases in a temporary folder and reports their results as TAP."""

    def __init__(self, folder):
        self.folder = folder
        self.report = tree.Report()

    def write(self, name, content):
        path = os.path.join(self.folder, name)
        with open(path, "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        return name

    def read(self, name):
        with open(os.path.join(self.folder, name), "rb") as file:
            return file.read()

    def run(self, command):
        program = os.path.join(BIN, command[0])
        try:
            done = subprocess.run([program] + command[1:], cwd=self.folder, stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=TIME_LIMIT_S, check=False,
                                  env=dict(os.environ, CRN_ANATOMY=self.folder, DISPLAY=""))
        except FileNotFoundError:
            return None, "%s is missing: build it first" % program
        except subprocess.TimeoutExpired:
            return None, "still running after %d s" % TIME_LIMIT_S
        return done.returncode, done.stdout.decode("utf-8", "replace")

    def good(self, name, command):
        """Checks that the program accepts the good input from which the bad inputs are made."""
        code, text = self.run(command)
        self.report.check(name, [] if code == 0 else ["exit code %s, expected 0:\n%s" % (code, text[-2000:])])

    def bad(self, name, command, code, pattern, absent=None):
        """Checks that the program refuses an input with the given exit code and a message that matches `pattern`, and
        does not write the file `absent`."""
        got, text = self.run(command)
        findings = []
        if got != code:
            findings.append("exit code %s, expected %d" % (got, code))
        if not re.search(pattern, text, re.IGNORECASE | re.DOTALL):
            findings.append("the message does not match /%s/" % pattern)
        if SANITIZER.search(text):
            findings.append("it crashed")
        if absent and os.path.exists(os.path.join(self.folder, absent)):
            findings.append("it left %s behind" % absent)
        self.report.check(name, findings + ["message: " + text[-1500:]] if findings else [])


# --- anatomy ---------------------------------------------------------------------------------------------------------
def anatomy_cases(bench):
    bench.bad("anatomy without a command is refused", ["anatomy"], 2, "subcommand")
    bench.bad("anatomy with an unknown command is refused", ["anatomy", "elephant"], 2, "elephant|subcommand")
    bench.bad("anatomy without an output folder is refused", ["anatomy", "phantom"], 2, "--output is required")
    bench.bad("anatomy with a grid beyond its range is refused",
              ["anatomy", "phantom", "-o", "p", "--lumen-mm", "99"], 2,
              r"lumen-mm.*99.*range", "p")
    bench.bad("anatomy with a word for a number is refused", ["anatomy", "phantom", "-o", "p", "--lumen-mm", "fine"], 2,
              "lumen-mm.*fine|fine.*lumen-mm", "p")
    bench.bad("anatomy list of an unknown anatomy is refused", ["anatomy", "list", "cat"], 2, "cat")
    bench.write("file", "not a folder")
    bench.bad("anatomy into a file instead of a folder is refused", ["anatomy", "phantom", "-o", "file"], 1, "file")


# --- bake ------------------------------------------------------------------------------------------------------------
def bake_scene(bench, name, pattern, text, mesh=None, mesh_name="lumen.stl"):
    """Checks that `bake` refuses a scene file whose contents are `text`, with a message that matches `pattern`."""
    bench.write("lumen.stl", stl(LUMEN))
    if mesh is not None:
        bench.write(mesh_name, mesh)
    bench.write("bad.toml", text)
    bench.bad(name, ["bake", "bad.toml", "-o", "bad.scene"], 1, pattern, "bad.scene")


def bake_command_lines(bench):
    bench.write("lumen.stl", stl(LUMEN))
    bench.write("good.toml", scene_text())
    bench.good("the good scene is baked", ["bake", "good.toml", "-o", "good.scene"])
    bench.bad("bake without arguments is refused", ["bake"], 2, "required|usage|scene")
    bench.bad("bake with an unknown option is refused", ["bake", "good.toml", "-o", "x", "--quick"], 2, "--quick")
    bench.bad("bake of a missing file is refused", ["bake", "gone.toml", "-o", "x.scene"], 1, r"gone\.toml")
    bench.bad("bake of a folder is refused", ["bake", ".", "-o", "x.scene"], 1, r"\.")
    bench.bad("bake into a missing folder is refused", ["bake", "good.toml", "-o", "no/x.scene"], 1, "no/x.scene")


def bake_texts(bench):
    bake_scene(bench, "a scene with a syntax error is refused with its line", r"bad\.toml:3",
               "[scene]\nname = \"a\"\nx == 3\n")
    bake_scene(bench, "a scene with a lone bracket is refused with its line", r"bad\.toml:2:\d+: ", "[scene]\n[\n")
    bake_scene(bench, "a misspelt key is refused with its line", r"bad\.toml:6.*tolerence",
               scene_text(more="tolerence_mm = 0.1"))
    bake_scene(bench, "a mesh without a unit is refused", "unit", scene_text(unit=""))
    bake_scene(bench, "an unknown unit is refused", "inch", scene_text(unit='unit = "inch"'))
    bake_scene(bench, "a scene without a lumen is refused", "lumen", '[scene]\nname = "a"\n')
    bake_scene(bench, "a scene with mesh and centrelines is refused", "centrelines",
               scene_text(more='centrelines = ["a.mrk.json"]'))
    bake_scene(bench, "a missing mesh is refused by name", r"gone\.stl", scene_text(mesh='mesh = "gone.stl"'))
    bake_scene(bench, "a number that is text is refused", r"bad\.toml:6.*tolerance",
               scene_text(more='tolerance_mm = "fine"'))
    bake_scene(bench, "a negative tolerance is refused", "tolerance", scene_text(more="tolerance_mm = -1"))
    bake_scene(bench, "an entry outside the lumen is refused", "entry|position", scene_text(position="[0, 200, 0]"))
    bake_scene(bench, "an entry without a direction is refused", "direction", scene_text(direction="[0, 0, 0]"))
    bake_scene(bench, "an entry that is not a number is refused", "position", scene_text(position="[nan, 0, 0]"))
    bake_scene(bench, "an entry with two numbers is refused", "position", scene_text(position="[0, 1]"))
    bake_scene(bench, "axes that mirror twice are refused", "axes", scene_text(more='axes = ["+x", "+x", "+z"]'))
    body = '[[body]]\nname = "bone"\nmesh = "lumen"\nmaterial = "cortical_bone"\ninside = "%s"\n'
    bake_scene(bench, "a body inside an unknown body is refused", "skin", scene_text(body=body % "skin"))
    bake_scene(bench, "a body inside itself is refused", "bone", scene_text(body=body % "bone"))


def bake_meshes(bench):
    bake_scene(bench, "an empty mesh file is refused", r"lumen\.stl", scene_text(), b"")
    bake_scene(bench, "a mesh without triangles is refused", r"lumen\.stl", scene_text(), stl([]))
    bake_scene(bench, "a mesh file of random bytes is refused", r"lumen\.stl", scene_text(), bytes(range(256)) * 8)
    bake_scene(bench, "a truncated binary mesh is refused", r"lumen\.stl", scene_text(), binary_stl(LUMEN)[:-60])
    bake_scene(bench, "an open mesh is refused with its openings", r"lumen\.stl.*open", scene_text(),
               stl(box((-10, -60, -10), (10, 60, 10), range(10))))
    bake_scene(bench, "a vertex that is not a number is refused", "nan|finite|number", scene_text(),
               stl([((float("nan"), 0, 0), LUMEN[0][1], LUMEN[0][2])] + LUMEN[1:]))
    bake_scene(bench, "a mesh in metres called millimetres is refused", "unit", scene_text(),
               stl([tuple(tuple(c / 1000 for c in v) for v in t) for t in LUMEN]))
    bake_scene(bench, "a mesh of a kilometre is refused", "unit|large|big", scene_text(unit='unit = "m"'))
    bake_scene(bench, "a mesh that crosses itself is refused", "cross|intersect", scene_text(),
               stl(LUMEN + box((-5, 50, -5), (5, 80, 5))))
    bake_scene(bench, "an edge with three faces is refused", "manifold|edge", scene_text(),
               stl(LUMEN + [(LUMEN[0][0], LUMEN[0][1], (30, 0, 0))]))
    bake_scene(bench, "an unknown mesh format is refused", r"lumen\.xyz", scene_text(mesh='mesh = "lumen.xyz"'),
               "1 2 3\n",
               "lumen.xyz")


def bake_centrelines(bench):
    def refuse(name, pattern, text):
        bake_scene(bench, name, pattern, scene_text(mesh='centrelines = ["a.mrk.json"]', unit="",
                                                    position="[0, 5, 0]"), text,
                   "a.mrk.json")

    refuse("a centreline that is no JSON is refused", r"a\.mrk\.json", "{")
    refuse("a centreline without radii is refused", "radius", curve(None))
    refuse("a centreline with too few radii is refused", "radius|radii", curve([4.0] * 3))
    refuse("a centreline with a negative radius is refused", "radius", curve([4.0] * 7 + [-1.0]))
    refuse("a centreline with one point is refused", "point", curve([4.0], [[0, 0, 0]]))


# --- cournand --------------------------------------------------------------------------------------------------------
def tube_sample(x, y, z):
    """Returns the distance, in 1/32 of a voxel, from a voxel's centre to the wall of a square tube along y that is 8 mm
    wide."""
    return max(-127, min(127, round(32 * (max(abs(x + 0.5 - 12), abs(z + 0.5 - 12)) - 4.1))))


def scene_file(major=1, crc_of_lumen=None):
    """Returns the bytes of a scene file in the format of docs/scene.md; the scene is a tube of 3 x 4 x 3 bricks (blocks
    of voxels)."""
    bricks = [(x, y, z) for z in range(3) for y in range(4) for x in range(3)]
    samples = bytes(tube_sample(8 * bx + i - 1, 8 * by + j - 1, 8 * bz + k - 1) & 255
                    for bx, by, bz in bricks for k in range(10) for j in range(10) for i in range(10))
    edge = 1 << 23
    lumen = struct.pack("<3i3HHIHHI", -3 * edge // 2, 0, -3 * edge // 2, 3, 4, 3, 0, len(bricks), 0, 0, 0)
    lumen += struct.pack("<%dH" % len(bricks), *range(2, 2 + len(bricks))) + samples
    sections = [(1, b"tube".ljust(256, b"\0")), (2, struct.pack("<6i", 0, edge, 0, 0, 1 << 30, 0)), (3, lumen)]
    offset, table, body = 32 + 16 * len(sections), b"", b""
    for kind, data in sections:
        crc = crc_of_lumen if crc_of_lumen is not None and kind == 3 else zlib.crc32(data)
        table += struct.pack("<4I", kind, offset + len(body), len(data), crc)
        body += data + b"\0" * (-len(data) % 16)
    def header(crc):
        return struct.pack("<8s2H5I", b"CRN-SCN\0", major, 0, 1, offset + len(body), len(sections), crc, 0)
    return header(zlib.crc32(header(0) + table)) + table + body


def flipped(data, at):
    return data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :]


WIRE = os.path.join(tree.ROOT, "shared", "examples", "instruments", "bentson.toml")
CATHETER = os.path.join(tree.ROOT, "shared", "examples", "instruments", "beacon_5f.toml")
# The sample tube ends 23 mm behind the entry.
SESSION = "begin inserted 12 mm\nadvance 5 mm at 25 mm/s while rotate 90 deg\nwait 100 ms\n"


def session_run(scene="good.scene", wire=WIRE, session="good.session", more=()):
    return ["cournand", "run", "--scene", scene, "--instrument", wire, "--session", session, "--quiet"] + list(more)


def cournand_command_lines(bench):
    bench.write("good.scene", scene_file())
    bench.write("good.session", SESSION)
    bench.good("the good session runs", session_run(more=["--record", "good.rec", "--json", "good.json"]))
    bench.good("its recording is verified", ["cournand", "replay", "good.rec", "--verify"])
    bench.good("cournand without a command says what it can do without a display", ["cournand"])
    bench.bad("a command without its subcommand is refused", ["cournand", "rig"], 2, "subcommand.*selftest")
    bench.bad("cournand with an unknown command is refused", ["cournand", "fly"], 2, "fly|subcommand")
    bench.bad("a run without a tool is refused", ["cournand", "run", "--session", "good.session"], 2,
              "--tool is required")
    bench.bad("a misspelt name of an instrument is corrected", session_run(wire="j_wre"), 2,
              "no instrument 'j_wre', did you mean 'j_wire'")
    bench.bad("a misspelt name of a session is corrected", session_run(session="demmo"), 2,
              "no session 'demmo', did you mean 'demo'")
    bench.bad("a run with an unknown option is refused", session_run(more=["--fast"]), 2, "--fast")
    bench.bad("pictures of no size are refused", session_run(more=["--size", "0"]), 2, "size.*range")
    bench.bad("pictures at a word per second are refused", session_run(more=["--fps", "many"]), 2,
              "fps.*many|many.*fps")
    bench.bad("an unknown speed is refused", ["cournand", "replay", "good.rec", "--speed", "warp"], 2, "warp")
    bench.bad("a start beyond the recording is refused", ["cournand", "replay", "good.rec", "--from", "99"], 1,
              "beyond")
    bench.bad("a recording into a missing folder is refused", session_run(more=["--record", "no/x.rec"]), 1, "no/x.rec")
    bench.bad("figures into a missing folder are refused", session_run(more=["--json", "no/x.json"]), 1, "no/x.json")
    bench.bad("a picture into a missing folder is refused", session_run(more=["--png", "no/x.png"]), 1, "no/x.png")
    bench.bad("a missing body file is refused", session_run(more=["--png", "x.png", "--bodies", "gone.bodies"]), 1,
              r"gone\.bodies")
    bench.bad("info on an unknown kind of file is refused", ["cournand", "info", "good.json"], 1, r"good\.json")


def cournand_tools(bench):
    """Tests the program cournand with several tools at once. The program must accept tools that fit into each other,
    and name a tool that does not fit. The program must refuse a script that needs more tools than the command line
    names."""
    two = ["--tool", CATHETER]
    bench.good("a wire and a catheter run", session_run(more=two + ["--record", "two.rec"]))
    bench.good("their recording is verified", ["cournand", "replay", "two.rec", "--verify"])
    bench.good("--tool alone names the tools", ["cournand", "run", "--tool", WIRE, "--tool", CATHETER, "--session",
                                                "good.session", "--quiet"])
    bench.bad("a wire outside a catheter is refused by both names", session_run(wire=CATHETER, more=["--tool", WIRE]),
              1,
              r"'5F Beacon[^']*' \(1.67 mm\) does not pass the lumen of 'Bentson")
    bench.bad("four tools without a line are refused", session_run(more=two * 3), 1,
              r"has 4 tools and does not say which are on the line: write 'begin with'")
    bench.bad("nine tools are refused", session_run(more=two * 8), 2, "at most 8 tools, 9 are named")
    bench.bad("a missing second tool is refused", session_run(more=["--tool", "gone.toml"]), 1, r"gone\.toml")
    bench.write("two.session", "begin inserted 12 mm\nwait 100 ms\nadvance catheter 5 mm\n")
    bench.bad("a script that needs a second tool is refused with its line", session_run(session="two.session"), 1,
              r"two\.session:3:1: moves tool 2, but there is only one")
    bench.good("it runs with the second tool", session_run(session="two.session", more=two))


def cournand_outputs(bench):
    """Tests that an output must be a regular file, and must not be the same file as an input or as another output."""
    before = bench.read("good.session")
    for option in ("--record", "--json", "--png", "--png16", "--mp4"):
        bench.bad("%s onto the session is refused" % option, session_run(more=[option, "./good.session"]), 2,
                  "%s .* would overwrite what --session reads" % option)
        bench.bad("%s onto a device is refused" % option, session_run(more=[option, "/dev/full"]), 2,
                  "is a device or pipe")
        bench.bad("%s onto a folder is refused" % option, session_run(more=[option, "."]), 2, "is a folder")
    os.symlink("good.scene", os.path.join(bench.folder, "link.scene"))
    bench.bad("an output that is a link to an input is refused", session_run(more=["--json", "link.scene"]), 2,
              "would overwrite what --scene reads")
    with open(WIRE, "rb") as file:
        bench.write("wire.toml", file.read())
    bench.bad("an output onto a tool's file is refused, preset or not",
              session_run(wire="wire.toml:vcsim3-fit", more=["--json", "wire.toml"]),
              2, "would overwrite what --instrument reads")
    bench.bad("instruments written onto their own file are refused",
              ["cournand", "instruments", "wire.toml", "--json", "wire.toml"],
              2, "would overwrite what the list reads")
    for option in ("--json", "--png", "--table"):
        bench.bad("instruments with %s onto a device are refused" % option,
                  ["cournand", "instruments", WIRE, option, "/dev/full"], 2,
                  "is a device or pipe")
    bench.bad("two outputs of one name are refused", session_run(more=["--json", "both", "--record", "./both"]), 2,
              "--json and --record would both write", "both")
    bench.bad("a replay onto its recording is refused", ["cournand", "replay", "good.rec", "--png", "good.rec"], 2,
              "would overwrite what the recording reads")
    bench.bad("a bake onto its text is refused", ["bake", "good.toml", "-o", "good.toml"], 2,
              "would overwrite what SCENE reads")
    bench.bad("a bake onto its lumen's mesh is refused",
              ["bake", "good.toml", "-o", "x.scene", "--surface", "lumen.stl"], 2,
              "would overwrite what the lumen reads")
    bench.bad("a bake of two outputs into one file is refused",
              ["bake", "good.toml", "-o", "one.scene", "--surface", "one.scene"],
              2, "would both write", "one.scene")
    cournand_dicom(bench)
    bench.report.check("the session is as it was", [] if bench.read("good.session") == before else ["it changed"])


def cournand_dicom(bench):
    """Tests folders, names and dates with which the program cannot write DICOM files."""
    os.mkdir(os.path.join(bench.folder, "held"))
    bench.write("held/old.dcm", "kept")
    refuse = lambda name, pattern, more: bench.bad(name, session_run(more=more), 2, pattern, "new")
    refuse("DICOM into a folder that holds some is refused", r"already holds old\.dcm: name another folder",
           ["--dicom", "held"])
    refuse("DICOM into a file is refused", "is not a folder", ["--dicom", "good.session"])
    refuse("a patient without DICOM is refused", "patient-name.*requires.*dicom", ["--patient-name", "A^B"])
    refuse("a date that does not exist is refused", "20250229 is not a date",
           ["--dicom", "new", "--study-date", "20250229"])
    refuse("a date in another form is refused", "YYYYMMDD", ["--dicom", "new", "--study-date", "2025-01-01"])
    refuse("a name with a backslash is refused", "backslash", ["--dicom", "new", "--patient-name", "A\\B"])
    refuse("a number that is too long is refused", "at most 64 bytes, this one 65",
           ["--dicom", "new", "--patient-id", "x" * 65])
    refuse("unknown values are refused", "dicom-values.*sqrt", ["--dicom", "new", "--dicom-values", "sqrt"])
    bench.bad("a DICOM folder below a file is refused", session_run(more=["--dicom", "good.session/x"]), 1,
              "cannot be written")
    bench.bad("a check of no file is refused", ["cournand", "dicom-check"], 2, "file is required")
    bench.bad("a check of a missing file is refused", ["cournand", "dicom-check", "gone.dcm"], 1,
              "gone.dcm: no such file")
    bench.bad("a check of a folder without DICOM is refused", ["cournand", "dicom-check", "."], 1,
              "no .dcm file in this folder")


def cournand_scenes(bench):
    def refuse(name, pattern, data):
        bench.write("bad.scene", data)
        bench.bad(name, session_run("bad.scene", more=["--record", "bad.rec"]), 1, r"bad\.scene.*(%s)" % pattern,
                  "bad.rec")

    good = scene_file()
    bench.bad("a missing scene is refused", session_run("gone.scene"), 1, r"gone\.scene")
    refuse("an empty scene is refused", "too early", b"")
    refuse("a text as a scene is refused", "not a|no .*scene|magic", b"[scene]\nname = 'x'\n" * 8)
    refuse("a truncated scene is refused", "too early", good[:-1000])
    refuse("a scene with bytes behind it is refused", "bytes|longer|behind", good + b"\0" * 16)
    refuse("a scene with a flipped bit in the field is refused", "crc|checksum|damaged", flipped(good, len(good) - 500))
    refuse("a scene with a flipped bit in its header is refused", "crc|checksum|damaged", flipped(good, 40))
    refuse("a scene of a newer version is refused", "newer|version", scene_file(major=2))
    refuse("an oversized scene is refused", "large|big|bytes|size", good + b"\0" * (9 << 20))
    refuse("a scene whose name was changed by hand is refused", "crc|checksum|damaged",
           good.replace(b"tube", b"hose", 1))
    refuse("a section with a wrong checksum is refused", "crc|checksum|damaged", scene_file(crc_of_lumen=1))


def cournand_recordings(bench):
    def refuse(name, pattern, data):
        bench.write("bad.rec", data)
        bench.bad(name, ["cournand", "replay", "bad.rec", "--verify"], 1, r"bad\.rec.*(%s)" % pattern)

    try:
        good = bench.read("good.rec")
    except FileNotFoundError:
        bench.report.check("there is a recording to damage", ["good.rec was not written"])
        return
    bench.bad("a missing recording is refused", ["cournand", "replay", "gone.rec"], 1, r"gone\.rec")
    refuse("an empty recording is refused", "byte|short|empty|recording", b"")
    refuse("a text as a recording is refused", "not a|no .*recording", b"hello, this is text\n" * 20)
    refuse("a recording with a flipped bit is refused", "crc|checksum|damaged", flipped(good, len(good) // 2))
    refuse("a recording with a flipped bit in its header is refused", "crc|checksum|damaged|not a", flipped(good, 30))


def cournand_texts(bench):
    def session(name, pattern, text):
        bench.write("bad.session", text)
        bench.bad(name, session_run(session="bad.session"), 1, r"bad\.session" + pattern)

    session("an empty session is refused", ".*no statement", "")
    session("an unknown statement is refused with line and column", ":2:1.*advanse.*advance",
            "begin inserted 5 mm\nadvanse 3 mm\n")
    session("a missing unit is refused", ":1:.*unit", "advance 10\n")
    session("a wrong unit is refused", ":1:.*unit.*furlong", "advance 10 furlong\n")
    session("a speed beyond the hand's is refused", ":1:.*speed.*range", "advance 10 mm at 9000 mm/s\n")
    session("an angle beyond the C-arm's is refused", ":1:.*angle", "c-arm LAO 400\n")
    session("two moves of one kind at once are refused", ":1:.*one hand", "advance 10 mm while withdraw 5 mm\n")
    session("a session of random bytes is refused", ".*", bytes(range(128, 256)))
    bench.bad("a missing session is refused", session_run(session="gone.session"), 1, r"gone\.session")

    with open(WIRE, encoding="utf-8") as file:
        wire = file.read()

    def instrument(name, pattern, text):
        bench.write("bad.toml", text)
        bench.bad(name, session_run(wire="bad.toml"), 1, r"bad\.toml" + pattern)

    instrument("an instrument with a syntax error is refused with its line", ":1:", "format == 1\n")
    instrument("an instrument with a lone bracket is refused with its line", ":2:", "format = 2\n[\n")
    instrument("a misspelt key of an instrument is refused", ".*raduis",
               wire.replace("radius_outer_mm", "raduis_outer_mm", 1))
    instrument("an instrument of another format is refused", ".*format", wire.replace("format = 2", "format = 3", 1))
    instrument("a stiffness beyond its range is refused", ".*bend_stiffness",
               wire.replace("value = 2e-6", "value = 2e+6", 1))
    instrument("a stiffness that is not a number is refused", ".*bend_stiffness",
               wire.replace("value = 2e-6", "value = nan", 1))
    instrument("a value without a source is refused", ".*source",
               re.sub(r"(tip_mm = \{ value = 1\.0), source = \"[^\"]*\"", r"\1", wire))
    instrument("a section that ends before it begins is refused", ".*to_mm",
               wire.replace("to_mm = 150", "to_mm = 20", 1))
    instrument("a source that is not there is refused", ".*tipps", wire.replace('"@tips"', '"@tipps"', 1))
    instrument("a fault in a preset that is not asked for is refused", ".*based_on",
               wire.replace("based_on", "based_in", 1))
    instrument("an empty instrument is refused", ".*missing", "")
    bench.bad("a preset that is not there is refused", session_run(wire=WIRE + ":vcsim"), 1, r"bentson\.toml.*vcsim")
    instrument_lists(bench)


def instrument_lists(bench):
    listing = ["cournand", "instruments"]
    bench.good("instruments are listed, drawn and written",
               listing + [WIRE, "--png", "list.png", "--json", "list.json"])
    bench.good("one preset is listed", listing + [WIRE + ":vcsim3-fit"])
    bench.good("the shipped instruments are listed from every folder", listing)
    bench.bad("a list of a missing instrument is refused", listing + ["gone.toml"], 1, r"gone\.toml")
    bench.bad("a list of a folder without instruments is refused", listing + ["."], 1, r"bad\.toml|no \.toml")
    bench.bad("a list of a preset that nothing has is refused", listing + [os.path.dirname(WIRE), "--preset", "x"], 1,
              "preset 'x'")
    bench.bad("a list with an unknown option is refused", listing + ["--jpeg", "x.jpeg"], 2, "jpeg")
    bench.bad("a list drawn into a missing folder is refused", listing + [WIRE, "--png", "no/x.png"], 1, "no/x.png")
    bench.bad("a list written into a missing folder is refused", listing + [WIRE, "--json", "no/x.json"], 1,
              "no/x.json")
    bench.bad("a table into a document without its marks is refused", listing + [WIRE, "--table", "good.session"], 1,
              "marks")


def main():
    if not os.path.isdir(BIN):
        print("1..1\nnot ok 1 - the programs are built\n# %s does not exist: run `make`" % BIN)
        return 1
    folder = tempfile.mkdtemp()
    try:
        bench = Bench(folder)
        anatomy_cases(bench)
        bake_command_lines(bench)
        bake_texts(bench)
        bake_meshes(bench)
        bake_centrelines(bench)
        cournand_command_lines(bench)
        cournand_tools(bench)
        cournand_outputs(bench)
        cournand_scenes(bench)
        cournand_recordings(bench)
        cournand_texts(bench)
        bench.report.end()
    finally:
        shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
