"""Describes what an environment demands of its policy, and computes the distance to the target along the vessels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Union

import numpy as np
import numpy.typing as npt

from ..randomise import TOOL_FACTORS, Randomise, Range
from ..scene import Scene
from ..xray import View

__all__ = [
    "AORTA",
    "ARCH_BRANCH",
    "TASKS",
    "TOOL_FACTORS",
    "Exchange",
    "Move",
    "Randomise",
    "Task",
    "VesselPaths",
    "task_of",
]


class Move(NamedTuple):
    """A move of an approach: the tool at a position is pushed or pulled until it is inserted by a length."""

    position: int
    """0 for the innermost tool."""
    inserted_m: float
    """Length beyond the introducer's opening, from -0.005 (outside) to 2."""
    speed_m_per_s: float = 0.06


class Exchange(NamedTuple):
    """An exchange of an approach: another tool takes the place at a position. The tools there must be outside."""

    position: int
    tool: str


@dataclass(frozen=True)
class Task:
    """The task is to bring the tip of the innermost tool to a target without pressing the wall with more than a
    limiting force.

    The target is a random point on the centrelines of the vessels `targets`; it is reached if the tip is within
    `reach_m` of it. The episode then terminates; it is a success only if the largest wall force was at most
    `force_limit_N`. The episode also terminates if the simulation leaves its valid range, and is truncated after
    `steps` steps.
    """

    targets: tuple[str, ...]
    """Names of vessels."""
    scene: str = "aorta"
    """Path or shipped name."""
    tools: tuple[str, ...] = ("j_wire",)
    approach_m: float = 0.0
    """Length by which the tools are pushed in at 60 mm/s before the episode begins."""
    approach: tuple[Union[Move, Exchange], ...] = ()
    """Moves and exchanges before the episode begins, instead of `approach_m`. Afterwards the tools in use must be
    `tools`."""
    approach_tools: tuple[str, ...] = ()
    """Further tools, which only the approach uses. The first of them begins at position 0."""
    target_part: Range = (0.0, 1.0)
    """Part of each target vessel in which targets lie, from 0 (its beginning, where the blood enters) to 1 (its
    end)."""
    steps: int = 300
    ticks: int = 133
    """Ticks of 1 ms in one step; 133 ticks give 7.5 steps per second."""
    reach_m: float = 0.005
    force_limit_N: float = 2.0
    """Limit for the sum of all contact forces in every sample. A shorter peak of the force between two samples is not
    seen."""
    contact_ticks: int = 19
    """Ticks between two samples of the contact forces, from 1 to `ticks`, so that every step has at least one
    sample."""
    push_max_m_per_s: float = 0.035
    turn_max_rad_per_s: float = 3.14
    contrast_max_ml_per_s: float = 4.0
    """Flow of contrast medium that an action of 1 demands, if the environment has contrast medium."""
    contrast_limit_ml: float = 60.0
    """Volume of contrast medium for one episode; after that, the syringe is empty."""
    c_arm_max_deg_per_s: float = 25.0
    """Speed of the C-arm's two angles for an action of 1, if the environment has a C-arm."""
    view: View = View()
    """The C-arm's view; its isocentre is moved to the target, so the target is in the middle of every picture."""
    reward_reached: float = 1.0
    reward_per_m: float = 1.0
    """Reward for each metre by which the path to the target becomes shorter."""
    reward_per_step: float = -0.005
    reward_per_picture: float = 0.0
    """Reward for every picture that is made with the pedal down, if the environment has a C-arm."""

    def __post_init__(self) -> None:
        if not self.targets or not 1 <= self.steps <= 1_000_000 or not 1 <= len(self.tools) <= 3:
            raise ValueError("Task: it needs a target, one to three tools, and 1 to 1000000 steps")
        low, high = self.target_part
        if not 0.0 <= low <= high <= 1.0:
            raise ValueError("Task.target_part: %r is not within 0 and 1" % (self.target_part,))
        if not 1 <= self.contact_ticks <= self.ticks:
            raise ValueError(
                "Task.contact_ticks: %r is not within 1 and %r, `ticks`" % (self.contact_ticks, self.ticks)
            )
        for name, most in (("contrast_max_ml_per_s", 50.0), ("contrast_limit_ml", 1e4), ("c_arm_max_deg_per_s", 180.0)):
            if not 0.0 < getattr(self, name) <= most:
                raise ValueError("Task.%s: %r is not above 0 and at most %g" % (name, getattr(self, name), most))
        self._check_approach()
        if not 0.0 < self.force_limit_N < math.inf:
            raise ValueError("Task.force_limit_N: %r is not a force above 0" % (self.force_limit_N,))

    def _check_approach(self) -> None:
        if self.approach and self.approach_m:
            raise ValueError("Task: it has both `approach` and `approach_m`")
        if self.approach_tools and not self.approach:
            raise ValueError("Task.approach_tools: there is no `approach` that uses them")
        line = self.first_line()
        for number, one in enumerate(self.approach):
            where = "Task.approach[%d]: " % number
            if not isinstance(one, (Move, Exchange)):
                raise ValueError(where + "%r is neither a Move nor an Exchange" % (one,))
            if not 0 <= one.position < len(line):
                raise ValueError(where + "there is no position %r" % (one.position,))
            if isinstance(one, Exchange):
                if one.tool not in self.all_tools():
                    raise ValueError(where + "%r is not in `tools` or `approach_tools`" % (one.tool,))
                line[one.position] = one.tool
            elif not (-0.005 <= one.inserted_m <= 2.0 and 0.0 < one.speed_m_per_s <= 0.2):
                raise ValueError(where + "%r is not within -0.005 and 2 m, or its speed not within 0.2 m/s" % (one,))
        if tuple(line) != self.tools:
            raise ValueError("Task.approach: it ends with the tools %s, not with `tools`" % ", ".join(line))

    def all_tools(self) -> tuple[str, ...]:
        """Returns the names of all tools of a world: those in use, and those of the approach."""
        return self.tools + self.approach_tools

    def first_line(self) -> list[str]:
        """Returns the name of the tool at each position at tick 0."""
        return list(self.approach_tools[:1] + self.tools[1:] if self.approach_tools else self.tools)


AORTA = Task(targets=("descending aorta",), target_part=(0.2, 0.9), steps=300)
ARCH_BRANCH = Task(
    targets=("brachiocephalic artery", "left common carotid artery", "left subclavian artery"),
    target_part=(0.3, 0.7),
    approach_m=0.55,
    steps=200,
)


TASKS = {"aorta": AORTA, "arch_branch": ARCH_BRANCH}


def task_of(given: Task | str) -> Task:
    """Returns the task with this name, or the given task itself."""
    if isinstance(given, Task):
        return given
    if given not in TASKS:
        raise ValueError("there is no task %r: there are %s" % (given, ", ".join(TASKS)))
    return TASKS[given]


class VesselPaths:
    """Computes distances along the centrelines of the tree of vessels in a scene."""

    def __init__(self, scene: Scene) -> None:
        if not scene.vessels:
            raise ValueError("the scene has no vessels: open its bodies")
        self._scene = scene
        self.parents = [vessel.parent for vessel in scene.vessels]
        self._along: list[npt.NDArray[np.float64]] = []
        self.begins = []  # where each vessel leaves its parent, along the parent
        for vessel in scene.vessels:
            points = vessel.points_m[:, :3].astype(np.float64)
            steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
            self._along.append(np.concatenate([[0.0], np.cumsum(steps)]))
            if vessel.parent < 0:
                self.begins.append(0.0)
                continue
            trunk = scene.vessels[vessel.parent].points_m[:, :3].astype(np.float64)
            nearest = int(np.argmin(np.linalg.norm(trunk - points[0], axis=1)))
            self.begins.append(float(self._along[vessel.parent][nearest]))

    def point(self, vessel: int, part: float) -> tuple[npt.NDArray[np.float64], float]:
        """Returns the point of a centreline at a given part of its length, and the length up to this point."""
        along, points = self._along[vessel], self._scene.vessels[vessel].points_m
        at = part * along[-1]
        return np.array([np.interp(at, along, points[:, axis]) for axis in range(3)]), float(at)

    def towards(self, vessel: int, along_m: float) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Returns, for each vessel, the position at which the shortest path to a target leaves this vessel, and the
        distance from this position to the target. The distance from a position `along` in a vessel to the target is
        abs(along - exits[vessel]) + beyond[vessel]."""
        exits, beyond = np.zeros(len(self.parents)), np.zeros(len(self.parents))
        on_path = {vessel}
        exits[vessel] = along_m
        child = vessel
        while self.parents[child] >= 0:  # the vessels through which the target is reached from the root
            parent = self.parents[child]
            exits[parent] = self.begins[child]
            beyond[parent] = exits[child] + beyond[child]
            on_path.add(parent)
            child = parent
        for other, parent in enumerate(self.parents):  # parents have lower numbers
            if other not in on_path and parent >= 0:
                beyond[other] = abs(self.begins[other] - exits[parent]) + beyond[parent]
        return exits, beyond
