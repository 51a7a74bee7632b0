"""The adapter: worlds that step in one call of the C library, as a vector environment of Stable-Baselines3."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
from cournand.envs import NavigationVectorEnv, Randomise, Task
from cournand.tasks.expert import OBSERVED_M
from cournand.tasks.network import TIP_FEATURES, Memory, features
from stable_baselines3.common.vec_env import VecEnv

LAGS = (0, 1, 3, 7)
"""Ages, in steps, of the moments that the policy sees: now and up to 0.9 s ago."""


class Worlds(VecEnv):
    """`count` environments of a task, each of whose episodes is in one of `scenes`. An observation is what
    Memory.seen() returns: the features of the moments `lags`.

    The reward is that of the task and, for every metre by which the tip comes nearer to the target in a straight line,
    `reward_per_nearer_m`. The path along the vessels does not show whether the tip passes its target at the wall."""

    def __init__(
        self,
        task: Task,
        scenes: Sequence[str],
        count: int,
        *,
        threads: int = 1,
        lags: Sequence[int] = LAGS,
        reward_per_nearer_m: float = 0.0,
    ) -> None:
        chosen = Randomise(scenes=tuple(scenes)) if len(scenes) > 1 else None
        task = replace(task, scene=scenes[0])
        self.envs = NavigationVectorEnv(count, task, threads=threads, randomise=chosen, autoreset_mode="SameStep")
        width = self.envs.single_observation_space.shape[0] + TIP_FEATURES
        self.memory = Memory(lags, count, width)
        self.render_mode = None
        super().__init__(
            count,
            gymnasium.spaces.Box(-np.inf, np.inf, (len(lags) * width,), np.float32),
            self.envs.single_action_space,
        )
        self._actions = np.zeros(self.envs.action_space.shape, dtype=np.float32)
        self._nearer, self._distances_m = reward_per_nearer_m, np.zeros(count)
        self._rewards, self._steps, self._begin = np.zeros(count), np.zeros(count, dtype=int), time.monotonic()

    def reset(self) -> np.ndarray:
        given = self._seeds if self._seeds[0] is not None else None
        observations, _ = self.envs.reset(seed=given)
        self._reset_seeds()
        self._reset_options()
        for number, now in enumerate(features(observations)):
            self.memory.begin(number, now)
        self._rewards[:], self._steps[:] = 0.0, 0
        self._distances_m = _distances_m(self.memory)
        return self.memory.seen()

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        observations, rewards, terminated, truncated, given = self.envs.step(self._actions)
        done = terminated | truncated
        now = features(observations)
        ended = {int(number): features(given["final_obs"][number]) for number in np.flatnonzero(done)}
        self.memory.add(np.stack([ended.get(number, row) for number, row in enumerate(now)]))
        last, infos = self.memory.seen(), [{} for _ in range(self.num_envs)]
        distances_m = _distances_m(self.memory)
        rewards = rewards + self._nearer * (self._distances_m - distances_m)
        self._rewards += rewards
        self._steps += 1
        for number in ended:
            infos[number] = self._info(number, given, bool(truncated[number]))
            infos[number]["terminal_observation"] = last[number].copy()
            self.memory.begin(number, now[number])
            self._rewards[number], self._steps[number] = 0.0, 0
        self._distances_m = _distances_m(self.memory)
        return self.memory.seen(), rewards.astype(np.float32), done, infos

    def _info(self, number: int, given: dict[str, Any], is_truncated: bool) -> dict[str, Any]:
        """Returns what Stable-Baselines3 wants to know of an episode that has ended."""
        return {
            "TimeLimit.truncated": is_truncated,
            "is_success": bool(given["final_info"]["is_success"][number]),
            "episode": {
                "r": float(self._rewards[number]),
                "l": int(self._steps[number]),
                "t": time.monotonic() - self._begin,
            },
        }

    # --- what else Stable-Baselines3 demands ---

    def close(self) -> None:
        self.envs.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self.envs, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError("the worlds of one call share their attributes: make other Worlds")

    def env_method(self, method_name: str, *arguments: Any, indices: Any = None, **named: Any) -> list[Any]:
        raise NotImplementedError("the worlds of one call have no methods of their own: call Worlds.envs")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]


def _distances_m(memory: Memory) -> np.ndarray:
    """Returns the distance of each tip from its target, in m: the last feature of the present moment."""
    return memory.past[:, 0, -1].astype(np.float64) * OBSERVED_M
