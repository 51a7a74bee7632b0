#!/usr/bin/env python3
"""Compares the result of `anatomy beat` with the beat of the shipped heart.

In the test, the mesh of the other heart is a copy of the shipped left coronary arteries, enlarged 1.2 times, turned and
shifted. If the motion of the other heart's mesh is rotated and scaled back, this motion must equal that of the shipped
arteries.

usage: check_beat.py make HEART MESH.obj ANATOMY  writes the mesh, and prints its three landmarks as arguments
       check_beat.py compare HEART FOLDER         prints the largest deviation in mm; exit code 1 above 0.02 mm
                                                  (frames are written to 0.001 mm, times the scale)
"""

import re
import subprocess
import sys
from pathlib import Path

from check_meshes import read_ply

SCALE, SHIFT, BODY = 1.2, (11.0, -7.0, 300.0), "coronaries_left"


def there(point):
    """Maps a point of the shipped heart to the other heart by a quarter turn about z, the scale and the shift, and
    returns the mapped point."""
    x, y, z = point
    return tuple(SCALE * a + b for a, b in zip((-y, x, z), SHIFT))


def read_body(path):
    """Returns the vertices and the faces of one body. The vertex numbers in the faces begin at 1."""
    vertices, faces, before, inside = [], [], 0, False
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["o"]:
            inside = words[1] == BODY
        elif words[:1] == ["v"]:
            vertices.append(tuple(map(float, words[1:]))) if inside else None
            before += not inside and not vertices
        elif words[:1] == ["f"] and inside:
            faces.append(tuple(int(corner) - before for corner in words[1:]))
    return vertices, faces


def make(heart, mesh):
    vertices, faces = read_body(heart / "beat" / "frame_00.obj")
    lines = ["v %.4f %.4f %.4f" % there(vertex) for vertex in vertices] + ["f %d %d %d" % face for face in faces]
    mesh.write_text("\n".join(lines) + "\n")
    told = subprocess.run([str(Path(sys.argv[4])), "beat", "--help"], capture_output=True, text=True).stdout
    places = re.findall(r"in\s+the\s+shipped\s+heart\s+([-\d.]+)\s+([-\d.]+)\s+([-\d.]+)", told)
    for name, place in zip(("--left", "--right", "--apex"), places):
        print(name, *("%.2f" % x for x in there(map(float, place))), end=" ")


def compare(heart, folder):
    worst = 0.0
    for frame in (0, 5, 10, 17):
        expected = [there(v) for v in read_body(heart / "beat" / f"frame_{frame:02d}.obj")[0]]
        found = read_ply(folder / f"{folder.name}_{frame:02d}.ply")[0]
        assert len(found) == len(expected), (len(found), len(expected))
        worst = max([worst] + [max(abs(a - b) for a, b in zip(*pair)) for pair in zip(found, expected)])
    print(f"# {len(expected)} vertices, off by {worst:.4f} mm at most")
    return 0 if worst < 0.02 else 1


if __name__ == "__main__":
    work = {"make": make, "compare": compare}[sys.argv[1]]
    sys.exit(work(Path(sys.argv[2]), Path(sys.argv[3])))
