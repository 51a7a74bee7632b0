"""Gives access to scenes with their vessels, and to the tools."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from .data import find


class Vessel(NamedTuple):
    """A vessel of a scene in its reference pose (heart and breath at rest)."""

    name: str
    parent: int
    """Number of the parent vessel in the list; -1 for the root."""
    points_m: npt.NDArray[np.float32]
    """Centreline as a read-only view, float32 [n, 4]: x, y, z and the radius of the lumen, in the direction of the
    blood flow."""
    length_m: float


class Scene:
    """A baked scene: the vessels, which guide the tools, and the bodies, which X-rays pass through.

    A scene does not change, and any number of worlds, renderers and threads may share it.
    """

    def __init__(
        self, path: str | os.PathLike[str] | None = "aorta", bodies: str | os.PathLike[str] | None = None
    ) -> None:
        """Opens a scene by its path or by a shipped name (`cournand.shipped_scenes()`).

        If `path` is None, the scene is free space without vessels. If `bodies` is None, the file X.bodies beside
        X.scene is used.
        """
        self._core = _core.Scene(
            None if path is None else find("scenes", ".scene", path), None if bodies is None else os.fspath(bodies)
        )
        name, crc32, entry, direction, start, vessel_count, moves = self._core.describe()
        self.name: str = name
        self.crc32: int = crc32
        self.entry_m: tuple[float, float, float] = entry
        """Centre of the introducer's opening."""
        self.direction: tuple[float, float, float] = direction
        """Unit vector that points from the introducer's opening into the vessel."""
        self.start_m: float = start
        """Length of the tools beyond the introducer's opening at tick 0, unless the options of the world state another
        length."""
        self.moves: bool = moves
        """True if the heartbeat or the breath moves the vessels."""
        self._vessels = tuple(Vessel(*self._core.vessel(i)) for i in range(vessel_count))

    @property
    def vessels(self) -> tuple[Vessel, ...]:
        """All vessels of the scene; empty if the scene has no bodies."""
        return self._vessels

    def find_vessel(self, name: str) -> int:
        """Returns the number of the vessel with this name; upper and lower case, spaces and the word "artery" make no
        difference."""
        return self._core.find_vessel(name)

    def __repr__(self) -> str:
        return "<cournand.Scene %s, %d vessels>" % (self.name or "free space", len(self._vessels))


class Tool:
    """A guidewire or a catheter, with the values of its file or with scaled values."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Opens an instrument file by its path or by a shipped name (`cournand.shipped_tools()`).

        "NAME:PRESET" chooses a preset of the file.
        """
        self._take(_core.Tool(find("instruments", ".toml", path)))

    def _take(self, core: Any) -> None:
        self._core = core
        name, is_catheter, length, radius, has_balloon = core.describe()
        self.name: str = name
        self.is_catheter: bool = is_catheter
        """True if the tool has a lumen."""
        self.length_m: float = length
        self.radius_max_m: float = radius
        """Outer radius of the tool at its widest point, with the balloon folded."""
        self.has_balloon: bool = has_balloon
        self.markers_m: tuple[float, ...] = tuple(core.markers())
        """Centres of the radiopaque marker bands, as distances from the tip, in ascending order."""

    def scaled(
        self,
        *,
        bend_stiffness: float = 1.0,
        twist_stiffness: float = 1.0,
        mass: float = 1.0,
        friction: float = 1.0,
        rest_curvature: float = 1.0,
    ) -> Tool:
        """Returns another tool with scaled properties, for domain randomisation.

        The factors are 0.1 .. 10; only the factor for the rest curvature of a preformed tip is -10 .. 10. A scaled
        value outside the core's range is refused when a world is made.
        """
        made = Tool.__new__(Tool)
        made._take(self._core.scaled(bend_stiffness, twist_stiffness, mass, friction, rest_curvature))
        return made

    def __repr__(self) -> str:
        return "<cournand.Tool %s, %.2f m>" % (self.name, self.length_m)
