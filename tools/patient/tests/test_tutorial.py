#!/usr/bin/env python3
"""These tests check the following. The commands of docs/own_mesh.md make scenes of the real vessels in
../shared/anatomy with one command each, and a second one plays them: the wire goes from the entry into the vessel.
Vessels of known shapes work in every format, unit and fault that people meet: ASCII and binary STL, OBJ, PLY, metres,
inside out, open, walls of two sheets, parts. What cannot be used is refused with its name, its place and a remedy.
Tests of real data are skipped where it is missing. Prints TAP."""

import json
import math
import os
import re
import struct
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
sys.path.insert(0, os.path.join(ROOT, "tools", "docs"))
import command_blocks  # noqa: E402
import tree  # noqa: E402

BUILD = os.environ.get("BUILD", os.path.join(ROOT, "build"))
COURNAND = os.path.join(BUILD, "bin", "cournand")
ANATOMY = os.environ.get("CRN_ANATOMY", os.path.join(ROOT, "..", "shared", "anatomy"))


def run(words):
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=900)
    return done.returncode, done.stdout + done.stderr


def tube(radius, length, bend=0.0, around=24, along=60, at=0.0, turned=False):
    """Vertices and triangles of an open tube along y, or along an arc that begins there."""
    points, faces = [], []
    for i in range(along + 1):
        for j in range(around):
            s, angle = length * i / along, 2 * math.pi * j / around
            u, z = radius * math.cos(angle), -radius * math.sin(angle)
            if bend:
                x, y = bend - (bend - u) * math.cos(s / bend), (bend - u) * math.sin(s / bend)
            else:
                x, y = u, s
            points.append((x, y + at, z))
    for i in range(along):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            for face in ((a, a + around, b + around), (a, b + around, b)):
                faces.append(tuple(reversed(face)) if turned else face)
    return points, faces


def together(*meshes):
    points, faces = [], []
    for more, own in meshes:
        faces += [tuple(len(points) + k for k in face) for face in own]
        points += more
    return points, faces


def scaled(mesh, factor):
    return [tuple(factor * c for c in p) for p in mesh[0]], mesh[1]


def write_mesh(path, mesh):
    points, faces = mesh
    if path.endswith(".obj"):
        text = "".join("v %.9g %.9g %.9g\n" % p for p in points)
        text += "".join("f %d %d %d\n" % tuple(k + 1 for k in face) for face in faces)
    elif path.endswith(".ply"):
        text = "ply\nformat ascii 1.0\nelement vertex %d\n" % len(points)
        text += "property float x\nproperty float y\nproperty float z\n"
        text += "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % len(faces)
        text += "".join("%.9g %.9g %.9g\n" % p for p in points)
        text += "".join("3 %d %d %d\n" % face for face in faces)
    elif path.endswith(".vtp"):
        text = '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData>'
        text += '<Piece NumberOfPoints="%d" NumberOfPolys="%d">' % (len(points), len(faces))
        text += '<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">'
        text += " ".join("%.9g %.9g %.9g" % p for p in points) + "</DataArray></Points><Polys>"
        text += '<DataArray type="Int64" Name="connectivity" format="ascii">'
        text += " ".join("%d %d %d" % face for face in faces) + "</DataArray>"
        text += '<DataArray type="Int64" Name="offsets" format="ascii">'
        text += " ".join(str(3 * k + 3) for k in range(len(faces)))
        text += "</DataArray></Polys></Piece></PolyData></VTKFile>\n"
    elif path.endswith("_ascii.stl"):
        text = "solid vessel\n"
        for face in faces:
            text += "facet normal 0 0 0\nouter loop\n"
            text += "".join("vertex %.9g %.9g %.9g\n" % points[k] for k in face) + "endloop\nendfacet\n"
        text += "endsolid vessel\n"
    else:
        data = b"vessel".ljust(80) + struct.pack("<I", len(faces))
        for face in faces:
            data += struct.pack("<12f", 0, 0, 0, *points[face[0]], *points[face[1]], *points[face[2]]) + b"\0\0"
        with open(path, "wb") as out:
            out.write(data)
        return path
    with open(path, "w", encoding="utf-8") as out:
        out.write(text)
    return path


def numbers_after(text, words):
    found = re.search(words + r"[^\n(]*\(([-\d.]+), ([-\d.]+), ([-\d.]+)\) mm", text)
    return [float(n) for n in found.groups()] if found else None


def played(folder):
    """Plays the practice session of a scene. Returns the faults."""
    report = os.path.join(folder, "practice.json")
    code, said = run([COURNAND, "run", os.path.join(folder, "practice.session"), "--json", report, "--quiet"])
    if code:
        return ["cournand run: exit code %d: %s" % (code, said[-400:])]
    if not re.search(r"^held .*inserted", said, re.M):
        return ["the session's expectation is not reported: " + said[-400:]]
    # The wire has left the vessel at the end, and the catheter is in it. Its tip may have just entered a branch.
    inserted = [float(mm) for mm in re.findall(r"^  inserted +([-\d.]+) mm at the end", said, re.M)]
    if max(inserted, default=0) < 5 or not re.search(r"^  tip .*\([\d.]+ mm inside\)", said, re.M):
        return ["the tip is not in the vessel: " + said[-400:]]
    with open(report, encoding="utf-8") as text:
        figures = json.load(text)
    if figures["contrast"]["injected_ml"] < 4 or not figures["room"]["runs"]:
        return ["no contrast medium is injected in a run, so nobody sees the vessel: " + said[-400:]]
    return []


def made(meshes, folder, *more):
    code, said = run([COURNAND, "patient", "new", "--mesh", *meshes, "-o", folder, *more])
    return code, said


def check_shapes(report):
    bent = tube(4, 150, 60)
    wall = together(tube(5.2, 150, 60), tube(4, 150, 60, turned=True))
    shapes = {
        "tube.obj": bent,
        "tube.ply": bent,
        "tube.stl": bent,
        "tube_ascii.stl": bent,
        "metres.stl": scaled(bent, 1e-3),
        "centimetres.vtp": scaled(tube(10, 150, 60), 0.1),
        "inside_out.stl": tube(4, 150, 60, turned=True),
        "wall.obj": wall,
        "twice.stl": together(bent, bent),
    }
    with tempfile.TemporaryDirectory() as folder:
        for name, mesh in shapes.items():
            scene = os.path.join(folder, name + "_scene")
            # The tube is wider than high, which would be taken for a patient lying on the side.
            axes = ("--axes", "+x,+y,+z")
            code, said = made([write_mesh(os.path.join(folder, name), mesh)], scene, *axes)
            entry = numbers_after(said, "entry ") if code == 0 else None
            faults = [] if entry else ["exit code %d: %s" % (code, said[-500:])]
            # The entry lies on the middle line, an arc of 60 mm about (60, 0, 0).
            if entry and abs(math.hypot(math.hypot(entry[0] - 60, entry[1]) - 60, entry[2])) > 0.4:
                faults.append("the entry (%.1f, %.1f, %.1f) is not in the middle" % tuple(entry))
            if name == "twice.stl" and not re.search(r"^doubled +2880 triangles count once", said, re.M):
                faults.append("the doubled triangles are not reported: " + said[-500:])
            report.check("%s becomes a scene" % name, faults)
            if name in ("tube.obj", "wall.obj"):
                report.check("%s plays" % name, faults or played(scene))
        # Two files whose tubes overlap, and a third one with a gap.
        files = [
            write_mesh(os.path.join(folder, name), mesh)
            for name, mesh in (
                ("one.stl", tube(5, 70)),
                ("two.stl", tube(4, 60, at=60)),
                ("three.stl", tube(4, 60, at=122)),
            )
        ]
        scene = os.path.join(folder, "atlas")
        code, said = made(files, scene)
        report.check(
            "parts of three files become one scene, and a gap is bridged",
            [] if code == 0 and re.search(r"^bridges +1:", said, re.M) else ["exit code %d: %s" % (code, said[-600:])],
        )
        report.check("it plays", played(scene) if code == 0 else ["it was not made"])
        with open(os.path.join(scene, "scene.toml"), encoding="utf-8") as text:
            head = text.read()
        flags = ("--unit", "--axes", "--bridge-mm", "--inlet", "--entry", "--branches")
        report.check(
            "the scene's text has what was decided, with its options",
            [flag for flag in flags if flag not in head],
        )


def check_refusals(report):
    with tempfile.TemporaryDirectory() as folder:
        thin = write_mesh(os.path.join(folder, "thin.obj"), tube(0.7, 100))
        far = write_mesh(os.path.join(folder, "far.obj"), scaled(tube(4, 150), 1e-9))
        good = write_mesh(os.path.join(folder, "good.obj"), tube(4, 80))
        broken, damaged = os.path.join(folder, "broken.stl"), os.path.join(folder, "damaged.vtp")
        with open(broken, "wb") as out:
            out.write(b"x" * 50)
        with open(write_mesh(damaged, tube(4, 80)), "r+", encoding="utf-8") as out:
            text = out.read()
            out.seek(0)
            out.write(text.replace("0 24 25", "0 24 99999", 1))
        cases = (
            ("a vessel in which no sheath fits", [thin], (), 1, r"no sheath fits into the end at \(.*--entry"),
            ("a size of no unit", [far], (), 1, r"in no unit.*--unit"),
            ("a damaged file", [broken], (), 1, r"broken\.stl"),
            ("a corner that is not there", [damaged], (), 1, r"damaged\.vtp: has the index 99999 in Polys"),
            ("a missing file", [os.path.join(folder, "none.stl")], (), 1, r"none\.stl"),
            ("an inlet outside", [good], ("--inlet", "90", "90", "90"), 1, r"inlet at \(90.0.*outside the vessel"),
            ("a part that is not there", [good], ("--part", "aorta"), 1, r"aorta"),
            ("a body without material", [good], ("--body", "x.stl"), 2, r"MATERIAL:FILE"),
            ("a click on a mesh", [good], ("--click", "artery:1,2,3"), 2, r"--click belongs to a scan"),
        )
        for name, files, more, wanted, pattern in cases:
            scene = os.path.join(folder, "refused")
            code, said = made(files, scene, *more)
            faults = [] if code == wanted and re.search(pattern, said) else ["exit code %d: %s" % (code, said[-400:])]
            if os.path.exists(os.path.join(scene, "patient.scene")):
                faults.append("it leaves a scene")
            report.check("%s is refused" % name, faults)
        code, said = run([COURNAND, "patient", "new", "-o", os.path.join(folder, "x")])
        faults = [] if code == 2 and "--mesh" in said else ["exit code %d: %s" % (code, said)]
        report.check("no input is refused", faults)


def check_page(report):
    """Runs the page's commands of real data as they stand there."""
    with open(os.path.join(ROOT, "docs", "own_mesh.md"), encoding="utf-8") as text:
        found = command_blocks.commands("own_mesh.md", text.read())
    wanted = [command.text for command in found if command.kind == "anatomy"]
    if len(wanted) < 2:
        return report.check("the page has commands for real data", ["only %d" % len(wanted)])
    if not os.path.isdir(ANATOMY):
        print("# skipped: no ../shared/anatomy")
        return None
    with tempfile.TemporaryDirectory() as folder:
        for text in wanted:
            words = [COURNAND if w == "cournand" else w for w in text.split("#")[0].split()]
            words = [w.replace("../shared/anatomy", ANATOMY).replace("out/", folder + "/") for w in words]
            code, said = run(words)
            report.check("the page's command works: %s" % text.split("#")[0][:60], [] if code == 0 else [said[-600:]])
        report.check("the wire goes into the vessel", played(os.path.join(folder, "own")))
    return None


def check_real(report):
    """Anatomies of the same kind that the page does not show."""
    heart, female = "hra/VH_M_Blood_Vasculature_Heart.glb", "hra_female/VH_F_Blood_Vasculature_Heart.glb"
    gut = "hra/VH_M_Blood_Vasculature_Large_Intestine.glb"
    cases = (
        ("a single real vessel", heart, ("--part", "VH_M_descending_aorta_a")),
        ("a real arch of walls", female, ("--part", "VH_F_aortic_arch", "--part", "VH_F_ascending_aorta")),
        ("a tree of thin and winding arteries", gut, ()),
    )
    with tempfile.TemporaryDirectory() as folder:
        for name, file, more in cases:
            path = os.path.join(ANATOMY, file)
            if not os.path.exists(path):
                print("# skipped: no %s" % file)
                continue
            scene = os.path.join(folder, os.path.basename(file) + str(len(more)))
            code, said = made([path], scene, *more)
            report.check("%s becomes a scene" % name, [] if code == 0 else [said[-600:]])
            report.check("%s plays" % name, played(scene) if code == 0 else ["it was not made"])


def main():
    report = tree.Report()
    check_shapes(report)
    check_refusals(report)
    check_real(report)
    check_page(report)
    return report.end()


if __name__ == "__main__":
    sys.exit(main())
