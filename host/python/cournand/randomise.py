"""Ranges of properties of tools and pictures, from which environments and the factory of labelled pictures draw."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

Range = tuple[float, float]


@dataclass(frozen=True)
class Randomise:
    """Ranges from which every episode draws, evenly; (1, 1) and (0, 0) change nothing.

    Factors on the tools are those of Tool.scaled(). A changed tool needs a new world, which takes milliseconds instead
    of microseconds, and repeats the approach of the task.
    """

    bend_stiffness: Range = (1.0, 1.0)
    twist_stiffness: Range = (1.0, 1.0)
    mass: Range = (1.0, 1.0)
    friction: Range = (1.0, 1.0)
    rest_curvature: Range = (1.0, 1.0)
    primary_deg: Range = (0.0, 0.0)
    """Added to the angle of the task's view."""
    secondary_deg: Range = (0.0, 0.0)
    dose: Range = (1.0, 1.0)
    """Factor on the dose of the task's view."""

    def __post_init__(self) -> None:
        for field in fields(self):
            low, high = getattr(self, field.name)
            if not low <= high:
                raise ValueError("Randomise.%s: %r is not (low, high)" % (field.name, (low, high)))

    @property
    def changes_tools(self) -> bool:
        return any(getattr(self, name) != (1.0, 1.0) for name in TOOL_FACTORS)

    def draw(self, random: np.random.Generator) -> dict[str, float]:
        """Draws every number, whether its range is empty or not, so that one range does not change another's draw."""
        return {field.name: float(random.uniform(*getattr(self, field.name))) for field in fields(self)}


TOOL_FACTORS = ("bend_stiffness", "twist_stiffness", "mass", "friction", "rest_curvature")
