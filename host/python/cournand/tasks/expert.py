"""A scripted expert, which uses only the values of the state observation.

The expert pushes the tool, and turns its tip towards the target when the target is near. If the path to the target
becomes longer, or stays the same, the tip is in a wrong branch or caught: the expert then pulls the tool back, turns
it, and pushes again. The expert pushes slowly while the force on the wall is above half of the limit. Like every
policy, the expert knows the path along the vessels, but it knows neither the shape of the vessels nor the picture.
"""

from __future__ import annotations

from enum import Enum
from typing import Any

import numpy as np
import numpy.typing as npt

OBSERVED_M = 0.1  # unit of the points in the observation
NEAR_M = 0.06
GROWN_M = 0.012
PUSHES_WITHOUT_GAIN = 10
PULLS_MAX = 25
TURNS = 4
TURN_SPEED = 0.9
PROGRESS_M = 0.002
FORCE_PART = 0.5
SLOW = 0.3


class Phase(Enum):
    PUSH = 1
    PULL = 2
    TURN = 3


class Expert:
    """The expert in one episode."""

    def __init__(self, tools: int = 1, *, outer_tools_rest: bool = False) -> None:
        self.tools, self.outer_tools_rest = tools, outer_tools_rest
        self._phase, self._best_m, self._idle = Phase.PUSH, np.inf, 0
        self._low_m, self._steps = np.inf, 0

    def __call__(self, observation: npt.NDArray[np.float32], info: dict[str, Any]) -> npt.NDArray[np.float32]:
        """Returns the action for an observation, without using `info`."""
        figures = 12 + 3 * self.tools
        force, path_m = float(observation[figures]), float(observation[figures + 2])
        if self._phase is Phase.PUSH and self._is_stuck(path_m):
            self._phase, self._low_m, self._steps = Phase.PULL, path_m, 0
        if self._phase is Phase.PULL and not self._has_pulled(path_m):
            return self._action(-1.0, 0.0)
        if self._phase is Phase.TURN and self._steps > 0:
            self._steps -= 1
            return self._action(0.0, TURN_SPEED)
        if self._phase is Phase.TURN:
            self._phase, self._best_m, self._idle = Phase.PUSH, path_m, 0
        points = observation[:9].reshape(3, 3).astype(np.float64) * OBSERVED_M
        is_near = float(np.linalg.norm(points[0])) < NEAR_M
        push = SLOW if force > FORCE_PART else 0.5 if is_near else 1.0
        return self._action(push, float(np.clip(0.5 * bend_angle(points), -1.0, 1.0)) if is_near else 0.0)

    def _is_stuck(self, path_m: float) -> bool:
        """Returns True if pushing has not brought the tip nearer to the target."""
        if path_m < self._best_m - PROGRESS_M:
            self._best_m, self._idle = path_m, 0
        else:
            self._idle += 1
        return path_m > self._best_m + GROWN_M or self._idle > PUSHES_WITHOUT_GAIN

    def _has_pulled(self, path_m: float) -> bool:
        """Returns True when the tip is out of the wrong branch, where the path begins to grow longer; a turn is then
        due."""
        self._low_m, self._steps = min(self._low_m, path_m), self._steps + 1
        if not (path_m > self._low_m + GROWN_M and self._steps > 2) and self._steps <= PULLS_MAX:
            return False
        self._phase, self._steps = Phase.TURN, TURNS
        return True

    def _action(self, push: float, turn: float) -> npt.NDArray[np.float32]:
        """Moves the innermost tool; the other tools follow at the same speed without a turn, or rest."""
        outer = [0.0 if self.outer_tools_rest else push] * (self.tools - 1)
        return np.array([push, *outer, turn] + [0.0] * (self.tools - 1), dtype=np.float32)


def bend_angle(points: npt.NDArray[np.float64]) -> float:
    """Returns the angle, about the direction of the tip, from the side to which the tip bends to the side on which the
    target lies. `points` are three points of the tip's shape in m, relative to the target, beginning at the tip."""
    heading = points[0] - points[1]
    heading = heading / max(float(np.linalg.norm(heading)), 1e-9)
    bend, target = points[0] - 2.0 * points[1] + points[2], -points[0]
    bend, target = bend - heading * (bend @ heading), target - heading * (target @ heading)
    if np.linalg.norm(bend) < 1e-6 or np.linalg.norm(target) < 1e-6:
        return 0.0
    return float(np.arctan2(heading @ np.cross(bend, target), bend @ target))
