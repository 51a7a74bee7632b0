#!/usr/bin/env python3
"""Writes a small CTA as NIfTI, for the test of the review window: a body with a spine, and an aorta that divides into
two iliac arteries.

  phantom.py SCAN.nii"""

import math
import random
import struct
import sys

SIZE = (100, 76, 72)  # voxels to the left, to the back and to the head
STEP_MM = 1.6
AORTA_MM, ILIAC_MM = 9.0, 5.5


def distance(p, a, b):
    """Returns the distance of a point from a segment."""
    along = [b[i] - a[i] for i in range(3)]
    share = sum((p[i] - a[i]) * along[i] for i in range(3)) / sum(part * part for part in along)
    share = min(max(share, 0.0), 1.0)
    return math.dist(p, [a[i] + share * along[i] for i in range(3)])


def hu(p):
    """Returns the density at a place (left, back, head) in mm from the middle."""
    fork = (0, 5, -5)
    if distance(p, (0, 5, 60), fork) < AORTA_MM:
        return 350
    if p[2] < 5 and min(distance(p, fork, (side * 28, 0, -60)) for side in (-1, 1)) < ILIAC_MM:
        return 350
    if math.hypot(p[0], p[1] - 32) < 13:
        return 400 if math.hypot(p[0], p[1] - 32) > 11 else 150  # a vertebra's cortex and its inside
    if math.hypot(p[0] / 72, p[1] / 52) < 1:
        return 45
    return -1000


def main():
    noise = random.Random(1)
    voxels = []
    for k in range(SIZE[2]):
        for j in range(SIZE[1]):
            for i in range(SIZE[0]):
                place = [(n - (size - 1) / 2) * STEP_MM for n, size in zip((i, j, k), SIZE)]
                voxels.append(round(hu(place) + noise.gauss(0, 15)))
    # NIfTI-1: its axes run to the left of the patient's right, to the front and to the head.
    middle = [(size - 1) / 2 * STEP_MM for size in SIZE]
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, *SIZE, 1, 1, 1, 1)
    struct.pack_into("<2h", head, 70, 4, 16)  # int16
    struct.pack_into("<8f", head, 76, 1, STEP_MM, STEP_MM, STEP_MM, 1, 1, 1, 1)
    struct.pack_into("<3f", head, 108, 352, 1, 0)  # offset of the voxels, slope, intercept
    head[123] = 2  # millimetres
    struct.pack_into("<2h", head, 252, 0, 1)  # the grid is given by the three rows below
    struct.pack_into("<4f", head, 280, -STEP_MM, 0, 0, middle[0])
    struct.pack_into("<4f", head, 296, 0, -STEP_MM, 0, middle[1])
    struct.pack_into("<4f", head, 312, 0, 0, STEP_MM, -middle[2])
    head[344:348] = b"n+1\0"
    with open(sys.argv[1], "wb") as file:
        file.write(head)
        file.write(struct.pack("<%dh" % len(voxels), *voxels))


if __name__ == "__main__":
    main()
