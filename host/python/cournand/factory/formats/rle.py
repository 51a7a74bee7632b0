"""Masks as run lengths, as COCO's files have them: counts of pixels column by column, packed into text."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def runs(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """Returns the lengths of the runs of a mask, down its columns from the left, beginning with a run of zeros that may
    be empty."""
    flat = mask.T.ravel()
    changes = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    begins = [0] if flat.size and flat[0] else []
    ends = np.concatenate([begins, changes, [flat.size]]).astype(np.int64)
    return np.diff(ends, prepend=0)


def packed(counts: npt.NDArray[np.int64]) -> str:
    """Returns the text of run lengths. From the third on, each number is the difference to the number two before it.
    A number is written in groups of five bits, the lowest first; bit 5 says that another group follows; the last group
    carries the sign; 48 is added, so that every group is a letter."""
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
    """Returns the members `segmentation`, `area` and `bbox` of an annotation; the mask is not empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, left = int(rows[0]), int(columns[0])
    height, width = mask.shape
    return {
        "segmentation": {"size": [height, width], "counts": packed(runs(mask))},
        "area": int(np.count_nonzero(mask)),
        "bbox": [left, top, int(columns[-1]) - left + 1, int(rows[-1]) - top + 1],
    }
