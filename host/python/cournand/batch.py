"""Many worlds (simulated sessions) that a pool of threads advances together, without running Python code in between."""

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
"""Names of the values in the last columns of Batch.states."""


class Columns(NamedTuple):
    """Column ranges of Batch.states, by their contents."""

    points: slice
    """Columns of x, y and z of each point along the leading tip's shape, in m."""
    hands: slice
    """Columns of the inserted length in m, the force in N and the torque in N m of each of three positions; 0 if a
    position has no tool."""
    figures: slice
    """FIGURES."""


class Pool:
    """A pool of threads that work on many worlds. The results of a world do not depend on the number of threads.

    A pool starts its threads when it is made; the import of the package starts no thread. A child process of fork()
    must make its own pool.
    """

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads
        self._core = _core.Pool(threads)


class Batch:
    """Worlds that are moved, read into arrays and rendered by single calls, over a pool of threads.

    The arrays `states`, `places` and `vessels` are views, whose rows the methods of this class overwrite; the row
    number is the number of the world. Copy what must stay.
    """

    def __init__(self, pool: Pool, worlds: Sequence[World], *, points: int = 3, spacing_m: float = 0.002) -> None:
        """Makes a batch that reads `points` points along each leading tip, `spacing_m` apart."""
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
        """float32 [count, 4], one row per world: along_m, inside_m and radii of the tip at position 0 (see Place), and
        0."""
        self.vessels: npt.NDArray[np.int32] = self._core.vessels()
        """int32 [count], one number per world: the vessel in which the tip at position 0 lies; -1 if it is not
        known."""

    def put(self, number: int, world: World) -> None:
        """Replaces the world with this number."""
        self._core.put(number, world._core)

    def move(self, actions: npt.ArrayLike, ticks: int, which: Sequence[int] | None = None) -> None:
        """Moves worlds at constant speeds, and reads their states. `actions` is float32 [n, 8]: the pushes at positions
        0, 1 and 2 in m/s, the turns in rad/s, the inflator's pressure in kPa, and 0. `which` lists the numbers of the
        worlds to move; None stands for all worlds.

        If a number or `ticks` is refused, or if another thread is using one of the worlds, no world moves. If worlds
        fail while they move, the exception describes the first of them, and the other worlds have moved."""
        self._core.step(np.ascontiguousarray(actions, dtype=np.float32), ticks, self._which(which))

    def read(self, which: Sequence[int] | None = None) -> None:
        """Reads worlds into the arrays."""
        self._core.observe(self._which(which))

    def restore(self, snapshots: Sequence[bytes], which: Sequence[int] | None = None) -> None:
        """Restores one snapshot per world, and reads the states of the worlds. If a world refuses its snapshot, no
        world changes, and the exception describes the first such world. A world that has an order for its next tick is
        refused."""
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
        """Renders each world with its own view and seed. Returns all pictures and all label images as views, uint8
        [count, size, size], whose rows the next call overwrites; None stands for those that were not requested. All
        `renderers` must have the same size; there is one renderer per world, which keeps its view, or fewer renderers,
        which the worlds share. A renderer needs about 30 MB of memory. The first pictures determine the size of all
        later pictures of the batch."""
        flags = (1 if labels else 0) if picture else 16
        self._core.render(
            [one._core for one in renderers], [one.numbers() for one in views], flags, list(seeds), self._which(which)
        )
        return (self._core.grey() if picture else None), (self._core.labels() if labels or not picture else None)

    def _which(self, which: Sequence[int] | None) -> list[int]:
        return list(range(self.count)) if which is None else [int(one) for one in which]
