"""The named tasks as environments for training; Gymnasium calls these functions by name (docs/gymnasium.md).

env = gymnasium.make("cournand/Iliac-v1", scenes="anatomies")
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..anatomies import path_of
from ..envs import NavigationEnv, NavigationVectorEnv, Randomise, Task
from ..errors import BadFileError
from .catalogue import SPLITS, Challenge, challenge_of

SCENES_NEW = 8
"""Number of anatomies that the remedy makes for a task whose every episode has a new anatomy."""


def scenes_of(challenge: Challenge, folder: str | os.PathLike[str], split: str = "train") -> tuple[str, ...]:
    """Returns the paths of a task's scenes of one split. For a task with a pool of anatomies, these are the scenes of
    the pool; for a task whose every episode has a new anatomy, they are all scenes of the split in the folder. Raises
    BadFileError with the remedy if a scene does not exist."""
    if split not in SPLITS:
        raise ValueError("the split %r is not one of %s" % (split, ", ".join(SPLITS)))
    if not challenge.is_drawn:
        return ()
    if challenge.pool:
        challenge.need_scenes(folder, challenge.one_episode_of_each(split))
        return tuple(challenge.scene(folder, seed) for seed in challenge.anatomies(split))
    prefix = challenge.kind + "-"
    names = [path.stem.removeprefix(prefix) for path in Path(folder).glob(prefix + "*.scene")]
    own = [int(name) for name in names if name.isdecimal() and str(int(name)) == name]
    seeds = sorted(seed for seed in own if seed % 2 == SPLITS.index(split))
    if not seeds:
        command = "python -m cournand.anatomies --task %s --split %s --episodes %d --out %s"
        raise BadFileError(
            ("%s has no scene %sN.scene with an N of the split '%s'. Remedy: " + command)
            % (os.fspath(folder), prefix, split, challenge.name, split, SCENES_NEW, os.fspath(folder))
        )
    return tuple(str(path_of(folder, seed, kind=challenge.kind)) for seed in seeds)


def _task(
    challenge: str, scenes: str | os.PathLike[str], split: str, randomise: Randomise | None
) -> tuple[Task, Randomise | None]:
    """Returns the task, and the ranges of its random values, with the scenes among which each episode draws one."""
    chosen = challenge_of(challenge)
    if randomise is not None and randomise.scenes:
        raise ValueError("randomise: the scenes of the task %s are those of the folder `scenes`" % chosen.name)
    paths = scenes_of(chosen, scenes, split)
    if not paths:
        return chosen.task, randomise
    return replace(chosen.task, scene=paths[0]), replace(randomise or Randomise(), scenes=paths)


def single(
    challenge: str,
    *,
    scenes: str | os.PathLike[str] = "anatomies",
    split: str = "train",
    randomise: Randomise | None = None,
    **more: Any,
) -> NavigationEnv:
    """Returns an environment of a named task. `scenes` is the folder of the drawn anatomies; `more` are options of
    NavigationEnv."""
    task, ranges = _task(challenge, scenes, split, randomise)
    return NavigationEnv(task, randomise=ranges, **more)


def vector(
    challenge: str,
    num_envs: int = 1,
    *,
    scenes: str | os.PathLike[str] = "anatomies",
    split: str = "train",
    randomise: Randomise | None = None,
    **more: Any,
) -> NavigationVectorEnv:
    """Returns a vector environment of a named task, with the arguments of single()."""
    task, ranges = _task(challenge, scenes, split, randomise)
    return NavigationVectorEnv(num_envs, task, randomise=ranges, **more)
