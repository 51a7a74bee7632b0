"""Makes X-ray pictures of worlds, with label images."""

from __future__ import annotations

import enum
import os
import struct
import zlib
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from .scene import Scene
from .world import World

_LABELS, _NO_NOISE, _NO_SCATTER, _SEQUENCE, _LABELS_ONLY = 1, 2, 4, 8, 16


class Label(enum.IntFlag):
    """Bits of a label image. A pixel can have several."""

    TOOL_0 = 1
    TOOL_1 = 2
    TOOL_2 = 4
    MEDIUM = 8
    """Marks contrast medium in a vessel, if there is at least 1/32 mm of undiluted medium along the ray."""
    STENT = 16
    BALLOON = 32
    """The medium in a balloon."""


@dataclass(frozen=True)
class View:
    """Geometry and X-ray beam of a picture."""

    primary_deg: float = 0.0
    """Primary angle of the C-arm in degrees, -120 .. 120: positive towards LAO, negative towards RAO."""
    secondary_deg: float = 0.0
    """Secondary angle of the C-arm in degrees, -50 .. 50: positive cranial, negative caudal."""
    isocentre_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Point of the patient that lies at the isocentre."""
    source_detector_m: float = 1.05
    source_isocentre_m: float = 0.75
    field_m: float = 0.32
    """Width of the square field at the detector, 0.1 .. 0.45 m."""
    dose_nGy: float = 40.0
    """Dose at the detector per picture, 1 .. 10000 nGy."""

    def numbers(self) -> tuple[float, ...]:
        """Returns the view's numbers in the order of the C struct."""
        x, y, z = self.isocentre_m
        rest = (self.source_detector_m, self.source_isocentre_m, self.field_m, self.dose_nGy)
        return tuple(map(float, (self.primary_deg, self.secondary_deg, x, y, z, *rest)))

    def matrix(self, size: int = 512) -> npt.NDArray[np.float64]:
        """Returns the projection matrix P, float64 [3, 4]: P (x, y, z, 1), in m, is (u w, v w, w) with the column u and
        the row v in pixels; pixel centres have fractions of .5."""
        return np.array(_core.view_matrix(self.numbers(), size)).reshape(3, 4)

    def project(self, points_m: npt.ArrayLike, size: int = 512) -> npt.NDArray[np.float64]:
        """Returns the pixels, float64 [n, 2] as column and row, of points [n, 3] of the patient."""
        points = np.asarray(points_m, dtype=np.float64)
        scaled = np.concatenate([points, np.ones((len(points), 1))], axis=1) @ self.matrix(size).T
        return scaled[:, :2] / scaled[:, 2:]


class Picture(NamedTuple):
    """A picture; row 0 is the top row."""

    tick: int
    grey: npt.NDArray[np.uint8] | None
    """Grey values as on the screen, uint8 [size, size]. None without a picture."""
    raw: npt.NDArray[np.uint16] | None
    """Values of the detector in proportion to the dose, uint16 [size, size], 0 .. 16383. None without a picture."""
    labels: npt.NDArray[np.uint8] | None
    """Label image with the bits of Label, uint8 [size, size]. None without labels."""
    is_underexposed: bool
    tube_voltage_kV: float
    tube_current_mA: float
    pulse_ms: float
    air_kerma_uGy: float
    """At the reference point."""
    kap_Gy_cm2: float

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture, or the label image if there is no picture, as a grey PNG."""
        pixels = self.grey if self.grey is not None else self.labels
        if pixels is None:
            raise ValueError("there is neither a picture nor a label image")
        with open(path, "wb") as file:
            file.write(encode_png(pixels))


class XRay:
    """Renders pictures of one size for the worlds of one scene.

    Equal worlds, views and seeds give equal pictures, bit for bit, with any number of threads. Pictures take less time
    if the view does not change from picture to picture.
    """

    def __init__(self, scene: Scene, size: int = 512, *, threads: int = 1) -> None:
        """`size` is a multiple of 16 within 64 and 2048."""
        self.scene = scene
        self.size = size
        self._core: Any = _core.Renderer(scene._core, size, threads)

    def render(
        self,
        world: World,
        view: View | None = None,
        *,
        labels: bool = False,
        picture: bool = True,
        noise: bool = True,
        scatter: bool = True,
        sequence: bool = False,
        seed: int = 0,
        copy: bool = True,
    ) -> Picture:
        """Renders the present state of the world. If no view is given, the leading tip is at the isocentre.

        `picture=False` renders only the label image. With `sequence=True`, exposure and lag depend on the last picture
        of this renderer, as in real fluoroscopy. With `copy=False` the arrays are read-only views that change with the
        next picture of this renderer.
        """
        flags = 0
        if not picture:
            flags |= _LABELS_ONLY
        elif labels:
            flags |= _LABELS
        for is_set, flag in ((not noise, _NO_NOISE), (not scatter, _NO_SCATTER), (sequence, _SEQUENCE)):
            flags |= flag if is_set else 0
        seen = view if view is not None else View(isocentre_m=world.tip().tip_m)
        made = Picture._make(self._core.render(world._core, seen.numbers(), flags, seed))
        if not copy:
            return made
        return made._replace(
            grey=None if made.grey is None else made.grey.copy(),
            raw=None if made.raw is None else made.raw.copy(),
            labels=None if made.labels is None else made.labels.copy(),
        )


def encode_png(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Returns a grey PNG of a uint8 image."""
    height, width = pixels.shape
    rows = np.zeros((height, width + 1), dtype=np.uint8)  # each row begins with its filter: none
    rows[:, 1:] = pixels

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6))
        + chunk(b"IEND", b"")
    )
