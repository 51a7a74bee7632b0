"""Reads recordings of sessions: their inputs as an array, and worlds that replay them."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from .scene import Scene

if TYPE_CHECKING:
    from .world import World

INPUT = np.dtype(
    [
        ("push_um", "<i4", 3),
        ("turn_counts", "<i4", 3),
        ("inflator_kPa", "<i4"),
        ("buttons", "<u4"),
        ("order_count", "<u4"),
        ("reserved", "<u4"),
        ("orders", [("kind", "<u4"), ("values", "<i4", 7)], 4),
    ]
)
"""Type of the exact input of one tick, with 168 bytes: counts of the hands since tick 0 (one per 1 um, and 65536 per
turn), buttons, and up to four orders."""


class RecordingInfo(NamedTuple):
    tick_count: int
    is_complete: bool
    """False if the recording was cut off; its inputs are complete up to tick_count."""
    core_version: int
    tool_count: int
    position_count: int
    scene_crc32: int
    """0: free space."""
    scene_path: str
    session: str
    last_hash: int
    """The last recorded full hash of the state, and its tick; 0 if there is none."""
    last_hash_tick: int


class Recording:
    """A recording that `cournand run`, the window or `World.record()` has made."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._core = _core.Recording(os.fspath(path))
        self.info = RecordingInfo._make(self._core.describe())

    def inputs(self, first: int = 0, count: int | None = None) -> npt.NDArray[Any]:
        """Returns the inputs of `count` ticks from `first` on as an array of the type `cournand.INPUT`."""
        number = self.info.tick_count - first if count is None else count
        if number < 0:
            raise ValueError("the recording has %d ticks" % self.info.tick_count)
        made = np.zeros(number, dtype=INPUT)
        self._core.inputs(first, made.view(np.uint8).reshape(number, INPUT.itemsize))
        return made

    def world(self, scene: Scene, *, patient: bool = False) -> World:
        """Makes a world with the recording's tools, line, entry and stents at tick 0. `scene` must be the scene of the
        recording."""
        from .world import world_of_recording

        return world_of_recording(self, scene, patient)

    def __repr__(self) -> str:
        return "<cournand.Recording of %s, %d ticks>" % (self.info.session, self.info.tick_count)
