"""Masks in COCO's run-length encoding: the lengths of runs of equal pixels, counted down one column after the other,
and packed into text."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def runs(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """Returns the lengths of the runs of equal pixels in a mask, counted down one column after the other from the left;
    the first run is of zeros and may be empty."""
    flat = mask.T.ravel()
    changes = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    begins = [0] if flat.size and flat[0] else []
    ends = np.concatenate([begins, changes, [flat.size]]).astype(np.int64)
    return np.diff(ends, prepend=0)


def packed(counts: npt.NDArray[np.int64]) -> str:
    """Returns the text that encodes a list of run lengths. From the fourth run on, the text holds the difference
    between a run's length and the length of the run two places before it. A number is written in groups of five bits,
    the lowest bits first. If another group follows, 32 is added to the group. Bit 4 of the last group is the sign. Each
    group is written as the character whose code is 48 plus the group's value."""
    numbers = counts.copy()
    numbers[3:] -= counts[1:-2]
    letters: list[npt.NDArray[np.int64]] = []
    is_open = np.ones(len(numbers), dtype=bool)
    while is_open.any():
        group = numbers & 31
        numbers = numbers >> 5
        goes_on = np.where((group & 16) != 0, numbers != -1, numbers != 0) & is_open
        letters.append(np.where(is_open, group + np.where(goes_on, 32, 0) + 48, 0))
        is_open = goes_on
    table = np.stack(letters, axis=1) if letters else np.zeros((0, 1), dtype=np.int64)
    return bytes(table[table != 0].astype(np.uint8)).decode("ascii")


def annotation_of(mask: npt.NDArray[np.bool_]) -> dict[str, Any]:
    """Returns the members `segmentation`, `area` and `bbox` of an annotation for a mask that is not empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, left = int(rows[0]), int(columns[0])
    height, width = mask.shape
    return {
        "segmentation": {"size": [height, width], "counts": packed(runs(mask))},
        "area": int(np.count_nonzero(mask)),
        "bbox": [left, top, int(columns[-1]) - left + 1, int(rows[-1]) - top + 1],
    }
