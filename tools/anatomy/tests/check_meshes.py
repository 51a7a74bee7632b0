#!/usr/bin/env python3
"""Checks the files of one anatomy without using code of the program `anatomy`, and prints one TAP line per check.

usage: check_meshes.py FOLDER STATIONS.tsv FIRST_NUMBER     (STATIONS.tsv is the output of `anatomy list`)
"""

import json
import math
import re
import struct
import sys
from collections import Counter
from pathlib import Path


def read_ply(path):
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    vertex_count = int(re.search(r"element vertex (\d+)", header)[1])
    face_count = int(re.search(r"element face (\d+)", header)[1])
    numbers = struct.unpack_from(f"<{3 * vertex_count}f", data, end)
    vertices = [numbers[i : i + 3] for i in range(0, len(numbers), 3)]
    triangles = [face[1:] for face in struct.iter_unpack("<Biii", data[end + 12 * vertex_count :])]
    assert len(triangles) == face_count
    return vertices, triangles


def read_scene(path):
    """Reads those keys of scene.toml that the checks of the meshes need."""
    bodies, table, entry, ignored = [], None, {}, {}
    for line in path.read_text().splitlines():
        if line == "[[body]]":
            table = {}
            bodies.append(table)
        elif line.startswith("["):
            table = entry if line == "[entry]" else ignored
        elif "=" in line and not line.startswith("#") and table is not ignored:
            key, value = (part.strip() for part in line.split("=", 1))
            table[key] = json.loads(value)
    return entry, bodies


def closed_fault(triangles):
    """Checks that the mesh has each directed edge exactly once, and the opposite edge exactly once."""
    edges = Counter()
    for a, b, c in triangles:
        edges.update(((a, b), (b, c), (c, a)))
    for (a, b), count in edges.items():
        if count != 1 or edges.get((b, a)) != 1:
            return f"edge {a}-{b} is used {count} times one way and {edges.get((b, a), 0)} times the other"
    return None


def volume_mm3(vertices, triangles):
    total = 0.0
    for i, j, k in triangles:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = vertices[i], vertices[j], vertices[k]
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total / 6.0


class Inside:
    """Determines whether a point lies inside a closed mesh. The class counts how often a line along z from the point
    crosses the mesh. For speed, the mesh's triangles are sorted into square cells over x and y.
    """

    CELL_MM = 6.0

    def __init__(self, vertices, triangles):
        self.bins = {}
        for corner in triangles:
            points = [vertices[v] for v in corner]
            xs, ys = [p[0] for p in points], [p[1] for p in points]
            for i in range(int(min(xs) // self.CELL_MM), int(max(xs) // self.CELL_MM) + 1):
                for j in range(int(min(ys) // self.CELL_MM), int(max(ys) // self.CELL_MM) + 1):
                    self.bins.setdefault((i, j), []).append(points)

    def holds(self, point):
        # Irrational offsets keep the line off edges and corners.
        x, y, z = point[0] + 1.7e-5 * math.pi, point[1] + 1.3e-5 * math.e, point[2]
        crossings = 0
        for (ax, ay, az), (bx, by, bz), (cx, cy, cz) in self.bins.get(
            (int(x // self.CELL_MM), int(y // self.CELL_MM)), ()
        ):
            area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
            if area == 0.0:
                continue
            u = ((bx - x) * (cy - y) - (cx - x) * (by - y)) / area
            v = ((cx - x) * (ay - y) - (ax - x) * (cy - y)) / area
            if u >= 0.0 and v >= 0.0 and u + v <= 1.0 and u * az + v * bz + (1.0 - u - v) * cz > z:
                crossings += 1
        return crossings % 2 == 1


def section_area_mm2(vertices, triangles, centre, normal, reach_mm):
    """Returns the area of the mesh's cross-section with a plane; only triangles within reach_mm of the centre count."""
    side = {}

    def height(vertex):
        if vertex not in side:
            side[vertex] = sum((vertices[vertex][k] - centre[k]) * normal[k] for k in range(3))
        return side[vertex]

    doubled = 0.0
    for corner in triangles:
        if max(abs(vertices[corner[0]][k] - centre[k]) for k in range(3)) > reach_mm:
            continue
        cut = []
        for i in range(3):
            a, b = corner[i], corner[(i + 1) % 3]
            ha, hb = height(a), height(b)
            if (ha < 0) != (hb < 0):
                t = ha / (ha - hb)
                cut.append(
                    (ha < 0, [vertices[a][k] + t * (vertices[b][k] - vertices[a][k]) - centre[k] for k in range(3)])
                )
        if len(cut) == 2:
            (rises, p), (_, q) = cut
            if not rises:
                p, q = q, p
            cross = (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])
            doubled += sum(cross[k] * normal[k] for k in range(3))
    return abs(doubled) / 2.0


class Tap:
    def __init__(self, number):
        self.number, self.failed = number, False

    def report(self, name, faults):
        print(f"{'not ok' if faults else 'ok'} {self.number} - {name}")
        for fault in faults[:5]:
            print(f"# {fault}")
        self.number += 1
        self.failed = self.failed or bool(faults)


def closure_faults(meshes):
    faults = []
    for name, (vertices, triangles) in meshes.items():
        fault = closed_fault(triangles)
        if fault:
            faults.append(f"{name}: {fault}")
        elif volume_mm3(vertices, triangles) <= 0.0:
            faults.append(f"{name}: normals point inwards")
        if any(abs(c) > 1200.0 for v in vertices for c in v):
            faults.append(f"{name}: reaches beyond 1.2 m")
    return faults


def sampled(vertices, count):
    return vertices[:: max(1, len(vertices) // count)]


def nesting_faults(bodies, meshes):
    """Checks points of every body: each point must lie in the body around it, and in no other body directly inside that
    one."""
    inside = {name: Inside(*mesh) for name, mesh in meshes.items()}
    faults = []
    for body in bodies:
        samples = sampled(meshes[body["name"]][0], 400)
        parent = body.get("inside")
        if parent:
            out = [p for p in samples if not inside[parent].holds(p)]
            if out:
                faults.append(f"{body['name']}: {len(out)} of {len(samples)} samples outside {parent}, first {out[0]}")
        for other in bodies:
            if other is not body and other.get("inside") == parent:
                hits = [p for p in samples if inside[other["name"]].holds(p)]
                if hits:
                    faults.append(
                        f"{body['name']}: {len(hits)} of {len(samples)} samples in {other['name']}, first {hits[0]}"
                    )
    return faults


def dimension_faults(lumen, stations):
    """Checks the lumen's cross-section at each point with a given diameter d: the area may differ by at most 3 % from
    pi d^2 / 4."""
    faults, checked = [], 0
    for line in stations.splitlines()[1:]:
        vessel, station, diameter, *numbers, _ = line.split("\t")
        if station == "length" or "annulus" in station or "sinus" in station:
            continue  # the closed end is a cap, not a section
        x, y, z, tx, ty, tz = map(float, numbers)
        expected = math.pi * float(diameter) ** 2 / 4
        area = section_area_mm2(*lumen, (x, y, z), (tx, ty, tz), 0.9 * float(diameter))
        checked += 1
        if abs(area / expected - 1) > 0.03:
            faults.append(
                f"{station}: {area:.2f} mm2, expected {expected:.2f} "
                f"(off by {100 * (area / expected - 1):+.1f} %, allowed 3 %)"
            )
    return faults if checked > 5 else faults + [f"only {checked} stations were checked"]


def centreline_faults(folder, lumen):
    """Checks that every control point of the centrelines lies in the lumen and has a radius. The control points are
    first converted from LPS coordinates (left, posterior, superior)."""
    inside, faults = Inside(*lumen), []
    files = sorted(folder.glob("*.mrk.json"))
    for path in files:
        markup = json.loads(path.read_text())["markups"][0]
        radii = next(m for m in markup["measurements"] if m["name"] == "Radius")["controlPointValues"]
        points = [p["position"] for p in markup["controlPoints"]]
        out = [p for p in points if not inside.holds((p[0], p[2], -p[1]))]
        if markup["coordinateSystem"] != "LPS" or len(radii) != len(points) or min(radii) <= 0 or out:
            faults.append(f"{path.name}: {len(out)} of {len(points)} points outside the lumen")
    return faults if len(files) >= 5 else faults + ["fewer than five centrelines"]


def main():
    folder, stations = Path(sys.argv[1]), Path(sys.argv[2]).read_text()
    tap = Tap(int(sys.argv[3]))
    entry, bodies = read_scene(folder / "scene.toml")
    meshes = {body["name"]: read_ply(folder / body["mesh"]) for body in bodies}
    lumen = read_ply(folder / "lumen.ply")
    title = folder.name
    tap.report(
        f"{title}: every mesh is closed, faces outwards and stays within 1.2 m",
        closure_faults({**meshes, "lumen": lumen}),
    )
    tap.report(f"{title}: samples of every body lie in its parent and in no sibling", nesting_faults(bodies, meshes))
    tap.report(f"{title}: section areas equal the stated diameters within 3 %", dimension_faults(lumen, stations))
    tap.report(f"{title}: centrelines declare LPS and run inside the lumen", centreline_faults(folder, lumen))
    holds = Inside(*lumen).holds(entry["position_mm"])
    length = math.hypot(*entry["direction"])
    tap.report(
        f"{title}: the sheath's mouth is in the lumen and its direction has length one",
        [] if holds and abs(length - 1) < 1e-3 else [f"inside: {holds}, length {length}"],
    )
    return 1 if tap.failed else 0


if __name__ == "__main__":
    sys.exit(main())
