"""Ranges for properties of tools and pictures, from which environments and the factory of labelled pictures draw random
values."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

Range = tuple[float, float]


@dataclass(frozen=True)
class Randomise:
    """Ranges from which uniformly distributed values are drawn for every episode; the ranges (1, 1) for factors and (0,
    0) for angles change nothing.

    The factors for tools are those of Tool.scaled(). A changed tool needs a new world, which takes milliseconds instead
    of microseconds, and needs a new approach to where the task begins.
    """

    bend_stiffness: Range = (1.0, 1.0)
    twist_stiffness: Range = (1.0, 1.0)
    mass: Range = (1.0, 1.0)
    friction: Range = (1.0, 1.0)
    rest_curvature: Range = (1.0, 1.0)
    primary_deg: Range = (0.0, 0.0)
    """Range of the angle that is added to the angle of the task's view."""
    secondary_deg: Range = (0.0, 0.0)
    dose: Range = (1.0, 1.0)
    """Range of the factor for the dose of the task's view."""
    heart_rate_per_min: Range = (0.0, 0.0)
    """Range of the heart rate, within 40 .. 160 per minute; (0, 0) keeps the rate at which a world begins, 70 per
    minute."""
    scenes: tuple[str, ...] = ()
    """Paths or shipped names of scenes, one of which is used for each episode; with (), every episode uses the scene of
    the task. Each scene must have vessels with the names of the task's targets."""

    def __post_init__(self) -> None:
        for name in self._ranges():
            low, high = getattr(self, name)
            if not low <= high:
                raise ValueError("Randomise.%s: %r is not (low, high)" % (name, (low, high)))
        low, high = self.heart_rate_per_min
        if (low, high) != (0.0, 0.0) and not HEART_RATES[0] <= low <= high <= HEART_RATES[1]:
            raise ValueError("Randomise.heart_rate_per_min: %r is not within %r" % ((low, high), HEART_RATES))
        if isinstance(self.scenes, str) or len(set(self.scenes)) != len(self.scenes):
            raise ValueError("Randomise.scenes: %r is not a tuple of different scenes" % (self.scenes,))

    def _ranges(self) -> list[str]:
        return [field.name for field in fields(self) if field.name != "scenes"]

    @property
    def changes_tools(self) -> bool:
        return any(getattr(self, name) != (1.0, 1.0) for name in TOOL_FACTORS)

    def draw(self, random: np.random.Generator) -> dict[str, float]:
        """Draws a number for every range, even if the range allows only one value, so that changing one range does not
        change the numbers of the others."""
        drawn = {name: float(random.uniform(*getattr(self, name))) for name in self._ranges()}
        drawn["scene"] = float(random.integers(max(len(self.scenes), 1)))  # its number in `scenes`
        return drawn


HEART_RATES = (40.0, 160.0)
TOOL_FACTORS = ("bend_stiffness", "twist_stiffness", "mass", "friction", "rest_curvature")
