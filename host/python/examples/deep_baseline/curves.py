"""Draws the curves of trainings: the share of safe successes over the steps."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from cournand.errors import BadFileError
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from .train import COLUMNS

EPISODES_LEAST = 20
"""Number of ended episodes from which a curve begins. Successes are short and end first, so the first shares would be
too high."""
Curve = dict[str, npt.NDArray[np.float64]]


def read_curve(path: str | os.PathLike[str]) -> Curve:
    """Reads the table of a training; returns an array for each column."""
    try:
        first, *lines = Path(path).read_text(encoding="utf-8").splitlines()
        if tuple(first.split("\t")) != COLUMNS or not lines:
            raise ValueError("it has not the columns %s, or no rows" % ", ".join(COLUMNS))
        rows = np.array([[float(one) for one in line.split("\t")] for line in lines])
    except (OSError, ValueError) as error:
        raise BadFileError(
            "%s is not the curve of a training (%s). Remedy: python -m deep_baseline train" % (path, error)
        ) from error
    return {name: rows[:, number] for number, name in enumerate(COLUMNS)}


def draw(curves: Sequence[tuple[str, Curve]], path: str | os.PathLike[str]) -> None:
    """Draws named curves into one PNG picture. Trainings of one task that differ in the seed (TASK_SEED) have one
    colour."""
    figure = Figure(figsize=(9.0, 4.2), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    tasks = list(dict.fromkeys(_task(name) for name, _ in curves))
    for name, curve in curves:
        task = _task(name)
        is_first = name == next(other for other, _ in curves if _task(other) == task)
        is_shown = curve["episodes"] >= EPISODES_LEAST
        axes.plot(
            curve["steps"][is_shown] / 1000.0,
            100.0 * curve["safe_success"][is_shown],
            color="C%d" % tasks.index(task),
            label=task if is_first else None,
            linewidth=1.4,
        )
    axes.set_xlabel("steps of all worlds, in thousands")
    axes.set_ylabel("safe successes of the last 50 training episodes, %")
    axes.set_ylim(-2.0, 102.0)
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    temporary = os.fspath(path) + ".part"
    figure.savefig(temporary, format="png", metadata={"Software": ""})
    os.replace(temporary, path)


def _task(name: str) -> str:
    head, _, tail = name.rpartition("_")
    return head if head and tail.isdecimal() else name
