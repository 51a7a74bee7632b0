"""The named tasks, from easy to hard, and the seeds of their episodes (docs/tasks.md).

The seed s of an episode determines two numbers, by two calls of numpy.random.default_rng(s).integers(0, 2**31): the
first one is for the anatomy, and the second one for the target. Anatomies with even numbers are for training, and those
with odd numbers are for judging.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count as count_from
from itertools import islice
from typing import NamedTuple

import numpy as np

from ..anatomies import need, path_of
from ..envs.task import Task

SPLITS = ("train", "judge")
BELOW_ARCH_M = 0.5
THREE_BRANCHES = ("brachiocephalic artery", "left common carotid artery", "left subclavian artery")


class EpisodeSeed(NamedTuple):
    """What decides an episode."""

    seed: int
    """Of the chain."""
    anatomy: int
    """Seed of the drawn anatomy; -1 stands for the scene of the task."""
    target: int
    """Seed with which the environment is reset."""


@dataclass(frozen=True)
class Challenge:
    """A task with a name, a version, and a set of anatomies."""

    name: str
    title: str
    task: Task
    source: str
    """Name of the task of another project that this task corresponds to."""
    pool: int = 0
    """Number of drawn anatomies, which have the seeds 0 .. pool - 1; 0 if only the scene of the task is used."""
    is_always_new: bool = False
    """True if every episode has its own anatomy, with a seed of 31 bits."""
    version: int = 1
    """Increases with every change that can change a score."""

    def __post_init__(self) -> None:
        if self.pool < 0 or self.pool % 2 or (self.pool and self.is_always_new):
            raise ValueError("Challenge.pool: %r is not an even number, or anatomies are always new" % self.pool)

    @property
    def is_drawn(self) -> bool:
        return self.pool > 0 or self.is_always_new

    def episode(self, seed: int) -> EpisodeSeed:
        """Returns the two numbers that follow from the seed of an episode."""
        random = np.random.default_rng(seed)
        vessel, target = int(random.integers(0, 2**31)), int(random.integers(0, 2**31))
        if not self.is_drawn:
            return EpisodeSeed(seed, -1, target)
        return EpisodeSeed(seed, vessel if self.is_always_new else vessel % self.pool, target)

    def _of_split(self, split: str) -> Iterator[EpisodeSeed]:
        if split not in SPLITS:
            raise ValueError("the split %r is not one of %s" % (split, ", ".join(SPLITS)))
        wanted = SPLITS.index(split)
        for seed in count_from():
            vessel = int(np.random.default_rng(seed).integers(0, 2**31))
            if vessel % 2 == wanted:
                yield self.episode(seed)

    def episodes(self, split: str, count: int) -> list[EpisodeSeed]:
        """Returns the first episodes of a split. Seeds 0, 1, 2, ... whose first number is even are for training, and
        those whose first number is odd are for judging. The list of seeds for training and the list of seeds for
        judging are fixed, and share neither a seed nor a drawn anatomy."""
        return list(islice(self._of_split(split), count))

    def anatomies(self, split: str, count: int = 100) -> list[int]:
        """Returns the seeds of the anatomies of the first `count` episodes, each seed once; if the task has a pool of
        anatomies, returns all seeds of the split."""
        if self.pool:
            return list(range(SPLITS.index(split), self.pool, 2))
        return list(dict.fromkeys(one.anatomy for one in self.episodes(split, count))) if self.is_always_new else []

    def one_episode_of_each(self, split: str) -> list[EpisodeSeed]:
        """Returns an episode for each anatomy of the task's pool in a split."""
        return [EpisodeSeed(-1, anatomy, -1) for anatomy in self.anatomies(split)]

    def scene(self, folder: str | os.PathLike[str], anatomy: int) -> str:
        """Returns the path of an anatomy's scene."""
        return str(path_of(folder, anatomy)) if anatomy >= 0 else self.task.scene

    def need_scenes(self, folder: str | os.PathLike[str], episodes: list[EpisodeSeed]) -> None:
        """Raises BadFileError with the remedy if the scene of an episode does not exist."""
        command = "python -m cournand.anatomies --task %s --out %s" % (self.name, os.fspath(folder))
        if self.is_always_new:
            command += " --episodes %d" % max(len(episodes), 1)
        need(folder, [one.anatomy for one in episodes if one.anatomy >= 0], command)

    def limited_to(self, steps: int) -> Challenge:
        """Returns the same task with shorter episodes, for a trial."""
        return replace(self, task=replace(self.task, steps=steps))


_ARCH = {"tools": ("terumo_stiff_angled",), "approach_m": BELOW_ARCH_M, "target_part": (0.3, 0.7), "steps": 300}

CHALLENGES = {
    challenge.name: challenge
    for challenge in (
        Challenge(
            "iliac",
            "a J wire along a winding iliac artery",
            Task(targets=("right iliac artery",), target_part=(0.1, 0.6), steps=90, force_limit_N=1.0),
            "NavTube and NavTortuous of Lumen",
            pool=8,
        ),
        Challenge(
            "subclavian",
            "a J wire from below the arch to the first branch on its way",
            Task(targets=("left subclavian artery",), approach_m=BELOW_ARCH_M, target_part=(0.3, 0.7), steps=150),
            "NavTreeBranch of Lumen",
            pool=8,
        ),
        Challenge(
            "brachiocephalic",
            "an angled wire from below the arch to the brachiocephalic artery",
            Task(targets=("brachiocephalic artery",), **_ARCH),  # type: ignore[arg-type]
            "the target bca of CathSim",
            pool=8,
        ),
        Challenge(
            "left_carotid",
            "an angled wire from below the arch to the left common carotid artery",
            Task(targets=("left common carotid artery",), **_ARCH),  # type: ignore[arg-type]
            "the target lcca of CathSim",
            pool=8,
        ),
        Challenge(
            "shipped_arch",
            "an angled wire to one of three branches of the shipped arch",
            Task(targets=THREE_BRANCHES, **_ARCH),  # type: ignore[arg-type]
            "own",
        ),
        Challenge(
            "arch_variety",
            "an angled wire to one of five arteries, in a new arch each episode",
            Task(
                targets=(
                    "left common carotid artery",
                    "right common carotid artery",
                    "left subclavian artery",
                    "right subclavian artery",
                    "brachiocephalic artery",
                ),
                tools=("terumo_stiff_angled",),
                approach_m=BELOW_ARCH_M,
                steps=1000,
            ),
            "ArchVariety of stEVE_bench",
            is_always_new=True,
        ),
        Challenge(
            "two_devices",
            "a wire inside a catheter to a carotid artery",
            Task(
                targets=("left common carotid artery", "right common carotid artery"),
                tools=("terumo_stiff_angled", "beacon_5f"),
                approach_m=BELOW_ARCH_M,
                steps=1000,
                force_limit_N=4.0,
            ),
            "DualDeviceNav of stEVE_bench",
            pool=8,
        ),
    )
}


def challenge_of(given: Challenge | str) -> Challenge:
    """Returns the named task, or the given task itself."""
    if isinstance(given, Challenge):
        return given
    if given not in CHALLENGES:
        raise ValueError("there is no task %r: there are %s" % (given, ", ".join(CHALLENGES)))
    return CHALLENGES[given]
