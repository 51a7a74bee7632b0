"""Judges the tracker at several doses: the error, and how far the tool stands out from the noise, in data sets that
have the same courses and views and differ in the dose alone."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from .data import STEP, DataError, Frames
from .judge import FOUND, LABEL, errors_of, median_interval, shards_of
from .model import Tracker
from .noise import NOISE_CELL

COLUMNS = (
    *("dose_nGy", "clear", "median_px", "low_px", "high_px", "p25_px", "p75_px", "p90_px"),
    *("within_3_px", "contrast_to_noise"),
)
RATIO_COLUMNS = ("ratio_from", "ratio_to", "tips", "median_px", "within_3_px", "within_10_px")
RATIOS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, math.inf)  # the limits of the classes of contrast to noise
EXAMPLES = (0.3, 0.5, 0.7, 0.85)  # the ranks of the frames that the sheet shows, by their error at the lowest dose
EDGE, CUT = 150, 120  # of an example in the sheet, and of the part of the picture that it shows, in pixels
PLOT = (96, 60, 300)  # left, top and height of the plot in the sheet, in pixels
LEAST_PX, MOST_PX, GOAL_PX = 0.5, 500.0, 3.0
Row = tuple[float, ...]


def ratios_of(frames: Frames) -> np.ndarray:
    """Returns for each frame the contrast of the innermost tool near its tip, divided by the deviation of the noise of
    one pixel there: float64 [n], nan where no pixel of the tool is near. See contrast_at() and noise_of()."""
    cells = np.clip(frames.tips.astype(int) // NOISE_CELL, 0, frames.noise.shape[1] - 1)
    noise = frames.noise[np.arange(len(frames)), cells[:, 1], cells[:, 0]]
    return np.array([fact["contrast"] for fact in frames.facts]) / np.maximum(noise, STEP / 10)


def by_dose(
    tracker: Tracker, sets: list[tuple[float, Frames]], is_turned: bool = False
) -> tuple[list[Row], list[Row], Image.Image]:
    """Judges the clear tips of each set. Returns a row of COLUMNS for each dose, a row of RATIO_COLUMNS for each class
    of contrast to noise in all sets together, and a sheet with a plot and examples. The sets have the same courses, and
    therefore the same clear tips but for a few."""
    sets = [(dose, frames.seen()) for dose, frames in sorted(sets, key=lambda one: one[0])]
    if any(len(frames) == 0 for _, frames in sets):
        raise DataError("a data set has no clear tip. Remedy: more frames")
    found = [errors_of(tracker, frames, is_turned) for _, frames in sets]
    errors = [one[0] for one in found]
    rows = [_row(dose, frames, one) for (dose, frames), one in zip(sets, errors)]
    ratios = np.concatenate([ratios_of(frames) for _, frames in sets])
    sheet = _sheet(rows, sets, [one[2] for one in found], errors)
    return rows, _ratio_rows(ratios, np.concatenate(errors)), sheet


def _row(dose: float, frames: Frames, errors: np.ndarray) -> Row:
    interval = median_interval(errors, shards_of(frames))
    parts = (float(np.percentile(errors, part)) for part in (25, 75, 90))
    within = float(np.mean(errors <= GOAL_PX))
    return (dose, len(frames), float(np.median(errors)), *interval, *parts, within, _median(ratios_of(frames)))


def _median(values: np.ndarray) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else math.nan


def _ratio_rows(ratios: np.ndarray, errors: np.ndarray) -> list[Row]:
    made: list[Row] = []
    for low, high in zip(RATIOS, RATIOS[1:]):
        chosen = errors[(ratios >= low) & (ratios < high)]
        if len(chosen):
            within = (float(np.mean(chosen <= limit)) for limit in (GOAL_PX, 10.0))
            made.append((low, high, len(chosen), float(np.median(chosen)), *within))
    return made


def write_table(path: Path, columns: tuple[str, ...], rows: list[Row]) -> str:
    """Writes a table with tabs between its columns, and returns its text."""
    text = "".join("\t".join(line) + "\n" for line in [columns, *(tuple("%.3g" % one for one in row) for row in rows)])
    path.write_text(text, encoding="utf-8")
    return text


# --- the sheet ---


def _sheet(
    rows: list[Row], sets: list[tuple[float, Frames]], places: list[np.ndarray], errors: list[np.ndarray]
) -> Image.Image:
    """Draws the error against the dose, and below it the same tips at all doses in columns: the label in green, the
    found place in red where it is within the part that is shown."""
    left, top, height = PLOT
    below = top + height + 70
    made = Image.new("RGB", (left + len(rows) * (EDGE + 4), below + len(EXAMPLES) * (EDGE + 4)), (255, 255, 255))
    draw = ImageDraw.Draw(made)
    _plot(draw, rows)
    keys = [{fact["key"]: k for k, fact in enumerate(frames.facts)} for _, frames in sets]
    common = [key for key in keys[0] if all(key in one for one in keys)]
    order = sorted(common, key=lambda key: float(errors[0][keys[0][key]]))
    for line, rank in enumerate(EXAMPLES if order else ()):
        key = order[int(rank * (len(order) - 1))]
        for column, (_, frames) in enumerate(sets):
            number = keys[column][key]
            tile = _example(frames, number, places[column][number], float(errors[column][number]))
            made.paste(tile, (left + column * (EDGE + 4), below + line * (EDGE + 4)))
    return made


def _height(error: float) -> float:
    """Returns the row in the sheet of an error in pixels, on a logarithmic scale."""
    part = math.log(min(max(error, LEAST_PX), MOST_PX) / LEAST_PX) / math.log(MOST_PX / LEAST_PX)
    return PLOT[1] + PLOT[2] * (1 - part)


def _plot(draw: ImageDraw.ImageDraw, rows: list[Row]) -> None:
    left, _, _ = PLOT
    right, ink, pale = left + len(rows) * (EDGE + 4), (20, 20, 20), (215, 215, 215)
    for tick in (1, 3, 10, 30, 100, 300):
        draw.line([(left, _height(tick)), (right, _height(tick))], fill=(60, 160, 80) if tick == GOAL_PX else pale)
        draw.text((left - 44, _height(tick) - 6), "%d px" % tick, fill=ink)
    draw.text((left, 12), "error of clear tips: median, and from the first to the third quartile", fill=ink)
    draw.text((left, 28), "green line: the goal for the median, %g px" % GOAL_PX, fill=ink)
    middles = []
    for column, row in enumerate(rows):
        named = dict(zip(COLUMNS, row))
        middle = left + (column + 0.5) * (EDGE + 4)
        quartiles = [(middle, _height(named["p25_px"])), (middle, _height(named["p75_px"]))]
        draw.line(quartiles, fill=(120, 140, 200), width=9)
        middles.append((middle, _height(named["median_px"])))
        text = "%g nGy\ncontrast / noise %.1f" % (named["dose_nGy"], named["contrast_to_noise"])
        draw.multiline_text((middle - 56, _height(LEAST_PX) + 18), text, fill=ink, align="center")
    draw.line(middles, fill=(180, 40, 40), width=2)
    for (x, y), row in zip(middles, rows):
        draw.ellipse((x - 5, y - 5, x + 5, y + 5), fill=(180, 40, 40))
        draw.text((x + 9, y - 14), "%.1f" % row[COLUMNS.index("median_px")], fill=(180, 40, 40))


def _example(frames: Frames, number: int, found: np.ndarray, error: float) -> Image.Image:
    size, tip = len(frames.pictures[number]), frames.tips[number]
    begin = [int(min(max(float(one) - CUT / 2, 0), size - CUT)) for one in tip]
    cut = frames.pictures[number][begin[1] : begin[1] + CUT, begin[0] : begin[0] + CUT].astype(np.float32) * STEP
    grey = np.clip(128 + 400 * cut, 0, 255).astype(np.uint8)
    tile = Image.fromarray(grey).convert("RGB").resize((EDGE, EDGE), Image.BOX)
    draw, scale = ImageDraw.Draw(tile), EDGE / CUT
    for place, colour, radius in ((tip, LABEL, 9), (found, FOUND, 5)):
        x, y = ((float(one) - first) * scale for one, first in zip(place, begin))
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), outline=colour)
    draw.text((4, 3), "%.1f px" % error, fill=(255, 255, 0))
    return tile
