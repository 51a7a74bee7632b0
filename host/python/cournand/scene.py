"""Scenes with their vessels, and tools."""

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
    """Number of an earlier vessel; -1: the root."""
    points_m: npt.NDArray[np.float32]
    """Read-only view, float32 [n, 4]: x, y, z and the radius of the lumen, in the direction of the blood flow."""
    length_m: float


class Scene:
    """A baked scene: the vessels that tools meet, and the bodies that X-rays meet.

    Scenes do not change, and any number of worlds, renderers and threads may share one.
    """

    def __init__(
        self, path: str | os.PathLike[str] | None = "aorta", bodies: str | os.PathLike[str] | None = None
    ) -> None:
        """Opens a scene by its path or by the name of a shipped one (`cournand.shipped_scenes()`).

        `path` None is free space without vessels. `bodies` None names the file X.bodies beside X.scene.
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
        """Unit vector from the opening into the vessel."""
        self.start_m: float = start
        """Length of the tools beyond the opening at tick 0, unless the world states another."""
        self.moves: bool = moves
        """True if heart or breath move the vessels."""
        self._vessels = tuple(Vessel(*self._core.vessel(i)) for i in range(vessel_count))

    @property
    def vessels(self) -> tuple[Vessel, ...]:
        """All vessels; empty if they are not known."""
        return self._vessels

    def find_vessel(self, name: str) -> int:
        """Returns the number of a vessel by its name, ignoring case, spaces and "artery"."""
        return self._core.find_vessel(name)

    def __repr__(self) -> str:
        return "<cournand.Scene %s, %d vessels>" % (self.name or "free space", len(self._vessels))


class Tool:
    """A guidewire or a catheter, as its file states it or scaled."""

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
        """Outer radius at the widest point, with the balloon folded."""
        self.has_balloon: bool = has_balloon
        self.markers_m: tuple[float, ...] = tuple(core.markers())
        """Middles of the radiopaque marker bands, from the tip, in ascending order."""

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

        Factors are 0.1 .. 10, and -10 .. 10 for the rest curvature of a preformed tip. What leaves the range of the
        core is refused when a world is made.
        """
        made = Tool.__new__(Tool)
        made._take(self._core.scaled(bend_stiffness, twist_stiffness, mass, friction, rest_curvature))
        return made

    def __repr__(self) -> str:
        return "<cournand.Tool %s, %.2f m>" % (self.name, self.length_m)
