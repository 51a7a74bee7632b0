"""Plays episodes of a named task over several threads. Each episode has its own environment, so the results do not
depend on the number of threads."""

from __future__ import annotations

import os
import threading
import zlib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..envs import NavigationEnv
from .catalogue import Challenge, EpisodeSeed
from .policies import PolicyMaker


@dataclass(frozen=True)
class Row:
    """What happened in one episode."""

    seed: int
    anatomy: int
    target: int
    is_reached: bool
    is_success: bool
    """True if the target was reached and no sample of the force on the wall was above the limit."""
    is_out_of_range: bool
    """Physics left its range."""
    steps: int
    rewards: float
    path_begin_m: float
    """Length of the path from the tip to the target along the vessels, at the beginning of the episode."""
    path_end_m: float
    tip_travel_m: float
    """Sum of the distances by which the tip moved from step to step."""
    force_peak_N: float
    hash: str
    """Checksum (CRC-32) of all observations, and the hash of the core's last state."""


class Player:
    """Keeps the environments of a named task, so that later episodes can use them again."""

    def __init__(self, challenge: Challenge, folder: str | os.PathLike[str] = "anatomies", threads: int = 1) -> None:
        if threads < 1:
            raise ValueError("threads: %d is less than 1" % threads)
        self.challenge, self.folder, self.threads = challenge, os.fspath(folder), threads
        self._lock = threading.Lock()
        self._free: dict[int, list[NavigationEnv]] = {}

    def environment(self, anatomy: int) -> NavigationEnv:
        """Makes an environment of the task in one of its anatomies."""
        return NavigationEnv(replace(self.challenge.task, scene=self.challenge.scene(self.folder, anatomy)))

    def _take(self, anatomy: int) -> NavigationEnv:
        with self._lock:
            free = self._free.setdefault(anatomy, [])
            if free:
                return free.pop()
        return self.environment(anatomy)

    def _give(self, anatomy: int, env: NavigationEnv) -> None:
        if not self.challenge.is_always_new:
            with self._lock:
                self._free[anatomy].append(env)

    def play(self, episodes: Sequence[EpisodeSeed], makers: PolicyMaker | Sequence[PolicyMaker]) -> list[Row]:
        """Plays episodes, with one policy maker for all of them or one for each, and returns their results in the same
        order."""
        each = list(makers) if isinstance(makers, Sequence) else [makers] * len(episodes)
        self.challenge.need_scenes(self.folder, list(episodes))
        with ThreadPoolExecutor(self.threads) as pool:
            return list(pool.map(self._play_one, episodes, each))

    def _play_one(self, episode: EpisodeSeed, maker: PolicyMaker) -> Row:
        env = self._take(episode.anatomy)
        policy = maker(self.challenge, episode)
        observation, info = env.reset(seed=episode.target)
        begin_m, rewards, steps, travel_m, crc = info["path_m"], 0.0, 0, 0.0, 0
        tip, is_over = _tip(env), False
        while not is_over:
            observation, reward, terminated, truncated, info = env.step(policy(observation, info))
            now = _tip(env)
            travel_m += float(np.linalg.norm(now - tip))
            tip, rewards, steps, is_over = now, rewards + reward, steps + 1, terminated or truncated
            crc = zlib.crc32(observation.tobytes(), crc)
        row = _row(episode, info, steps, rewards, float(begin_m), travel_m, "%08x-%016x" % (crc, env.world.hash()))
        self._give(episode.anatomy, env)
        return row


def _tip(env: NavigationEnv) -> npt.NDArray[np.float64]:
    tip: npt.NDArray[np.float64] = env.world.pose().positions_m[0].astype(np.float64)
    return tip


def _row(
    episode: EpisodeSeed, info: dict[str, Any], steps: int, rewards: float, begin_m: float, travel_m: float, bits: str
) -> Row:
    return Row(
        seed=episode.seed,
        anatomy=episode.anatomy,
        target=episode.target,
        is_reached=bool(info["is_reached"]),
        is_success=bool(info["is_success"]),
        is_out_of_range=bool(info["is_out_of_range"]),
        steps=steps,
        rewards=rewards,
        path_begin_m=begin_m,
        path_end_m=float(info["path_m"]),
        tip_travel_m=travel_m,
        force_peak_N=float(info["force_peak_N"]),
        hash=bits,
    )
