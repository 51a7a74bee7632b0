"""Counts the frames of a shard for the page of statistics; the counts of several shards can be added."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from .frame import CLEAR, OUTSIDE, LabelledFrame

MAP_CELLS = 16
SEEN = {OUTSIDE: "outside", 1: "covered", CLEAR: "clear"}
MASKS = {
    "TOOL_0": "the innermost tool",
    "TOOL_1": "the second tool",
    "TOOL_2": "the third tool",
    "MEDIUM": "contrast medium",
    "STENT": "stents",
    "BALLOON": "balloons",
}
AREA_ENDS_PCT = (0.1, 0.3, 1.0, 3.0, 10.0, 100.0)


def _bin(value: float, width: float) -> str:
    return "%g" % (width * int(value // width))


def _area(part: float) -> str:
    """Returns the upper limit of the range into which a mask's area falls, in percent of the picture; an empty mask
    gives 0."""
    return "0" if part == 0.0 else "%g" % next(end for end in AREA_ENDS_PCT if part * 100.0 <= end)


class Tally:
    """The number of frames that have each value of each property."""

    def __init__(self) -> None:
        self._counts: dict[str, Counter[str]] = {}

    def _count(self, what: str, value: str) -> None:
        self._counts.setdefault(what, Counter())[value] += 1

    def add(self, frame: LabelledFrame) -> None:
        facts, view, size = frame.facts, frame.view, len(frame.labels)
        self._count("scene", str(facts["scene"]))
        self._count("tools", "+".join(tool.file for tool in frame.tools))
        self._count("motion", str(facts["motion"]))
        self._count("contrast phase", str(facts["contrast_phase"]))
        self._count("primary angle, degrees from", _bin(view.primary_deg, 10.0))
        self._count("secondary angle, degrees from", _bin(view.secondary_deg, 10.0))
        self._count("field, mm from", _bin(view.field_m * 1e3, 20.0))
        self._count("detector dose, nGy from", _bin(view.dose_nGy, 20.0))
        self._count("tube voltage, kV from", _bin(frame.picture.tube_voltage_kV, 5.0))
        self._count("heart phase from", _bin(float(facts["heart_phase"]), 0.1))
        self._count("breath phase from", _bin(float(facts["breath_phase"]), 0.1))
        if facts.get("stent"):
            self._count("stent", str(facts["stent"]))
        for name, area in frame.areas.items():
            self._count("area of %s, %% up to" % MASKS[name], _area(area / (size * size)))
        for tool in frame.tools:
            self._count("kind of tool", tool.kind)
            self._count("vessel of a tip", tool.vessel or "unknown")
            self._count("tip", SEEN[tool.tip.visibility])
            if tool.tip.visibility != OUTSIDE:
                column, row = (int(one * MAP_CELLS / size) for one in tool.tip.px)
                self._count("place of the tip", "%d,%d" % (column, row))

    def as_json(self) -> dict[str, dict[str, int]]:
        return {what: dict(sorted(counts.items())) for what, counts in sorted(self._counts.items())}


def added(tallies: Iterable[Mapping[str, Any]]) -> dict[str, dict[str, int]]:
    """Returns the sum of the counts of all shards."""
    total: dict[str, Counter[str]] = {}
    for tally in tallies:
        for what, counts in tally.items():
            total.setdefault(what, Counter()).update(counts)
    return {what: dict(sorted(counts.items())) for what, counts in sorted(total.items())}
