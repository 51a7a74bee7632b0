"""Policies that a score card can be made for, given by a name, a module or a file.

A policy is a function of the observation and of `info` that returns an action. A policy maker is called once per
episode with the task and the episode's seeds, and returns the policy for that episode. A policy may therefore have a
memory, and several episodes may be played at the same time.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import BadFileError
from .catalogue import Challenge, EpisodeSeed
from .expert import Expert
from .network import UNREADABLE, Network

Policy = Callable[[npt.NDArray[np.float32], dict[str, Any]], Any]
PolicyMaker = Callable[[Challenge, EpisodeSeed], Policy]
FORMAT = 1


def _rest(challenge: Challenge, episode: EpisodeSeed) -> Policy:
    nothing = np.zeros(2 * len(challenge.task.tools), dtype=np.float32)
    return lambda observation, info: nothing


def _push(challenge: Challenge, episode: EpisodeSeed) -> Policy:
    """A policy that pushes all tools forward at full speed, without a turn."""
    tools = len(challenge.task.tools)
    action = np.concatenate([np.ones(tools), np.zeros(tools)]).astype(np.float32)
    return lambda observation, info: action


def _random(challenge: Challenge, episode: EpisodeSeed) -> Policy:
    """A policy that chooses uniformly distributed random speeds in each step."""
    random, width = np.random.default_rng([episode.seed, episode.target]), 2 * len(challenge.task.tools)
    return lambda observation, info: random.uniform(-1.0, 1.0, width).astype(np.float32)


def _expert(challenge: Challenge, episode: EpisodeSeed) -> Policy:
    return Expert(len(challenge.task.tools), outer_tools_rest=challenge.outer_tools_rest)


POLICIES: dict[str, PolicyMaker] = {"rest": _rest, "random": _random, "push": _push, "expert": _expert}


class Linear:
    """A policy whose action is a linear function of the state observation, limited to -1 .. 1."""

    def __init__(
        self,
        weights: npt.NDArray[np.float64],
        mean: npt.NDArray[np.float64],
        scale: npt.NDArray[np.float64],
        task: str,
        version: int,
    ) -> None:
        self.weights, self.mean, self.scale, self.task, self.version = weights, mean, scale, task, version

    def __call__(self, observation: npt.NDArray[np.float32], info: dict[str, Any]) -> npt.NDArray[np.float32]:
        seen = np.append((observation - self.mean) / self.scale, 1.0)
        action: npt.NDArray[np.float32] = np.clip(self.weights @ seen, -1.0, 1.0).astype(np.float32)
        return action

    def make(self, challenge: Challenge, episode: EpisodeSeed) -> Policy:
        """Returns this policy as a policy maker: all episodes share the policy, because it has no memory."""
        width = 2 * len(challenge.task.tools)
        if len(self.weights) != width:
            raise ValueError(
                "the policy of the task %s has %d actions, and %s needs %d"
                % (self.task, len(self.weights), challenge.name, width)
            )
        return self

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a file that gets its name when it is complete."""
        temporary = os.fspath(path) + ".part"
        with open(temporary, "wb") as file:
            np.savez(
                file,
                format=FORMAT,
                weights=self.weights,
                mean=self.mean,
                scale=self.scale,
                task=self.task,
                version=self.version,
            )
        os.replace(temporary, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Linear:
        """Reads a file of save()."""
        try:
            with np.load(path, allow_pickle=False) as file:
                if int(file["format"]) != FORMAT:
                    raise ValueError("format %d" % int(file["format"]))
                weights, mean, scale = (file[name].astype(np.float64) for name in ("weights", "mean", "scale"))
                task, version = str(file["task"]), int(file["version"])
        except UNREADABLE as error:
            raise BadFileError(
                "%s is not a policy of `python -m cournand.train` (%s). Remedy: train it again" % (path, error)
            ) from error
        if weights.ndim != 2 or weights.shape[1] != len(mean) + 1 or mean.shape != scale.shape or mean.ndim != 1:
            raise BadFileError("%s: the sizes of its arrays do not fit. Remedy: train it again" % path)
        if not all(np.isfinite(one).all() for one in (weights, mean, scale)) or not (scale > 0.0).all():
            raise BadFileError("%s has numbers that are not finite. Remedy: train it again" % path)
        return cls(weights, mean, scale, task, version)


def policy_of(given: str) -> PolicyMaker:
    """Returns the policy maker with this name in POLICIES, the policy maker MODULE:FUNCTION, or one for a policy file
    of `cournand.train` or of a network."""
    if given in POLICIES:
        return POLICIES[given]
    if given.endswith(".npz"):
        return (Network.load(given) if Network.is_in(given) else Linear.load(given)).make
    module, colon, name = given.partition(":")
    if not colon:
        raise ValueError(
            "there is no policy %r: there are %s, MODULE:FUNCTION and FILE.npz" % (given, ", ".join(POLICIES))
        )
    try:
        maker = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise ValueError("the policy %r: %s. Remedy: set PYTHONPATH to its folder" % (given, error)) from error
    if not callable(maker):
        raise ValueError("the policy %r is not a function of a challenge and an episode" % given)
    return maker  # type: ignore[no-any-return]
