"""Judges the tracker: the distance in pixels from the found tip to the labelled tip, in frames whose tip is clear."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from PIL import Image, ImageDraw

from .data import STEP, Frames
from .model import Tracker, located

BATCH = 8
EDGE = 256  # of a picture in a sheet
COLUMNS = ("set", "frames", "judged", "median_px", "p90_px", "within_3_px", "within_10_px", "sure", "sure_p90_px")
SURE = 0.5  # a tracker is sure of a tip if its window holds at least this probability
FOUND, LABEL = (255, 60, 60), (60, 230, 90)


def errors_of(tracker: Tracker, frames: Frames) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns for each frame the error in pixels [n], the probability within the window [n], and the place that the
    tracker found [n, 2]."""
    tracker.eval()
    places, sums = [], []
    with torch.no_grad():
        for first in range(0, len(frames), BATCH):
            flat = torch.from_numpy(frames.pictures[first : first + BATCH]).float()[:, None] * STEP
            place, inside = located(tracker(flat))
            places.append(place.numpy())
            sums.append(inside.numpy())
    found = np.concatenate(places)
    return np.linalg.norm(found - frames.tips, axis=1), np.concatenate(sums), found


def row_of(name: str, frames: Frames, errors: np.ndarray, sums: np.ndarray) -> tuple[str, ...]:
    """Returns a row of COLUMNS: `frames` is the whole set, and `errors` and `sums` are those of its clear tips."""
    sure = sums >= SURE
    numbers = (np.median(errors), np.percentile(errors, 90), np.mean(errors <= 3), np.mean(errors <= 10), np.mean(sure))
    p90 = np.percentile(errors[sure], 90) if sure.any() else np.nan
    return (name, str(len(frames)), str(len(errors)), *("%.3g" % one for one in (*numbers, p90)))


def judged(tracker: Tracker, name: str, frames: Frames, sheet: Path | None = None) -> tuple[str, ...]:
    """Judges a data set, and writes a sheet with good, middling and bad frames into `sheet`."""
    clear = frames.seen()
    errors, sums, found = errors_of(tracker, clear)
    if sheet is not None:
        order = np.argsort(errors, kind="stable")
        middle = len(order) // 2
        numbers = [*order[len(order) // 10 :][:4], *order[middle : middle + 4], *order[-4:]]
        _sheet(clear, numbers, found, errors).save(sheet)
    return row_of(name, frames, errors, sums)


def _sheet(frames: Frames, numbers: list[int], found: np.ndarray, errors: np.ndarray) -> Image.Image:
    """Draws frames in rows of four, with the labelled tip in green and the found one in red."""
    rows = -(-len(numbers) // 4)
    made = Image.new("RGB", (4 * (EDGE + 4), rows * (EDGE + 4)), (255, 255, 255))
    for place, number in enumerate(numbers):
        flat = frames.pictures[number].astype(np.float32) * STEP
        grey = np.clip(128 + 400 * flat, 0, 255).astype(np.uint8)
        tile = Image.fromarray(grey).convert("RGB").resize((EDGE, EDGE), Image.BOX)
        draw, scale = ImageDraw.Draw(tile), EDGE / len(flat)
        for (column, row), colour, radius in ((frames.tips[number], LABEL, 7), (found[number], FOUND, 4)):
            x, y = column * scale, row * scale
            draw.ellipse((x - radius, y - radius, x + radius, y + radius), outline=colour)
        draw.text((5, 4), "%.1f px" % errors[number], fill=(255, 255, 0))
        made.paste(tile, (place % 4 * (EDGE + 4), place // 4 * (EDGE + 4)))
    return made
