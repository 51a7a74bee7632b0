"""The environments for Gymnasium: a single one, and a vector environment, which advances many worlds over a pool of
threads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box, Dict, Space
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ..xray import XRay
from .fleet import STATE_LIMIT, Episode, Fleet
from .task import AORTA, Randomise, Task, task_of

FPS = 7.5
SEED_MAX = 2**32 - 1


@dataclass(frozen=True)
class EnvSnapshot:
    """Holds the state of an environment, that is, of its world and of its episode."""

    world: bytes
    episode: Episode

    @property
    def is_done(self) -> bool:
        """True if the saved episode had ended."""
        return self.episode.is_done

    def saved(self) -> tuple[bytes, Episode]:
        return self.world, self.episode


def _observation_space(fleet: Fleet) -> Space[Any]:
    picture = (fleet.size, fleet.size)
    spaces: dict[str, Space[Any]] = {}
    for kind in fleet.kinds:
        if kind == "state":
            spaces[kind] = Box(-STATE_LIMIT, STATE_LIMIT, (fleet.state_width,), np.float32)
        else:
            spaces[kind] = Box(0, 255 if kind == "fluoroscopy" else 63, picture, np.uint8)
    return Dict(spaces) if fleet.is_dict else spaces[fleet.kinds[0]]


def _checked_seed(seed: Any) -> int:
    """Returns a seed. Returns a seed. NumPy would cut larger numbers into words of 32 bits, so they would give the same
    episodes as other seeds."""
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)):
        raise TypeError("a seed is an integer, not %r" % (seed,))
    if not 0 <= seed <= SEED_MAX:
        raise ValueError("the seed %d is not within 0 and %d" % (seed, SEED_MAX))
    return int(seed)


def _check_render_mode(mode: str | None) -> None:
    if mode not in (None, "rgb_array"):
        raise ValueError("render_mode: %r is neither None nor 'rgb_array'" % (mode,))


class NavigationEnv(gymnasium.Env[Any, Any]):
    """A single environment of a task (docs/gymnasium.md)."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": FPS}

    def __init__(
        self,
        task: Task | str = AORTA,
        *,
        observation: str | Sequence[str] = "state",
        action: str = "continuous",
        contrast: bool = False,
        c_arm: bool = False,
        size: int = 128,
        randomise: Randomise | None = None,
        render_mode: str | None = None,
    ) -> None:
        _check_render_mode(render_mode)
        self.render_mode = render_mode
        self._fleet = Fleet(
            task_of(task),
            1,
            observation=observation,
            action=action,
            contrast=contrast,
            c_arm=c_arm,
            size=size,
            randomise=randomise,
        )
        self.observation_space = _observation_space(self._fleet)
        self.action_space = self._fleet.actions.space()
        self._has_begun = False
        self._screens: dict[int, XRay] = {}  # by scene; made by render()

    @property
    def task(self) -> Task:
        return self._fleet.task

    @property
    def world(self) -> Any:
        """The world of this environment. If a caller steps the world directly, the current episode advances with it."""
        return self._fleet.worlds[0]

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        if seed is not None:
            following = _checked_seed(seed), 0
        elif not self._has_begun:
            following = int(self.np_random.integers(2**31)), 0
        else:
            following = self._fleet.episodes[0].following()
        self._fleet.begin([0], [following])
        super().reset(seed=seed)
        self._has_begun = True
        return self._observed(), self._fleet.info(0)

    def _observed(self) -> Any:
        self._fleet.observe([0])
        return self._fleet.observation(0)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self._check_begun()
        rewards, terminated, truncated = self._fleet.step(self._fleet.actions.parts(self.action_space, action, 1), [0])
        return self._observed(), float(rewards[0]), bool(terminated[0]), bool(truncated[0]), self._fleet.info(0)

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Returns the fluoroscopy picture of 512 x 512 pixels as a colour picture."""
        if self.render_mode is None:
            return None
        episode = self._fleet.episodes[0]
        if episode.stage not in self._screens:
            self._screens[episode.stage] = XRay(self._fleet.stages[episode.stage].scene, 512)
        grey = self._screens[episode.stage].render(self.world, episode.view).grey
        assert grey is not None
        return np.repeat(grey[:, :, None], 3, axis=2)

    def snapshot(self) -> EnvSnapshot:
        """Returns the state of the environment; restore() of any environment with the same task and options continues
        from it bit for bit."""
        self._check_begun()
        return EnvSnapshot(*self._fleet.save(0))

    def restore(self, snapshot: EnvSnapshot) -> Any:
        """Restores a snapshot, and returns the observation of the restored state."""
        self._fleet.load(0, snapshot.saved())
        self._has_begun = True
        return self._observed()

    def _check_begun(self) -> None:
        if not self._has_begun:
            raise RuntimeError("the environment has not begun: call reset() first")


class NavigationVectorEnv(VectorEnv[Any, Any, Any]):
    """Environments of a task that advance over a pool of threads in C.

    Environment i of a vector environment with the seed s behaves like a NavigationEnv with the seed s + i, bit for bit,
    with any number of threads.
    """

    metadata = {"render_modes": [], "render_fps": FPS}

    def __init__(
        self,
        num_envs: int = 1,
        task: Task | str = AORTA,
        *,
        threads: int = 1,
        observation: str | Sequence[str] = "state",
        action: str = "continuous",
        contrast: bool = False,
        c_arm: bool = False,
        size: int = 128,
        randomise: Randomise | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    ) -> None:
        if num_envs < 1:
            raise ValueError("num_envs is less than 1")
        self.num_envs = num_envs
        self._mode = AutoresetMode(autoreset_mode)
        self.metadata = {**type(self).metadata, "autoreset_mode": self._mode}
        self._fleet = Fleet(
            task_of(task),
            num_envs,
            threads=threads,
            observation=observation,
            action=action,
            contrast=contrast,
            c_arm=c_arm,
            size=size,
            randomise=randomise,
        )
        self.single_observation_space = _observation_space(self._fleet)
        self.single_action_space = self._fleet.actions.space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._has_begun = False

    @property
    def task(self) -> Task:
        return self._fleet.task

    # --- reset ---

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins episodes: in all environments, or in those of options["reset_mask"], bool [num_envs]."""
        mask = np.ones(self.num_envs, dtype=bool)
        if options and options.get("reset_mask") is not None:
            mask = np.asarray(options["reset_mask"], dtype=bool)
            if mask.shape != (self.num_envs,) or not mask.any():
                raise ValueError("reset_mask is not an array of num_envs truth values, one of them True")
            if not self._has_begun and not mask.all():
                raise ValueError("the first reset is that of all environments")
        which = [int(number) for number in np.flatnonzero(mask)]
        self._begin(which, self._seeded(self._given_seeds(seed)))
        return self._observed(), self._infos(which)

    def _given_seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        """Returns the seed that was given for each environment, or None for an environment without a given seed."""
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, (int, np.integer)):
            return [_checked_seed(int(seed) + i) for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError("seed has %d numbers for %d environments" % (len(seed), self.num_envs))
        return [None if one is None else _checked_seed(one) for one in seed]

    def _seeded(self, given: Sequence[int | None]) -> list[tuple[int, int]]:
        """Returns the seed and the episode number of the next episode of every environment."""
        if not self._has_begun:
            VectorEnv.reset(self, seed=given[0])
            drawn = [int(self.np_random.integers(2**31)) for _ in range(self.num_envs)]
            return [(own if one is None else one, 0) for one, own in zip(given, drawn)]
        return [now.following() if one is None else (one, 0) for one, now in zip(given, self._fleet.episodes)]

    def _begin(self, which: Sequence[int], begun: Sequence[tuple[int, int]]) -> None:
        """Begins an episode in every environment, with the seeds and episode numbers in `begun`."""
        self._fleet.begin(which, [begun[number] for number in which])
        self._has_begun = True
        self._fleet.observe(which)

    def _begin_next(self, which: Sequence[int]) -> None:
        self._begin(which, self._seeded([None] * self.num_envs))

    # --- step ---

    def step(self, actions: Any) -> tuple[Any, npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], dict[str, Any]]:
        self._check_begun()
        parts = self._fleet.actions.parts(self.action_space, actions, self.num_envs)
        done = self._ended()
        if done and self._mode == AutoresetMode.DISABLED:
            raise RuntimeError("environments %s have ended: reset them by options['reset_mask']" % done)
        moving = [number for number in range(self.num_envs) if number not in done]
        if moving:
            rewards, terminated, truncated = self._fleet.step(parts[moving], moving)
            self._fleet.observe(moving)
        else:
            rewards = np.zeros(self.num_envs)
            terminated, truncated = np.zeros(self.num_envs, dtype=bool), np.zeros(self.num_envs, dtype=bool)
        if done:  # NEXT_STEP: this step begins their next episode, and their action has no effect
            self._begin_next(done)
        ended = self._ended()
        if self._mode != AutoresetMode.SAME_STEP or not ended:
            return self._observed(), rewards, terminated, truncated, self._infos(range(self.num_envs))
        finals = [(self._fleet.observation(number), self._fleet.info(number)) for number in ended]
        self._begin_next(ended)
        infos = self._infos(range(self.num_envs))
        for number, (observation, info) in zip(ended, finals):
            infos = self._add_info(infos, {"final_obs": observation, "final_info": info}, number)
        return self._observed(), rewards, terminated, truncated, infos

    def _observed(self) -> Any:
        """Returns a copy of all observations."""
        each = [self._fleet.observation(number) for number in range(self.num_envs)]
        if not self._fleet.is_dict:
            return np.stack(each)
        return {kind: np.stack([one[kind] for one in each]) for kind in self._fleet.kinds}

    def _infos(self, which: Sequence[int]) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for number in which:
            infos = self._add_info(infos, self._fleet.info(number), number)
        return infos

    # --- snapshots ---

    def snapshot(self, number: int) -> EnvSnapshot:
        """Returns the state of one environment."""
        self._check_begun()
        return EnvSnapshot(*self._fleet.save(number))

    def restore(self, number: int, snapshot: EnvSnapshot) -> None:
        """Restores a snapshot of any environment with the same task and options in one environment. If the saved
        episode had ended, the next step begins another episode; with autoreset disabled, reset() must begin it."""
        self._check_begun()
        self._fleet.load(number, snapshot.saved())
        self._fleet.observe([number])

    def _ended(self) -> list[int]:
        return [number for number, episode in enumerate(self._fleet.episodes) if episode.is_done]

    def _check_begun(self) -> None:
        if not self._has_begun:
            raise RuntimeError("the environments have not begun: call reset() first")
