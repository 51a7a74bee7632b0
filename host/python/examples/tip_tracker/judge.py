"""Judges the tracker: the distance in pixels from the found tip to the labelled tip. Clear tips count; the errors of
covered tips stand beside them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from PIL import Image, ImageDraw

from .data import CLEAR, COVERED, STEP, DataError, Frames
from .model import Tracker, chances_of, located

BATCH = 8
EDGE = 256  # of a picture in a sheet
COLUMNS = (
    *("set", "inside", "clear", "median_px", "low_px", "high_px", "p90_px", "within_3_px", "within_10_px"),
    *("sure", "sure_p90_px", "covered_median_px"),
)
SHEET = 16  # the least number of clear tips for a sheet of pictures
RESAMPLES = 2000  # of the shards, for the interval of the median
SURE = 0.5  # a tracker is sure of a tip if its window holds at least this probability
FOUND, LABEL = (255, 60, 60), (60, 230, 90)


def errors_of(
    tracker: Tracker, frames: Frames, is_turned: bool = False
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns for each frame the error in pixels [n], the probability within the window [n], and the place that the
    tracker found [n, 2]. With `is_turned`, it looks at each picture in eight ways, which takes eight times as long."""
    tracker.eval()
    places, sums = [], []
    with torch.no_grad():
        for first in range(0, len(frames), BATCH):
            flat = torch.from_numpy(frames.pictures[first : first + BATCH]).float()[:, None] * STEP
            place, inside = located(chances_of(tracker, flat, is_turned))
            places.append(place.numpy())
            sums.append(inside.numpy())
    found = np.concatenate(places)
    return np.linalg.norm(found - frames.tips, axis=1), np.concatenate(sums), found


def row_of(name: str, frames: Frames, errors: np.ndarray, sums: np.ndarray) -> tuple[str, ...]:
    """Returns a row of COLUMNS for a set of frames, whose tips are all in the picture."""
    is_clear, shards = frames.visible == CLEAR, shards_of(frames)
    clear, covered = errors[is_clear], errors[~is_clear]
    sure = clear[sums[is_clear] >= SURE]
    count = max(1, len(clear))
    shares = (np.sum(clear <= 3) / count, np.sum(clear <= 10) / count, len(sure) / count)
    interval = median_interval(clear, [shards[k] for k in np.flatnonzero(is_clear)])
    numbers = (_part(clear, 50), *interval, _part(clear, 90), *shares, _part(sure, 90), _part(covered, 50))
    return (name, str(len(frames)), str(len(clear)), *("%.3g" % one for one in numbers))


def shards_of(frames: Frames) -> list[str]:
    """Returns the name of the shard of each frame."""
    return [str(fact["key"]).partition("-")[0] for fact in frames.facts]


def median_interval(errors: np.ndarray, shards: list[str]) -> tuple[float, float]:
    """Returns the interval of 95 % of the median error, by a bootstrap over shards: frames of one shard are alike, so
    whole shards are drawn again and again. `shards` names the shard of each error."""
    groups = [errors[np.array(shards) == one] for one in sorted(set(shards))]
    if not groups:
        return float("nan"), float("nan")
    random = np.random.default_rng(1)
    drawn = random.integers(len(groups), size=(RESAMPLES, len(groups)))
    medians = [float(np.median(np.concatenate([groups[k] for k in row]))) for row in drawn]
    return _part(np.array(medians), 2.5), _part(np.array(medians), 97.5)


def _part(errors: np.ndarray, percent: float) -> float:
    return float(np.percentile(errors, percent)) if len(errors) else float("nan")


def judged(
    tracker: Tracker, name: str, frames: Frames, sheet: Path | None = None, is_turned: bool = False
) -> list[tuple[str, ...]]:
    """Judges a data set: returns a row for all its frames, and one for each set of tools. Writes a sheet with good,
    middling and bad frames of clear tips into `sheet`."""
    frames = frames.seen(COVERED)
    if not len(frames):
        raise DataError("the set %s has no frame with a tip in the picture. Remedy: more frames" % name)
    errors, sums, found = errors_of(tracker, frames, is_turned)
    rows = [row_of(name, frames, errors, sums)]
    tools = np.array(["+".join(fact["tools"]) for fact in frames.facts])
    for one in sorted(set(tools)):
        numbers = np.flatnonzero(tools == one)
        rows.append(row_of("%s %s" % (name, one), frames.chosen(numbers), errors[numbers], sums[numbers]))
    clear = np.flatnonzero(frames.visible == CLEAR)
    if sheet is not None and len(clear) >= SHEET:
        order = clear[np.argsort(errors[clear], kind="stable")]
        ranks = [*range(len(order) // 10, len(order) // 10 + 4), *range(len(order) // 2, len(order) // 2 + 4)]
        _sheet(frames, [int(k) for k in (*order[ranks], *order[-4:])], found, errors).save(sheet)
    return rows


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
