"""One labelled frame: its picture, its masks, and the positions and measured values that are stored with them.

In this module, lengths are in mm, in the package's frame of the patient (+x left, +y head, +z front). Columns and rows
are in pixels, counted so that the centre of the first pixel is at 0.5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _core
from ..world import Pose
from ..xray import Label, Picture, View

OUTSIDE, COVERED, CLEAR = 0, 1, 2
"""The visibility of a point has one of three values. OUTSIDE: the point is outside the picture. COVERED: the point is
in the picture, but another object lies over it, or the mask of the point's tool has no pixel there. CLEAR: the point is
in the picture, and no other object lies over it."""

KEYPOINTS, KEYPOINT_MM = 32, 5.0
COLUMNS = ("position", "arc_mm", "x_mm", "y_mm", "z_mm", "column", "row", "visibility")
"""Of the array of centrelines."""

Floats = npt.NDArray[np.float64]

_BITS = [(label.name or "", label.bit_length() - 1) for label in Label]  # names and numbers of the bits


class Point(NamedTuple):
    """A point of a tool."""

    mm: tuple[float, float, float]
    px: tuple[float, float]
    visibility: int


@dataclass(frozen=True)
class ToolLabel:
    """One tool of a frame."""

    position: int
    """The tool's place among the nested tools, 0 for the innermost one. In the label image, the tool's bit is
    1 << position."""
    file: str
    name: str
    kind: str
    """"guidewire", "catheter" or "balloon catheter"."""
    inserted_mm: float
    vessel: str
    """The name of the vessel in which the tip lies, or "" if the vessel is not known."""
    tip: Point
    markers: tuple[Point, ...]
    """The marker bands of a balloon that have left the introducer, in order from the tip."""
    centreline: Floats
    """The tool's centreline from the tip to the introducer, as float64 [n, 8] with the columns COLUMNS."""
    keypoints: Floats
    """Column, row and visibility of the points at 0, 5, 10 mm ... behind the tip, as float64 [KEYPOINTS, 3]; points
    that are not yet in the patient have zeros."""


@dataclass(frozen=True)
class LabelledFrame:
    """All data that the output formats store for one frame."""

    key: str
    index: int
    """In the whole data set."""
    shard: int
    number: int
    """In its shard."""
    block: int
    picture: Picture
    view: View
    projection: Floats
    """The projection, as float64 [3, 4]: this matrix times (x, y, z, 1) in mm gives (u w, v w, w), where u is the
    column and v the row in pixels."""
    tools: tuple[ToolLabel, ...]
    action: tuple[float, ...]
    """The commands until this frame: the push of each position in m/s, its turn in rad/s, and the pressure of the
    inflator in kPa."""
    force_N: tuple[float, ...]
    areas: dict[str, int]
    """Pixels of each mask."""
    facts: dict[str, Any]
    """Facts about the scene, the time, the contrast medium, the balloon and the stent."""

    @property
    def grey(self) -> npt.NDArray[np.uint8]:
        assert self.picture.grey is not None
        return self.picture.grey

    @property
    def raw(self) -> npt.NDArray[np.uint16]:
        assert self.picture.raw is not None
        return self.picture.raw

    @property
    def labels(self) -> npt.NDArray[np.uint8]:
        assert self.picture.labels is not None
        return self.picture.labels


def projection_of(view: View, size: int) -> Floats:
    """Returns the projection matrix for points whose coordinates are in mm."""
    scaled: Floats = view.matrix(size) * np.array([1e-3, 1e-3, 1e-3, 1.0])
    return scaled


def project(matrix: Floats, points_mm: Floats) -> Floats:
    """Returns the column and the row of each of the points [n, 3]. The function adds in a fixed order, so that every
    machine computes the same bits."""
    x, y, z = points_mm[:, 0], points_mm[:, 1], points_mm[:, 2]
    rows = [row[0] * x + row[1] * y + row[2] * z + row[3] for row in matrix]
    return np.stack([rows[0] / rows[2], rows[1] / rows[2]], axis=1)


def visibilities(pixels: Floats, labels: npt.NDArray[np.uint8], bit: int) -> npt.NDArray[np.int64]:
    """Returns the visibility of each point of a tool; `bit` is the tool's bit in the label image."""
    size = len(labels)
    inside = ((pixels >= 0.0) & (pixels < size)).all(axis=1)
    columns = np.where(inside, pixels[:, 0], 0.0).astype(np.int64)
    rows = np.where(inside, pixels[:, 1], 0.0).astype(np.int64)
    return np.where(inside, np.where(labels[rows, columns] == bit, CLEAR, COVERED), OUTSIDE)


def areas_of(labels: npt.NDArray[np.uint8]) -> dict[str, int]:
    """Returns the number of pixels of each mask."""
    counts = _core.count_bits(labels)
    return {name: counts[bit] for name, bit in _BITS}


class Axis:
    """The common centreline of the nested tools at one moment, in mm."""

    def __init__(self, pose: Pose) -> None:
        self._points = pose.positions_m.astype(np.float64) * 1e3
        self._arcs = pose.arcs_m.astype(np.float64) * 1e3
        # The last node is inside the introducer; tools end for a reader at its opening.
        self.end_mm = float(self._arcs[-1]) if len(self._arcs) else 0.0
        self._tips_mm = pose.tip_arcs_m.astype(np.float64) * 1e3
        self._inserted_mm = pose.inserted_m.astype(np.float64) * 1e3

    def is_inside(self, position: int) -> bool:
        """Returns True if the tool has left the introducer."""
        return bool(self._inserted_mm[position] > 0.0 and self._tips_mm[position] <= self.end_mm)

    def at(self, position: int, behind_mm: Floats) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """Returns the points of a tool at the given distances behind its tip, and tells for each point if it is in the
        patient."""
        arcs = self._tips_mm[position] + behind_mm
        points = np.stack([np.interp(arcs, self._arcs, self._points[:, k]) for k in range(3)], axis=1)
        return points, behind_mm <= self._inserted_mm[position]

    def arcs(self, position: int) -> Floats:
        """Returns the distances of a tool's nodes from its tip, in order from the tip to the introducer."""
        tip, inserted = self._tips_mm[position], self._inserted_mm[position]
        nodes = self._arcs[(self._arcs > tip + 1e-3) & (self._arcs - tip < inserted)]
        return np.concatenate([[0.0], nodes - tip, [inserted]])


class Trace(NamedTuple):
    """The positions of one tool's points in a frame."""

    tip: Point
    markers: tuple[Point, ...]
    centreline: Floats
    keypoints: Floats


def trace(
    axis: Axis, position: int, markers_mm: Sequence[float], matrix: Floats, labels: npt.NDArray[np.uint8]
) -> Trace:
    """Finds the tip, the marker bands, the centreline and the key points of a tool. The function projects all these
    points in one call, because this is faster."""
    arcs = axis.arcs(position)
    line, points = len(arcs), len(arcs) + KEYPOINTS
    behind = np.concatenate([arcs, np.arange(KEYPOINTS, dtype=np.float64) * KEYPOINT_MM, markers_mm])
    places, inside = axis.at(position, behind)
    pixels = project(matrix, places)
    seen = visibilities(pixels, labels, 1 << position)
    keypoints = np.column_stack([pixels[line:points], seen[line:points]])
    keypoints[~inside[line:points] | (seen[line:points] == OUTSIDE)] = 0.0
    number = np.full(line, float(position))
    made = [_point(places[k], pixels[k], seen[k]) for k in (0, *range(points, len(behind))) if k == 0 or inside[k]]
    return Trace(
        made[0],
        tuple(made[1:]),
        np.column_stack([number, arcs, places[:line], pixels[:line], seen[:line]]),
        keypoints,
    )


def _point(mm: Floats, px: Floats, visibility: int) -> Point:
    x, y, z, column, row = (float(number) for number in (*mm, *px))
    return Point((round(x, 3), round(y, 3), round(z, 3)), (round(column, 2), round(row, 2)), int(visibility))
