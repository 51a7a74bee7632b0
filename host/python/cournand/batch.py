"""Many worlds that advance together over a pool of threads, without Python code in between."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from . import _core
from .world import World
from .xray import View, XRay

FIGURES = (
    "wall_force_N",
    "wall_force_peak_N",
    "penetration_m",
    "length_error",
    "heart_phase",
    "breath_phase",
    "contact_count",
    "is_out_of_range",
)
"""What the last columns of Batch.states hold."""


class Columns(NamedTuple):
    """Where the numbers of Batch.states are."""

    points: slice
    """x, y and z of each point along the leading tip's shape, in m."""
    hands: slice
    """Length inserted in m, force in N and torque in N m of each of three positions; 0 where there is none."""
    figures: slice
    """FIGURES."""


class Pool:
    """Threads that work on many worlds. What a world computes does not depend on their number.

    A pool starts its threads when it is made, and none at import. A child of fork() makes its own pool.
    """

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads
        self._core = _core.Pool(threads)


class Batch:
    """Worlds that one call moves, reads into arrays and renders, over a pool of threads.

    The arrays `states`, `places` and `vessels` are views whose rows the calls below overwrite; a row belongs to the
    world with the same number. Copy what must stay.
    """

    def __init__(self, pool: Pool, worlds: Sequence[World], *, points: int = 3, spacing_m: float = 0.002) -> None:
        """Reads `points` points along each leading tip, `spacing_m` apart."""
        if not 0 <= points <= 1000 or not 0.0 <= spacing_m <= 1.0:
            raise ValueError("points is not within 0 and 1000, or spacing_m not within 0 and 1")
        self._core = cast(Any, _core.Batch(pool._core, len(worlds), points, spacing_m))
        self.count = len(worlds)
        for number, world in enumerate(worlds):
            self.put(number, world)
        self.columns = Columns(
            slice(0, 3 * points),
            slice(3 * points, 3 * points + 9),
            slice(3 * points + 9, 3 * points + 9 + len(FIGURES)),
        )
        self.states: npt.NDArray[np.float32] = self._core.states()
        """float32 [count, columns]."""
        self.places: npt.NDArray[np.float32] = self._core.places()
        """float32 [count, 4]: along_m, inside_m and radii of the tip of position 0 (Place), and 0."""
        self.vessels: npt.NDArray[np.int32] = self._core.vessels()
        """int32 [count]: the vessel of that tip; -1: not known."""

    def put(self, number: int, world: World) -> None:
        """Replaces the world with this number."""
        self._core.put(number, world._core)

    def move(self, actions: npt.ArrayLike, ticks: int, which: Sequence[int] | None = None) -> None:
        """Moves worlds at steady speeds, and reads them. `actions` is float32 [n, 8]: push at the positions 0, 1, 2 in
        m/s, turn in rad/s, pressure of the inflator in kPa, and 0. `which` names the worlds; None: all.

        If a number or `ticks` is refused, or another thread is inside one of the worlds, no world moves. If a world
        fails later, the exception is that of the first such world, and the others have moved."""
        self._core.step(np.ascontiguousarray(actions, dtype=np.float32), ticks, self._which(which))

    def read(self, which: Sequence[int] | None = None) -> None:
        """Reads worlds into the arrays."""
        self._core.observe(self._which(which))

    def restore(self, snapshots: Sequence[bytes], which: Sequence[int] | None = None) -> None:
        """Restores one snapshot per world, and reads the worlds. If a world refuses its snapshot, no world changes, and
        the exception is that of the first such world. A world with an order that waits for its next tick is refused."""
        self._core.restore(list(snapshots), self._which(which))

    def render(
        self,
        renderers: Sequence[XRay],
        views: Sequence[View],
        seeds: Sequence[int],
        *,
        labels: bool = False,
        picture: bool = True,
        which: Sequence[int] | None = None,
    ) -> tuple[npt.NDArray[np.uint8] | None, npt.NDArray[np.uint8] | None]:
        """Renders worlds with one view and one seed each, and returns all pictures and label images, uint8 [count,
        size, size], as views whose rows the next call overwrites; None for those that were not asked for. `renderers`
        are of one size: one per world, which keeps its view, or fewer that the worlds share. A renderer takes about
        30 MB. The first pictures decide the size of all pictures of the batch."""
        flags = (1 if labels else 0) if picture else 16
        self._core.render(
            [one._core for one in renderers], [one.numbers() for one in views], flags, list(seeds), self._which(which)
        )
        return (self._core.grey() if picture else None), (self._core.labels() if labels or not picture else None)

    def _which(self, which: Sequence[int] | None) -> list[int]:
        return list(range(self.count)) if which is None else [int(one) for one in which]
