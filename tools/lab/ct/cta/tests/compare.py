"""Compares the centrelines that `ct patient` has found with the true ones of `ct cta`. Only test_virtual_cta.py imports
this module."""

import csv
import itertools
import math

CELL_MM = 4.0
LEAST_MM = 10  # shorter ones end at the scan's border, or become thinner at once
FOUND_SHARE = 0.5  # of a vessel's length
WIDER = 1.05  # a vessel that goes on as another one has the same radius


def read_truth(path, least_radius_mm):
    """Returns the points of the true vessels, every 1 mm, as {(name, number): [(place, radius)]}, without those thinner
    than the limit, and without those inside a wider vessel: a branch begins at the parent's wall."""
    vessels, number, before = {}, 0, None
    with open(path, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            key = (row["name"], row["parent"], row["small"])
            number += key != before
            before = key
            place = tuple(float(row[axis]) for axis in ("x_mm", "y_mm", "z_mm"))
            vessels.setdefault((row["name"], number), []).append((place, float(row["radius_mm"])))
    dense = {name: resampled(points) for name, points in vessels.items()}
    spheres = [(place, radius, name) for name, points in dense.items() for place, radius in points if radius > 1.5]
    cells = {}
    for sphere in spheres:
        place, radius, _ = sphere
        spans = [range(int((v - radius) // CELL_MM), int((v + radius) // CELL_MM) + 1) for v in place]
        for cell in itertools.product(*spans):
            cells.setdefault(cell, []).append(sphere)

    def is_own(name, place, radius):
        near = cells.get(tuple(int(v // CELL_MM) for v in place), ())
        return not any(
            other != name and wide > WIDER * radius and math.dist(place, middle) < wide for middle, wide, other in near
        )

    kept = {name: [p for p in points if p[1] >= least_radius_mm and is_own(name, *p)] for name, points in dense.items()}
    return {name: points for name, points in kept.items() if len(points) >= LEAST_MM}


def read_tree(path):
    """Returns the branches of a tree.csv, every 0.5 mm, as one list of places and radii."""
    branches = {}
    with open(path, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            place = tuple(float(row[axis]) for axis in ("x_mm", "y_mm", "z_mm"))
            branches.setdefault(row["branch"], []).append((place, float(row["radius_mm"])))
    return [point for points in branches.values() for point in resampled(points, 0.5)]


def resampled(points, step_mm=1.0):
    dense = points[:1]
    for (a, ra), (b, rb) in zip(points, points[1:]):
        count = max(1, math.ceil(math.dist(a, b) / step_mm))
        for i in range(1, count + 1):
            share = i / count
            dense.append((tuple(u + share * (v - u) for u, v in zip(a, b)), ra + share * (rb - ra)))
    return dense


class Near:
    """Finds the nearest of many points within a few millimetres."""

    def __init__(self, points):
        self.cells = {}
        for point in points:
            self.cells.setdefault(self.cell(point[0]), []).append(point)

    @staticmethod
    def cell(place):
        return tuple(math.floor(v / CELL_MM) for v in place)

    def nearest(self, place, reach_mm):
        rings, at = math.ceil(reach_mm / CELL_MM), self.cell(place)
        best = None
        for i in range(-rings, rings + 1):
            for j in range(-rings, rings + 1):
                for k in range(-rings, rings + 1):
                    for point in self.cells.get((at[0] + i, at[1] + j, at[2] + k), ()):
                        distance = math.dist(point[0], place)
                        if distance <= reach_mm and (best is None or distance < best[0]):
                            best = (distance, point)
        return best


def missed(truth, found, count):
    """Returns the places where a person who looks at the scan would click: the middle of the longest missed stretch of
    each vessel that counts as missed, for the longest ones. An entry is (mm missed, name, place)."""
    near, places = Near(found), []
    for (name, _), points in truth.items():
        hits = [near.nearest(place, reach_mm(radius)) is not None for place, radius in points]
        if sum(hits) >= FOUND_SHARE * len(points):
            continue
        stretches = [
            [place for _, (place, _) in group]
            for is_hit, group in itertools.groupby(zip(hits, points), key=lambda pair: pair[0])
            if not is_hit
        ]
        longest = max(stretches, key=len)
        places.append((hits.count(False), name, longest[len(longest) // 2]))
    return sorted(places, reverse=True)[:count]


def reach_mm(radius):
    return max(1.5, 0.5 * radius)


def compare(truth, found):
    """A point of a vessel counts as found if a centreline passes within half the radius, at least 1.5 mm; a vessel, if
    half of its length does. Returns per vessel: name, length in mm, share found, mean distance in mm, mean error of the
    radius as a share, true mean radius in mm."""
    near, rows = Near(found), []
    for (name, _), points in truth.items():
        hits = [(near.nearest(place, reach_mm(radius)), radius) for place, radius in points]
        good = [(hit, radius) for hit, radius in hits if hit]
        rows.append(
            (
                name,
                len(points),
                len(good) / len(points),
                sum(hit[0] for hit, _ in good) / max(1, len(good)),
                sum(abs(hit[1][1] / radius - 1) for hit, radius in good) / max(1, len(good)),
                sum(radius for _, radius in points) / len(points),
            )
        )
    return rows


def summary(rows):
    """Vessels found, mean distance and mean error of the radius, weighted by the length found."""
    found = [row for row in rows if row[2] >= FOUND_SHARE]
    length = sum(row[1] * row[2] for row in found) or 1
    return (
        len(found) / max(1, len(rows)),
        sum(row[1] * row[2] * row[3] for row in found) / length,
        sum(row[1] * row[2] * row[4] for row in found) / length,
    )
