"""A policy that is a small neural network, in a file that NumPy alone reads and judges.

The network sees the features of several moments of an episode, because the tip of a long wire follows a turn of the
hand only later. A program with a library for deep learning trains the network (docs/tasks.md, "The deep baseline").
"""

from __future__ import annotations

import os
import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import BadFileError
from .catalogue import Challenge, EpisodeSeed

if TYPE_CHECKING:
    from .policies import Policy

FORMAT = "cournand network 1"
SEEN_MAX = 10.0
"""Limit of the normalised features."""
TIP_FEATURES = 7
UNREADABLE = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    EOFError,
    OverflowError,
    zipfile.BadZipFile,
    zlib.error,
)
"""What NumPy raises for a file that is no policy, or a damaged one."""
_Floats = npt.NDArray[np.float32]


def features(observation: npt.NDArray[Any]) -> _Floats:
    """Returns the observation "state" with TIP_FEATURES further values, float32 [..., width + 7].

    Three points of a tip, 2 mm apart, look nearly alike to a network. The further values state what lies in their small
    differences: the direction to which the tip bends (3, a unit vector), the direction of the target along the tip, to
    the side of its bend, and across both (3, a unit vector), and the distance of the target in 0.1 m (1)."""
    seen = np.asarray(observation, dtype=np.float64)
    points = seen[..., :9].reshape((*seen.shape[:-1], 3, 3))
    along = _unit(points[..., 0, :] - points[..., 1, :])
    bend = points[..., 0, :] - 2.0 * points[..., 1, :] + points[..., 2, :]
    bend = _unit(bend - along * np.sum(bend * along, axis=-1, keepdims=True))
    target = -points[..., 0, :]
    distance = np.linalg.norm(target, axis=-1, keepdims=True)
    target = _unit(target)
    inside = [np.sum(target * axis, axis=-1, keepdims=True) for axis in (along, bend, np.cross(along, bend))]
    made: _Floats = np.concatenate([seen, bend, *inside, distance], axis=-1).astype(np.float32)
    return made


def _unit(vectors: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    made: npt.NDArray[np.float64] = vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
    return made


class Memory:
    """Holds the features of the last moments of several episodes; `lags` are the ages of those that the network sees,
    in steps. Before an episode's first moment, there is the first moment."""

    def __init__(self, lags: Sequence[int], count: int, width: int) -> None:
        self.lags = list(lags)
        self.past = np.zeros((count, max(self.lags) + 1, width), dtype=np.float32)

    def begin(self, number: int, now: _Floats) -> None:
        self.past[number] = now

    def add(self, now: _Floats) -> None:
        """Adds a moment of all episodes, [count, width]."""
        self.past = np.concatenate([now[:, None], self.past[:, :-1]], axis=1)

    def seen(self) -> _Floats:
        """Returns what the network sees, [count, lags * width]."""
        made: _Floats = self.past[:, self.lags].reshape(len(self.past), -1)
        return made


@dataclass(frozen=True)
class Network:
    """A network with tanh layers, whose last layer is linear and limited to -1 .. 1."""

    layers: Sequence[tuple[_Floats, _Floats]]
    """Weights [outputs, inputs] and biases [outputs] of each layer."""
    mean: _Floats
    scale: _Floats
    lags: Sequence[int]
    task: str
    version: int

    def action(self, seen: _Floats) -> _Floats:
        """Returns the action for what Memory.seen() returns for one episode."""
        values = np.clip((seen - self.mean) / self.scale, -SEEN_MAX, SEEN_MAX).astype(np.float32)
        for number, (weights, biases) in enumerate(self.layers):
            values = weights @ values + biases
            if number + 1 < len(self.layers):
                values = np.tanh(values)
        action: _Floats = np.clip(values, -1.0, 1.0)
        return action

    def make(self, challenge: Challenge, episode: EpisodeSeed) -> Policy:
        """Returns the policy for one episode, which has a memory of its own."""
        tools = len(challenge.task.tools)
        if len(self.layers[-1][1]) != 2 * tools:
            raise ValueError(
                "the policy of the task %s has %d actions, and %s needs %d"
                % (self.task, len(self.layers[-1][1]), challenge.name, 2 * tools)
            )
        inputs = len(self.lags) * (15 + 5 * tools + TIP_FEATURES)
        if len(self.mean) != inputs:
            raise ValueError(
                "the policy of the task %s has %d inputs, and %s needs %d"
                % (self.task, len(self.mean), challenge.name, inputs)
            )
        memory = Memory(self.lags, 1, len(self.mean) // len(self.lags))
        has_begun = False

        def policy(observation: _Floats, info: dict[str, Any]) -> _Floats:
            nonlocal has_begun
            now = features(observation)
            if not has_begun:
                memory.begin(0, now)
            else:
                memory.add(now[None])
            has_begun = True
            return self.action(memory.seen()[0])

        return policy

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a file that gets its name when it is complete."""
        arrays: dict[str, Any] = {"format": FORMAT, "mean": self.mean, "scale": self.scale, "lags": list(self.lags)}
        for number, (weights, biases) in enumerate(self.layers):
            arrays["weights%d" % number], arrays["biases%d" % number] = weights, biases
        temporary = os.fspath(path) + ".part"
        with open(temporary, "wb") as file:
            np.savez(file, task=self.task, version=self.version, layers=len(self.layers), **arrays)
        os.replace(temporary, path)

    @staticmethod
    def is_in(path: str | os.PathLike[str]) -> bool:
        """Returns True if a file holds a network, and not a linear policy."""
        try:
            with np.load(path, allow_pickle=False) as file:
                return "layers" in file.files
        except UNREADABLE:
            return False

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Network:
        """Reads a file of save()."""
        try:
            with np.load(path, allow_pickle=False) as file:
                if str(file["format"]) != FORMAT:
                    raise ValueError("its format is %r" % str(file["format"]))
                count = int(file["layers"])
                layers = [
                    (file["weights%d" % one].astype(np.float32), file["biases%d" % one].astype(np.float32))
                    for one in range(count)
                ]
                mean, scale = file["mean"].astype(np.float32), file["scale"].astype(np.float32)
                lags = [int(one) for one in file["lags"]]
                task, version = str(file["task"]), int(file["version"])
        except UNREADABLE as error:
            raise BadFileError("%s holds no network (%s). Remedy: train it again" % (path, error)) from error
        made = cls(layers, mean, scale, lags, task, version)
        fault = made._fault()
        if fault:
            raise BadFileError("%s: %s. Remedy: train it again" % (path, fault))
        return made

    def _fault(self) -> str:
        """Returns what is wrong with the arrays, or ""."""
        if not self.layers or not self.lags or min(self.lags) < 0 or max(self.lags) > 1000:
            return "it has no layers, or its lags are not within 0 and 1000"
        width = len(self.mean) if self.mean.ndim == 1 else -1
        if self.scale.shape != self.mean.shape or width <= 0 or width % len(self.lags):
            return "the sizes of its arrays do not fit"
        for weights, biases in self.layers:
            if weights.ndim != 2 or weights.shape[1] != width or biases.shape != weights.shape[:1]:
                return "the sizes of its arrays do not fit"
            width = len(biases)
        arrays = [self.mean, self.scale, *(one for layer in self.layers for one in layer)]
        if not all(np.isfinite(one).all() for one in arrays) or not (self.scale > 0.0).all():
            return "it has numbers that are not finite, or a scale that is not above 0"
        return ""
