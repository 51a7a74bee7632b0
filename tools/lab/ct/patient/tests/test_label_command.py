#!/usr/bin/env python3
"""These tests check the following. `cournand patient new --labels` makes a scene of a label map in each of the formats
that programs for segmentation write (NIfTI, packed or not, and NRRD), with a table of names in the forms that people
have, and the practice session of the scene plays: the wire goes into the vessel, and contrast medium leaves a catheter.
The map is a tube whose middle line is known; its axes are those of the file. What cannot be used is refused with its
name and a remedy. Prints TAP."""

import gzip
import json
import math
import os
import re
import struct
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), *[".."] * 5)
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import tree  # noqa: E402

BUILD = os.environ.get("BUILD", os.path.join(ROOT, "build"))
COURNAND = os.path.join(BUILD, "bin", "cournand")
SIZE, SPACING_MM, RADIUS_MM = (34, 34, 110), 1.0, 4.0
MIDDLE = (15.3, 18.6)  # voxels of the tube's middle line, which runs along the third axis, towards the head


def voxels():
    """Labels, the first axis fastest: 5 in the tube's lower half, 9 in its upper one, and a block of 2 beside it."""
    made = bytearray()
    for k in range(SIZE[2]):
        for j in range(SIZE[1]):
            for i in range(SIZE[0]):
                is_in = math.hypot(i - MIDDLE[0], j - MIDDLE[1]) * SPACING_MM < RADIUS_MM
                made.append((5 if k < 55 else 9) if is_in else 2 if i > 28 and 20 < k < 60 else 0)
    return bytes(made)


def nifti(data, bits=8, axes=(1, 1, 1)):
    """A NIfTI-1 file: header of 348 bytes, 4 of extensions, voxels. `axes` are signs of its axes in RAS."""
    kind = {8: 2, 16: 4, 32: 16}[bits]  # unsigned char, short, float
    rows = [[axes[a] * SPACING_MM if a == b else 0.0 for b in range(3)] + [0.0] for a in range(3)]
    head = struct.pack("<i10s18sihcB", 348, b"", b"", 0, 0, b"r", 0)
    head += struct.pack("<8h", 3, *SIZE, 1, 1, 1, 1) + struct.pack("<3f", 0, 0, 0)
    head += struct.pack("<4h", 0, kind, bits, 0) + struct.pack("<8f", 1.0, *[SPACING_MM] * 3, 0, 0, 0, 0)
    head += struct.pack("<f2fhBB4f2i", 352.0, 1.0, 0.0, 0, 0, 2, 0, 0, 0, 0, 0, 0)
    head += struct.pack("<80s24s2h6f", b"labels", b"", 0, 1, 0, 0, 0, 0, 0, 0)
    head += struct.pack("<12f", *rows[0], *rows[1], *rows[2]) + struct.pack("<16s4s", b"", b"n+1\0") + bytes(4)
    letter = {8: "B", 16: "h", 32: "f"}[bits]
    return head + struct.pack("<%d%s" % (len(data), letter), *data)


def nrrd(data):
    head = "NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: %d %d %d\n" % SIZE
    head += "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n"
    return head.encode() + data


def write(path, data):
    with open(path, "wb") as out:
        out.write(data)
    return path


def run(*words):
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=900)
    return done.returncode, done.stdout + done.stderr


def made(folder, *words):
    return run(COURNAND, "patient", "new", *words, "-o", folder)


def middle_faults(said, axes):
    """The entry lies on the tube's middle line: the scene's x is the patient's left, its z the front."""
    found = re.search(r"^entry +\(([-\d.]+), ([-\d.]+), ([-\d.]+)\) mm", said, re.M)
    if not found:
        return ["no entry is printed: " + said[-400:]]
    x, _, z = (float(n) for n in found.groups())
    wanted = (-axes[0] * MIDDLE[0], axes[1] * MIDDLE[1])  # RAS: x to the right, y to the front
    off = math.hypot(x - wanted[0], z - wanted[1])
    return [] if off < 0.5 else ["the entry is %.1f mm off the middle line: %s" % (off, found.group(0))]


def play_faults(folder):
    path = os.path.join(folder, "practice.json")
    code, said = run(COURNAND, "run", os.path.join(folder, "practice.session"), "--json", path, "--quiet")
    if code:
        return ["exit code %d: %s" % (code, said[-400:])]
    with open(path, encoding="utf-8") as text:
        report = json.load(text)
    faults = [] if report["contrast"]["iodine_injected_mg"] > 1000 else ["hardly any contrast medium is injected"]
    if not [run for run in report["room"]["irradiations"] if run["kind"] == "dsa" and run["pulses"] > 10]:
        faults.append("there is no DSA run")
    return faults


def check_formats(report, folder, data):
    table = write(os.path.join(folder, "names.csv"), b"id,structure\n2,liver\n5,iliac_artery_left\n9,aorta\n")
    words = write(os.path.join(folder, "names.txt"), b"2 liver\n5 iliac_artery_left\n9 aorta\n")
    lps = (-1, -1, 1)
    cases = (
        ("packed NIfTI", "map.nii.gz", gzip.compress(nifti(data)), ("--names", table), (1, 1, 1)),
        ("NIfTI of short numbers, axes of scans", "map16.nii", nifti(data, 16, lps), ("--names", words), lps),
        ("NIfTI of floating numbers", "map32.nii", nifti(data, 32), ("--label", "5", "--label", "9"), (1, 1, 1)),
        ("NRRD", "map.nrrd", nrrd(data), ("--names", table), lps),
    )
    for name, file, content, more, axes in cases:
        scene = os.path.join(folder, file + "_scene")
        code, said = made(scene, "--labels", write(os.path.join(folder, file), content), *more)
        faults = middle_faults(said, axes) if code == 0 else ["exit code %d: %s" % (code, said[-500:])]
        if code == 0 and "2 liver" in said:
            faults.append("the liver is taken for a vessel")
        report.check("%s becomes a scene" % name, faults)
        if file == "map.nii.gz":
            report.check("its practice session shows the vessel with contrast medium", faults or play_faults(scene))


def check_refusals(report, folder, data):
    good = write(os.path.join(folder, "good.nii.gz"), gzip.compress(nifti(data)))
    table = write(os.path.join(folder, "veins.csv"), b"id,structure\n2,liver\n5,vein\n9,bone\n")
    cases = (
        ("a map without labels", nifti(bytes(len(data))), (), r"all voxels are 0"),
        ("a cut file", nifti(data)[:5000], (), r"bad\.nii"),
        ("a label that is not there", nifti(data), ("--label", "7"), r"no voxel of label 7: it has 2, 5, 9"),
        ("a table without arteries", nifti(data), ("--names", table), r"no label is an artery.*--label"),
        ("a table that is not there", nifti(data), ("--names", os.path.join(folder, "none.csv")), r"none\.csv"),
    )
    for name, content, more, pattern in cases:
        scene = os.path.join(folder, "refused")
        code, said = made(scene, "--labels", write(os.path.join(folder, "bad.nii"), content), *more)
        faults = [] if code == 1 and re.search(pattern, said) else ["exit code %d: %s" % (code, said[-400:])]
        if os.path.exists(os.path.join(scene, "patient.scene")):
            faults.append("it leaves a scene")
        report.check("%s is refused" % name, faults)
    code, said = made(os.path.join(folder, "x"), "--labels", good, "--label", "five")
    report.check("a label that is no number is refused", [] if code == 2 else ["exit code %d: %s" % (code, said)])


def main():
    report = tree.Report()
    data = voxels()
    with tempfile.TemporaryDirectory() as folder:
        check_formats(report, folder, data)
        check_refusals(report, folder, data)
    return report.end()


if __name__ == "__main__":
    sys.exit(main())
