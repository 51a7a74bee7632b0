"""Trains a baseline policy for a named task by augmented random search; it needs only NumPy (docs/tasks.md).

    python -m cournand.train iliac --minutes 10 --out policy.npz

The method is that of Mania, Guy and Recht (Simple random search of static policies, NeurIPS 2018). In each iteration, a
linear policy is changed by steps in random directions, forwards and backwards, and then moves along the directions with
the best rewards. The method needs no graphics processor and no gradients.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .tasks.catalogue import CHALLENGES, Challenge, EpisodeSeed, challenge_of
from .tasks.play import Player
from .tasks.policies import Linear, Policy


@dataclass(frozen=True)
class Settings:
    """Settings of the search."""

    directions: int = 8
    kept: int = 4
    """Number of the best directions that are used; a direction is judged by the better of its two episodes."""
    noise: float = 0.1
    step: float = 0.1
    seed: int = 0
    episodes: int = 64
    """Number of training episodes, which are used in turn."""


class _Watched:
    """A policy that also adds up the values that it observes."""

    def __init__(self, policy: Linear) -> None:
        self.policy = policy
        width = len(policy.mean)
        self.count, self.sum, self.squares = 0, np.zeros(width), np.zeros(width)

    def make(self, challenge: Challenge, episode: EpisodeSeed) -> Policy:
        self.policy.make(challenge, episode)
        return self

    def __call__(self, observation: npt.NDArray[np.float32], info: dict[str, Any]) -> npt.NDArray[np.float32]:
        seen = observation.astype(np.float64)
        self.count, self.sum, self.squares = self.count + 1, self.sum + seen, self.squares + seen * seen
        return self.policy(observation, info)


class Search:
    """A search whose result depends only on the task, the settings and the number of iterations."""

    def __init__(
        self,
        challenge: Challenge,
        settings: Settings,
        anatomies: str | os.PathLike[str] = "anatomies",
        threads: int = 1,
    ) -> None:
        self.challenge, self.settings = challenge, settings
        self.player = Player(challenge, anatomies, threads)
        self.training = challenge.episodes("train", settings.episodes)
        challenge.need_scenes(anatomies, self.training)
        tools = len(challenge.task.tools)
        self.width = 15 + 5 * tools  # of the state observation
        self.weights = np.zeros((2 * tools, self.width + 1))
        self.random = np.random.default_rng(settings.seed)
        self.count, self.sum, self.squares = 0, np.zeros(self.width), np.zeros(self.width)
        self.curve: list[dict[str, float]] = []
        self.steps = 0

    def policy(self, weights: npt.NDArray[np.float64] | None = None) -> Linear:
        """Returns the present policy, or the policy with other weights."""
        mean = self.sum / max(self.count, 1)
        variance = self.squares / max(self.count, 1) - mean * mean
        scale = np.sqrt(np.maximum(variance, 1e-4)) if self.count else np.ones(self.width)
        chosen = self.weights if weights is None else weights
        return Linear(chosen.copy(), mean, scale, self.challenge.name, self.challenge.version)

    def iterate(self) -> dict[str, float]:
        """Plays two episodes per direction, changes the policy, and returns a point of the learning curve."""
        settings = self.settings
        directions = self.random.standard_normal((settings.directions, *self.weights.shape))
        chosen = self.random.integers(len(self.training), size=settings.directions)
        signs = [(number, sign) for number in range(settings.directions) for sign in (1.0, -1.0)]
        watched = [_Watched(self.policy(self.weights + sign * settings.noise * directions[n])) for n, sign in signs]
        rows = self.player.play([self.training[chosen[n]] for n, _ in signs], [one.make for one in watched])
        rewards = np.array([row.rewards for row in rows]).reshape(-1, 2)
        kept = np.argsort(-rewards.max(axis=1), kind="stable")[: settings.kept]
        spread = max(float(rewards[kept].std()), 1e-6)
        change = sum((rewards[n, 0] - rewards[n, 1]) * directions[n] for n in kept)
        self.weights = self.weights + settings.step / (settings.kept * spread) * change
        for one in watched:
            self.count, self.sum, self.squares = (
                self.count + one.count,
                self.sum + one.sum,
                self.squares + one.squares,
            )
        self.steps += sum(row.steps for row in rows)
        point = {
            "iteration": len(self.curve) + 1,
            "steps": self.steps,
            "rewards_mean": float(rewards.mean()),
            "safe_success": sum(row.is_success for row in rows) / len(rows),
        }
        self.curve.append(point)
        return point


def _write_json(path: str, content: dict[str, Any]) -> None:
    Path(path + ".part").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    os.replace(path + ".part", path)


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m cournand.train",
        description="Trains a linear policy by random search in the training anatomies of a task.",
        epilog="Exit codes: 0 done, 1 it could not be trained, 2 usage.",
    )
    parser.add_argument("task", choices=list(CHALLENGES), metavar="TASK", help=", ".join(CHALLENGES))
    parser.add_argument("--minutes", type=float, default=10.0, metavar="M", help="of the clock (default 10)")
    parser.add_argument("--iterations", type=int, metavar="N", help="in place of --minutes; the result is reproducible")
    parser.add_argument("--seed", type=int, default=0, help="of the search (default 0)")
    parser.add_argument(
        "--threads", type=int, default=os.cpu_count() or 1, metavar="N", help="(default all processors)"
    )
    parser.add_argument("--anatomies", default="anatomies", metavar="DIR", help="drawn scenes (default anatomies)")
    parser.add_argument("--out", default="policy.npz", metavar="FILE.npz", help="policy; FILE.json is the curve")
    given = parser.parse_args(words)
    if not 0.0 < given.minutes < 1e6 or given.threads < 1 or given.seed < 0:
        parser.error("--minutes and --threads are above 0, --seed is 0 or above")
    if given.iterations is not None and given.iterations < 1:
        parser.error("--iterations is at least 1")
    if not given.out.endswith(".npz"):
        parser.error("--out: '%s' does not end in .npz" % given.out)
    return given


def main(words: Sequence[str] | None = None) -> int:
    given = _arguments(words)
    settings = Settings(seed=given.seed)
    begin, processor = time.monotonic(), time.process_time()
    try:
        search = Search(challenge_of(given.task), settings, given.anatomies, given.threads)
        while True:
            point = search.iterate()
            search.policy().save(given.out)
            minutes = (time.monotonic() - begin) / 60.0
            _write_json(
                given.out[: -len(".npz")] + ".json",
                {
                    "task": search.challenge.name,
                    "version": search.challenge.version,
                    "settings": vars(settings),
                    "minutes": minutes,
                    "processor_minutes": (time.process_time() - processor) / 60.0,
                    "curve": search.curve,
                },
            )
            print(
                "%3d  %7d steps  %5.1f min  rewards %6.3f  safe %3.0f %%"
                % (point["iteration"], point["steps"], minutes, point["rewards_mean"], 100 * point["safe_success"]),
                flush=True,
            )
            if len(search.curve) >= given.iterations if given.iterations else minutes >= given.minutes:
                return 0
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        print("train: %s" % error, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
