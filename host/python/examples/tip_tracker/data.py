"""Reads data sets of `python -m cournand.factory` (WebDataset) for the tracker.

The package keeps what it has read in one file of NumPy arrays, because it takes longer to decode the PNG files than to
train on them once. Columns and rows are in pixels of the whole picture, counted so that the centre of the first pixel
is at 0.5, as in the factory's files.
"""

from __future__ import annotations

import io
import json
import math
import tarfile
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image

from .model import CELL, flattened
from .noise import noise_of

TOOL_BITS = 1 | 2 | 4
NEAR_TIP = 16  # pixels on each side of a tip within which the contrast of its tool is measured
COVERED, CLEAR = 1, 2  # the visibility of a tip that another object covers, and of one that none covers
ARRAYS = ("pictures", "masks", "tips", "visible", "noise")
STEP = 1 / 250.0  # of the stored pictures, in units of the natural logarithm


class DataError(Exception):
    """A data set cannot be read; the message says what is wrong, where, and the remedy."""


@dataclass
class Frames:
    """The pictures of one or several data sets with the labels of their innermost tips."""

    pictures: np.ndarray
    """int8 [n, size, size]: the flattened logarithm of the detector's values in units of STEP."""
    masks: np.ndarray
    """bool [n, size / CELL, size / CELL]: True where a cell has a pixel of a tool."""
    tips: np.ndarray
    """float32 [n, 2]: column and row of the innermost tip in pixels."""
    visible: np.ndarray
    """uint8 [n]: the visibility of the tip, 0 outside, 1 covered, 2 clear."""
    noise: np.ndarray
    """float32 [n, size / NOISE_CELL, size / NOISE_CELL]: the deviation of the pictures' noise, by noise_of()."""
    facts: list[dict[str, Any]]
    """For each frame: key, scene, tools, dose_nGy and contrast: by how much the logarithm is lower on the pixels of the
    tool near the innermost tip than on those beside it, nan without a tool there."""

    def __len__(self) -> int:
        return len(self.tips)

    def chosen(self, numbers: np.ndarray) -> Frames:
        """Returns the frames of the given numbers, int [k]."""
        parts = (getattr(self, name)[numbers] for name in ARRAYS)
        return Frames(*parts, [self.facts[int(number)] for number in numbers])

    def seen(self, least: int = CLEAR) -> Frames:
        """Returns the frames whose tip is clear, or, with `least` = COVERED, those whose tip is in the picture."""
        return self.chosen(np.flatnonzero(self.visible >= least))


def innermost_tool(facts: dict[str, Any]) -> dict[str, Any] | None:
    """Returns the innermost tool that has left the introducer, or None if no tool has. Its tip is the one that a
    guidewire shows: catheters around it end before it, or cover it."""
    tools: list[dict[str, Any]] = facts["tools"]
    return min(tools, key=lambda tool: int(tool["position"])) if tools else None


def samples(folder: Path) -> Iterator[dict[str, bytes]]:
    """Yields the files of each frame of a data set, by their endings, in the order of the shards."""
    tars = sorted((folder / "webdataset").glob("*.tar"))
    if not tars:
        raise DataError(
            "%s has no webdataset/*.tar. Remedy: python -m cournand.factory --frames N --out %s" % (folder, folder)
        )
    for path in tars:
        try:
            yield from _of_tar(path)
        except (tarfile.TarError, OSError) as error:
            raise DataError("%s cannot be read (%s). Remedy: make the data set again" % (path, error)) from error


def _of_tar(path: Path) -> Iterator[dict[str, bytes]]:
    files: dict[str, bytes] = {}
    with tarfile.open(path) as tar:
        for member in tar:
            key, _, ending = member.name.partition(".")
            if files and files["key"] != key.encode():
                yield files
                files = {}
            opened = tar.extractfile(member)
            files.update({"key": key.encode(), ending: opened.read() if opened else b""})
    if files:
        yield files


def _image(content: bytes) -> np.ndarray:
    return np.array(Image.open(io.BytesIO(content)))


def read(folder: Path, keep: Path | None = None) -> Frames:
    """Reads a data set. With `keep`, the frames are read from this file if it was made from the same files, and are
    written into it if not."""
    identity = _identity(folder)
    kept = _kept(keep, identity) if keep is not None else None
    if kept is not None:
        return kept
    rows = [_row(files, folder) for files in samples(folder)]
    if len({row[0].shape for row in rows}) != 1:
        raise DataError("%s: its frames do not all have one size. Remedy: make the data set again" % folder)
    frames = Frames(*(np.stack([row[k] for row in rows]) for k in range(5)), [row[5] for row in rows])
    if keep is not None:
        keep.parent.mkdir(parents=True, exist_ok=True)
        arrays = {name: getattr(frames, name) for name in ARRAYS}
        part = keep.with_suffix(".part.npz")
        np.savez(part, identity=np.array(identity), facts=np.array(json.dumps(frames.facts)), **arrays)
        part.replace(keep)
    return frames


def _identity(folder: Path) -> str:
    """Returns a text that changes with the place, the size and the time of the files of a data set."""
    tars = sorted((folder.resolve() / "webdataset").glob("*.tar"))
    return json.dumps([(str(path), path.stat().st_size, path.stat().st_mtime_ns) for path in tars])


def _kept(keep: Path, identity: str) -> Frames | None:
    """Returns the frames of a file that read() has kept, or None if there is no such file for this data set."""
    try:
        with np.load(keep) as found:
            if "identity" not in found or str(found["identity"]) != identity:
                return None
            return Frames(*(found[name] for name in ARRAYS), json.loads(str(found["facts"])))
    except (OSError, ValueError, KeyError, zipfile.BadZipFile):
        return None


def _row(files: dict[str, bytes], folder: Path) -> tuple[Any, ...]:
    key = files["key"].decode()
    try:
        facts = json.loads(files["json"])
        raw, labels = _image(files["raw.png"]), _image(files["labels.png"])
    except KeyError as error:
        text = "%s: frame %s has no file %s. Remedy: make the data set again"
        raise DataError(text % (folder, key, error)) from error
    except (ValueError, OSError) as error:
        text = "%s: frame %s cannot be read (%s). Remedy: make the data set again"
        raise DataError(text % (folder, key, error)) from error
    size = len(raw)
    if size % (16 * CELL) or raw.shape != (size, size):  # the network halves the cells four times
        raise DataError("%s: frame %s has %d pixels. Remedy: --size N, a multiple of 64" % (folder, key, size))
    with torch.no_grad():
        flat = flattened(torch.from_numpy(raw.astype(np.float32))[None, None])[:, 0]
        noise = noise_of(flat)[0].numpy()
    picture = np.clip(np.round(flat[0].numpy() / STEP), -127, 127).astype(np.int8)
    is_tool = (labels & TOOL_BITS) != 0
    mask = is_tool.reshape(size // CELL, CELL, size // CELL, CELL).any(axis=(1, 3))
    tool = innermost_tool(facts)
    px, visibility = (tool["tip"]["px"], tool["tip"]["visibility"]) if tool else ((0.0, 0.0), 0)
    kept = {"key": key, "scene": facts["scene"], "tools": [tool["file"] for tool in facts["tools"]]}
    kept["dose_nGy"] = facts["dose"]["detector_nGy"]
    kept["contrast"] = contrast_at(flat[0].numpy(), (labels & (1 << tool["position"])) != 0, px) if tool else math.nan
    return picture, mask, np.array(px, np.float32), np.uint8(visibility), noise, kept


def contrast_at(flat: np.ndarray, is_tool: np.ndarray, px: Sequence[float]) -> float:
    """Returns the mean of `flat` [size, size] over the pixels without the tool, less that over the pixels with it,
    both within NEAR_TIP pixels of the column and row `px`; nan if there are none of either."""
    column, row = int(px[0]), int(px[1])
    near = tuple(slice(max(0, middle - NEAR_TIP), max(0, middle + NEAR_TIP + 1)) for middle in (row, column))
    values, on_tool = flat[near], is_tool[near]
    if not on_tool.any() or on_tool.all():
        return math.nan
    return float(values[~on_tool].mean() - values[on_tool].mean())


def split(frames: Frames, part: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Divides frames by shard: returns the numbers of the frames for training, and of those for watching the training,
    int [k] each. `part` (0 to 1) of the shards are for watching. Frames of one shard are alike, so no shard is in
    both."""
    shards = [fact["key"].partition("-")[0] for fact in frames.facts]
    names = sorted(set(shards))
    drawn = np.random.default_rng(seed).permutation(len(names))
    watched = {names[k] for k in drawn[: round(part * len(names))]}
    is_watched = np.array([shard in watched for shard in shards])
    return np.flatnonzero(~is_watched), np.flatnonzero(is_watched)
