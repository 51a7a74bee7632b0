#!/usr/bin/env python3
"""Measures the files that `anatomy heart` writes, without using code of that program, and prints one TAP line per
claim.

usage: check_heart.py FOLDER FIRST_NUMBER

The figures must lie in these ranges:

  ejection fraction                      55 to 65 %
  descent of the base                    10 to 16 mm
  twist                                  10 to 15 degrees; the base turns clockwise as seen from the apex
  rest of a coronary artery after systole  right 76 +- 34 ms, left 80 +- 25 ms
  rest of a coronary artery in diastole    right 65 +- 42 ms, left 112 +- 42 ms

An artery counts as resting while none of its points moves by more than 1 mm. The expected ranges apply at 70 beats per
minute; they come from MR angiography of the coronary rest period, 1999 to 2001.
"""

import json
import math
import sys
from pathlib import Path

from check_meshes import volume_mm3

FRAMES, BEAT_MS = 24, 60000 / 70
APEX, BASE = (78, 69, 48), (4, 117, 2)  # ends of the left ventricle's axis, from tools/anatomy/heart_beat.cpp


def read_obj(path, wanted):
    """Returns the vertices and the triangles of the wanted objects in an OBJ file. No two objects of the file share a
    vertex."""
    vertices, bodies, name = [], {}, None
    for line in path.read_text().splitlines():
        key, _, rest = line.partition(" ")
        if key == "v":
            vertices.append(tuple(map(float, rest.split())) if name in wanted else None)
        elif key == "f" and name in wanted:
            bodies[name].append(tuple(int(corner) - 1 for corner in rest.split()))
        elif key == "o":
            name = rest
            bodies[name] = []
    return vertices, bodies


def volume_ml(vertices, triangles):
    return volume_mm3(vertices, triangles) * 1e-3


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


AXIS = minus(BASE, APEX)
LENGTH = math.sqrt(dot(AXIS, AXIS))
UP = tuple(x / LENGTH for x in AXIS)


def height_mm(point):
    return dot(minus(point, APEX), UP)


def across(point):
    offset, along = minus(point, APEX), height_mm(point)
    return tuple(o - along * u for o, u in zip(offset, UP))


def turn_deg(pairs):
    """Returns the mean angle by which the vertices turn about the heart's axis. The angle is positive if a viewer at
    the apex sees a counter-clockwise turn."""
    sine = cosine = 0.0
    for before, after in pairs:
        a, b = across(before), across(after)
        cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        sine -= dot(cross, UP)
        cosine += dot(a, b)
    return math.degrees(math.atan2(sine, cosine))


def curves_of(path):
    return {
        m["name"] if "name" in m else m["controlPoints"][0]["label"].rsplit("-", 1)[0]: [
            p["position"] for p in m["controlPoints"]
        ]
        for m in json.loads(path.read_text())["markups"]
    }


def rest_ms(frames, low, high):
    """Returns the length of the longest time interval in which the vessel rests.

    Within the returned interval, no point of the vessel is more than 1 mm away from its position at the beginning or
    end of the interval. The middle of the time interval lies in the given part of the beat. Positions are interpolated
    linearly between frames, in time steps of 1/120 of a beat.
    """
    fine = 120

    def place(step):
        at = step % fine / fine * FRAMES
        k, share = int(at), at - int(at)
        return [[a + share * (b - a) for a, b in zip(p, q)] for p, q in zip(frames[k], frames[(k + 1) % FRAMES])]

    places = [place(step) for step in range(fine)]
    longest = 0
    for begin in range(fine):
        for length in range(longest + 1, fine):
            middle = (begin + length / 2) / fine % 1.0
            inside = [places[(begin + k) % fine] for k in range(length + 1)]
            moved = max(math.dist(p, q) for k in (0, -1) for one in inside for p, q in zip(inside[k], one))
            if moved > 1.0 or not low <= middle < high:
                break
            longest = length
    return longest * BEAT_MS / fine


def main():
    folder, number, failed = Path(sys.argv[1]), int(sys.argv[2]), False

    def claim(name, value, low, high, unit):
        nonlocal number, failed
        holds = low <= value <= high
        print(f"{'ok' if holds else 'not ok'} {number} - {name}: {value:.1f} {unit}, between {low:g} and {high:g}")
        number, failed = number + 1, failed or not holds

    stated = json.loads((folder / "heart.json").read_text())
    systole = stated["end_of_systole_frame"]
    ventricles = ("left_ventricle", "right_ventricle")
    rest, bodies = read_obj(folder / "beat/frame_00.obj", ventricles)
    moved, _ = read_obj(folder / f"beat/frame_{systole:02d}.obj", ventricles)
    left, right = (volume_ml(rest, bodies[name]) for name in ventricles)
    left_stroke, right_stroke = (volume_ml(rest, bodies[name]) - volume_ml(moved, bodies[name]) for name in ventricles)
    claim("ejection fraction of the left ventricle", 100 * left_stroke / left, 55, 65, "%")
    claim("both ventricles pump alike: right over left", right_stroke / left_stroke, 0.9, 1.1, "")
    claim("nothing folds over: the least volume factor of the map", stated["least_volume_factor"], 0.05, 1, "")
    used = {corner for triangle in bodies["left_ventricle"] for corner in triangle}
    pairs = [(rest[i], moved[i]) for i in sorted(used)]
    base = [(a, b) for a, b in pairs if height_mm(a) > 0.86 * LENGTH]
    apex = [(a, b) for a, b in pairs if height_mm(a) < 0.3 * LENGTH]
    claim("descent of the base", sum(height_mm(a) - height_mm(b) for a, b in base) / len(base), 10, 16, "mm")
    claim("twist, the apex counter-clockwise, the base clockwise", turn_deg(apex) - turn_deg(base), 10, 15, "deg")
    claim("turn of the base as seen from the apex", turn_deg(base), -8, -1, "deg")
    curves = [curves_of(folder / f"beat/centrelines_{frame:02d}.mrk.json") for frame in range(FRAMES)]
    for name, which, low, high, least, most in (
        ("right coronary artery after systole", "RCA", 0.25, 0.55, 76 - 34, 76 + 34),
        ("right coronary artery in diastole", "RCA", 0.55, 0.95, 65 - 42, 65 + 42),
        ("left anterior descending after systole", "LAD", 0.25, 0.55, 80 - 25, 80 + 25),
        ("left anterior descending in diastole", "LAD", 0.55, 0.95, 112 - 42, 112 + 42),
    ):
        claim("rest of the " + name, rest_ms([curve[which][::4] for curve in curves], low, high), least, most, "ms")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
