"""Defines the actions of an environment: the numbers that a policy chooses in each step.

An action has these parts, in this order: the push of each tool, the turn of each tool, the flow of contrast medium, the
speeds of the C-arm's two angles, and the C-arm's pedal. The parts for contrast medium and for the C-arm exist only if
the environment has these options. Pushes, turns and angle speeds are from -1 to 1, relative to their largest speeds;
the flow and the pedal are from 0 to 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box, Discrete, MultiDiscrete, Space

# Push and turn of the actions of a discrete set, and the speeds of both angles of the C-arm.
TOOL_CHOICES = np.array([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1)], dtype=np.float32)
ANGLE_CHOICES = np.array([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)], dtype=np.float32)


class Actions:
    """The layout of an action."""

    def __init__(self, positions: int, kind: str, *, contrast: bool, c_arm: bool) -> None:
        if kind not in ("continuous", "discrete"):
            raise ValueError("action: %r is neither 'continuous' nor 'discrete'" % (kind,))
        self.positions, self.is_continuous = positions, kind == "continuous"
        self.push, self.turn = slice(0, positions), slice(positions, 2 * positions)
        self.contrast = 2 * positions if contrast else None
        """Column of the flow of contrast medium; None if the environment has no contrast medium."""
        self.c_arm = 2 * positions + int(contrast) if c_arm else None
        """Column of the primary angle's speed; the secondary angle's speed and the pedal are in the next two columns.
        The column of the primary angle's speed is None if the environment has no C-arm."""
        self.width = 2 * positions + int(contrast) + 3 * int(c_arm)

    def space(self) -> Space[Any]:
        """Returns the action space of a single environment."""
        if self.is_continuous:
            low = np.full(self.width, -1.0, dtype=np.float32)
            if self.contrast is not None:
                low[self.contrast] = 0.0
            if self.c_arm is not None:
                low[self.c_arm + 2] = 0.0
            return Box(low, np.ones(self.width, dtype=np.float32), dtype=np.float32)
        choices = self._choices()
        return Discrete(choices[0]) if len(choices) == 1 else MultiDiscrete(choices)

    def _choices(self) -> list[int]:
        choices = [len(TOOL_CHOICES)] * self.positions
        if self.contrast is not None:
            choices.append(2)
        if self.c_arm is not None:
            choices += [len(ANGLE_CHOICES), 2]
        return choices

    def parts(self, space: Space[Any], given: Any, count: int) -> npt.NDArray[np.float32]:
        """Returns the actions of `count` environments as numbers within their limits, float32 [count, width]. `space`
        is the common action space of all environments."""
        actions = np.asarray(given)
        if actions.dtype.kind not in ("fiu" if self.is_continuous else "iu"):
            wanted = "numbers" if self.is_continuous else "integers"
            raise TypeError("an action of the type %s is not made of %s" % (actions.dtype, wanted))
        if actions.shape != space.shape:
            raise ValueError("an action of the shape %s has not the shape %s" % (actions.shape, space.shape))
        if not self.is_continuous:
            return self._chosen(actions.astype(np.int64).reshape(count, -1))
        parts = actions.astype(np.float32).reshape(count, self.width)
        bad = np.flatnonzero(~np.isfinite(parts).all(axis=1))
        if len(bad):
            raise ValueError("the action of environment %d has a number that is not finite" % bad[0])
        limited: npt.NDArray[np.float32] = np.clip(parts, -1.0, 1.0)
        for column in (self.contrast, None if self.c_arm is None else self.c_arm + 2):
            if column is not None:
                limited[:, column] = np.maximum(limited[:, column], 0.0)
        return limited

    def _chosen(self, chosen: npt.NDArray[np.int64]) -> npt.NDArray[np.float32]:
        choices = np.array(self._choices())
        if np.any((chosen < 0) | (chosen >= choices)):
            raise ValueError("an action is not within 0 and %s" % ", ".join(str(one - 1) for one in choices))
        tools, numbers = TOOL_CHOICES[chosen[:, : self.positions]], chosen.astype(np.float32)
        columns = [tools[:, :, 0], tools[:, :, 1]]
        rest = self.positions
        if self.contrast is not None:
            columns.append(numbers[:, rest : rest + 1])
            rest += 1
        if self.c_arm is not None:
            columns += [ANGLE_CHOICES[chosen[:, rest]], numbers[:, rest + 1 : rest + 2]]
        return np.concatenate(columns, axis=1)
