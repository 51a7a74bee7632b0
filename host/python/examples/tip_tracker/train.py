"""Trains the tracker: first on crops, which are cheap and show the tip, then on whole pictures."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from .data import STEP, Frames
from .judge import errors_of
from .model import CELL, Tracker, loss
from .noise import NOISE_CELL, SHARES, added_factor, drawn_noise

LEAST_NGY = 5.0  # the lowest dose whose noise the training imitates
AS_MADE_PART = 0.2  # of the examples: no noise is added to them
CONTRAST = (0.7, 1.4)  # factors on a picture
CROP_MARGIN = 24  # pixels between the tip and the edge of its crop
ANYWHERE_PART = 0.3  # of the crops: they may lie anywhere in their pictures, with or without the tip
COLUMNS = ("epoch", "seconds", "edge", "loss", "median_px", "within_3_px")
Batch = tuple[Tensor, Tensor, Tensor]
Rows = list[tuple[float, ...]]


@dataclass(frozen=True)
class Course:
    """How long and on what the tracker is trained."""

    crop_epochs: int = 9
    whole_epochs: int = 2
    crop: int = 192
    """Edge of a crop in pixels, a multiple of 64. A picture that is not larger is never cropped."""
    batch: int = 4
    """Pictures or crops of a batch."""
    rate: float = 2e-3
    """The largest rate of learning."""
    seed: int = 1
    is_short: bool = False
    """True if the network computes with bfloat16 numbers, which is twice as fast on processors that have them."""
    is_changed: bool = True
    """True if pictures are turned, flipped, scaled and made noisier each time."""
    least_nGy: float = LEAST_NGY
    """The lowest dose whose noise is imitated."""


def _turned(array: np.ndarray, turns: int, is_flipped: bool) -> np.ndarray:
    array = np.rot90(array, turns)
    return array[:, ::-1] if is_flipped else array


def turned_tip(tip: np.ndarray, size: int, turns: int, is_flipped: bool) -> np.ndarray:
    """Returns the place of a tip, [column, row], in a picture that numpy.rot90 has turned and that was then flipped."""
    column, row = float(tip[0]), float(tip[1])
    for _ in range(turns % 4):
        column, row = row, size - column
    return np.array([size - column if is_flipped else column, row], np.float32)


def example(frames: Frames, number: int, edge: int, course: Course, random: np.random.Generator) -> Batch:
    """Returns one picture float32 [1, edge, edge], its tip [2] and its mask [edge / CELL, edge / CELL]. A crop
    begins at a multiple of CELL. Most crops contain the tip; the place of any other tip is outside the crop."""
    picture, mask, tip = frames.pictures[number], frames.masks[number], frames.tips[number]
    size, noise = len(picture), frames.noise[number]
    if course.is_changed:
        turns, is_flipped = int(random.integers(4)), bool(random.integers(2))
        picture, mask = _turned(picture, turns, is_flipped), _turned(mask, turns, is_flipped)
        noise, tip = _turned(noise, turns, is_flipped), turned_tip(tip, size, turns, is_flipped)
    left, top = 0, 0
    if edge < size:
        middle = random.uniform(0, size, 2) if random.uniform() < ANYWHERE_PART else tip
        left, top = (_crop_begin(float(place), size, edge, random) for place in middle)
        picture = picture[top : top + edge, left : left + edge]
        cells = edge // CELL
        mask = mask[top // CELL : top // CELL + cells, left // CELL : left // CELL + cells]
        tip = tip - np.array([left, top], np.float32)
    flat = torch.from_numpy(np.ascontiguousarray(picture)).float() * STEP
    if course.is_changed:
        if random.uniform() >= AS_MADE_PART:
            rows, columns = (top + np.arange(edge)) // NOISE_CELL, (left + np.arange(edge)) // NOISE_CELL
            deviations = torch.from_numpy(np.ascontiguousarray(noise[rows[:, None], columns]))
            factor = added_factor(frames.facts[number]["dose_nGy"], course.least_nGy, random)
            flat = flat + factor * drawn_noise(deviations, float(random.uniform(*SHARES)))
        flat = flat * float(random.uniform(*CONTRAST))
    return flat[None], torch.from_numpy(tip), torch.from_numpy(np.ascontiguousarray(mask)).float()


def _crop_begin(place: float, size: int, edge: int, random: np.random.Generator) -> int:
    """Draws the first column or row of a crop which contains `place`, a multiple of CELL. The place is at least
    CROP_MARGIN pixels from the edge of the crop, unless it is nearer to the edge of the picture."""
    low, high = place + CROP_MARGIN - edge, place - CROP_MARGIN
    drawn = random.uniform(low, max(low, high))
    return int(min(max(drawn, 0), size - edge)) // CELL * CELL


def batches(frames: Frames, edge: int, count: int, course: Course, random: np.random.Generator) -> Iterator[Batch]:
    """Yields all frames once, in a random order, in batches of `count`. Frames that do not fill a batch are left
    out."""
    order = random.permutation(len(frames))
    for first in range(0, len(order) - min(count, len(order)) + 1, count):
        rows = [example(frames, int(k), edge, course, random) for k in order[first : first + count]]
        pictures, tips, masks = (torch.stack(parts) for parts in zip(*rows))
        yield pictures, tips, masks


def train(
    frames: Frames,
    watched: Frames | None,
    course: Course,
    after_epoch: Callable[[Tracker, Rows], None] = lambda tracker, rows: None,
    begin_with: Tracker | None = None,
) -> tuple[Tracker, Rows]:
    """Trains on frames whose tips are in the picture; returns the tracker, and a row of COLUMNS for each epoch. The
    figures of `watched` are those of frames which are not trained on. Calls `after_epoch` with what there is so far.
    With `begin_with`, this tracker learns on; without it, a new one begins."""
    torch.manual_seed(course.seed)
    random = np.random.default_rng(course.seed)
    tracker = begin_with if begin_with is not None else Tracker()
    tracker = tracker.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    optimiser = torch.optim.AdamW(tracker.parameters(), lr=course.rate, weight_decay=1e-4)
    size, count = frames.pictures.shape[1], course.batch
    plan = [min(course.crop, size)] * course.crop_epochs + [size] * course.whole_epochs
    steps = max(20, len(plan) * max(1, len(frames) // count) + 1)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, course.rate, total_steps=steps, pct_start=0.1)
    begin = time.monotonic()
    rows: Rows = []
    for epoch, edge in enumerate(plan, 1):
        tracker.train()
        losses = []
        for pictures, tips, masks in batches(frames, edge, count, course, random):
            optimiser.zero_grad(set_to_none=True)
            with torch.autocast("cpu", torch.bfloat16, enabled=course.is_short):
                made = tracker(pictures)
            value = loss(made.float(), tips, masks)
            value.backward()
            torch.nn.utils.clip_grad_norm_(tracker.parameters(), 5.0)
            optimiser.step()
            schedule.step()
            losses.append(float(value.detach()))
        seen = errors_of(tracker, watched)[0] if watched is not None and len(watched) else np.array([np.nan])
        row = (epoch, time.monotonic() - begin, edge, np.mean(losses), np.median(seen), np.mean(seen <= 3.0))
        rows.append(tuple(float(one) for one in row))
        after_epoch(tracker, rows)
    return tracker, rows


def write_curve(path: Path, rows: Rows) -> None:
    """Writes the rows of a training as a table with tabs between its columns."""
    lines = ["\t".join(COLUMNS)] + ["\t".join("%.4g" % one for one in row) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
