"""Makes small coloured pictures that show a frame with its masks, its centrelines and its tips."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from . import png
from .frame import OUTSIDE, LabelledFrame

EDGE = 256
# Colours of the masks: tools, contrast medium, stent, balloon.
COLOURS = (
    (8, (80, 140, 255)),
    (4, (190, 120, 255)),
    (2, (255, 170, 40)),
    (1, (70, 220, 120)),
    (16, (255, 90, 200)),
    (32, (60, 220, 230)),
)
MASK_PART = 0.55
TIP = (255, 50, 50)
GAP = 4

Image = npt.NDArray[np.uint8]


def sample_of(frame: LabelledFrame) -> bytes:
    """Returns a PNG file with the picture on the left, and the same picture with coloured labels on the right."""
    step = max(1, len(frame.labels) // EDGE)
    grey = _reduced(frame.grey, step)
    plain = np.repeat(grey[:, :, None], 3, axis=2)
    marked = plain.copy()
    for bit, colour in COLOURS:
        mask = _any((frame.labels & np.uint8(bit)) != 0, step)
        marked[mask] = marked[mask] * (1.0 - MASK_PART) + np.array(colour) * MASK_PART
    for tool in frame.tools:
        if tool.tip.visibility != OUTSIDE:
            _cross(marked, tool.tip.px[0] / step, tool.tip.px[1] / step)
    gap = np.full((len(plain), GAP, 3), 255, dtype=np.uint8)
    return png.encode(np.concatenate([plain, gap, np.round(marked).astype(np.uint8)], axis=1), "flat")


def _reduced(pixels: Image, step: int) -> Image:
    edge = len(pixels) // step * step
    cells = pixels[:edge, :edge].reshape(edge // step, step, edge // step, step)
    reduced: Image = cells.mean(axis=(1, 3)).astype(np.uint8)
    return reduced


def _any(mask: npt.NDArray[np.bool_], step: int) -> npt.NDArray[np.bool_]:
    edge = len(mask) // step * step
    cells = mask[:edge, :edge].reshape(edge // step, step, edge // step, step)
    return np.asarray(cells.any(axis=(1, 3)))


def _cross(image: Image, column: float, row: float) -> None:
    """Draws a small cross with an open middle, so that the tip itself can be seen."""
    at_x, at_y = int(column), int(row)
    for offset in (*range(-7, -2), *range(3, 8)):
        for x, y in ((at_x + offset, at_y), (at_x, at_y + offset)):
            if 0 <= x < image.shape[1] and 0 <= y < image.shape[0]:
                image[y, x] = TIP


def sheet(pictures: Sequence[Image], columns: int) -> Image:
    """Joins pictures of equal size in rows, and returns them as one picture."""
    height, width = pictures[0].shape[:2]
    rows = -(-len(pictures) // columns)
    made = np.full((rows * (height + GAP) - GAP, columns * (width + GAP) - GAP, 3), 255, dtype=np.uint8)
    for number, picture in enumerate(pictures):
        top, left = number // columns * (height + GAP), number % columns * (width + GAP)
        made[top : top + height, left : left + width] = picture
    return made
