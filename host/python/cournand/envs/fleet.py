"""Many episodes of one task: what the single and the vector environment share.

Episode e of an environment with seed s draws from numpy.random.default_rng([s, e]) alone. What happens in it depends
on neither other environments, nor earlier episodes, nor the number of threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..batch import FIGURES, Batch, Pool
from ..scene import Scene, Tool
from ..world import TICKS_PER_S, World
from ..xray import View, XRay
from .task import TOOL_FACTORS, Randomise, Task, VesselPaths

POINTS, SPACING_M = 3, 0.002
KINDS = ("state", "fluoroscopy", "labels")
STATE_LIMIT = 10.0
# Push and turn of the actions of a discrete set, in parts of the largest speeds.
DISCRETE = np.array([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1)], dtype=np.float32)
APPROACH_M_PER_S = 0.06
OWN_RENDERERS = 16


@dataclass
class Episode:
    """What one episode has besides its world."""

    seed: int = 0
    number: int = 0
    step: int = 0
    target_m: npt.NDArray[np.float64] = None  # type: ignore[assignment]
    exits: npt.NDArray[np.float64] = None  # type: ignore[assignment]
    beyond: npt.NDArray[np.float64] = None  # type: ignore[assignment]
    path_m: float = 0.0
    force_peak_N: float = 0.0
    action: npt.NDArray[np.float32] = None  # type: ignore[assignment]
    view: View = View()
    drawn: dict[str, float] = None  # type: ignore[assignment]
    is_done: bool = False

    def following(self) -> tuple[int, int]:
        """Returns the seed and the number of the next episode."""
        return self.seed, self.number + 1

    def copy(self) -> Episode:
        return replace(self, action=self.action.copy())


class Fleet:
    """The worlds and episodes of `count` environments."""

    def __init__(
        self,
        task: Task,
        count: int,
        *,
        threads: int = 1,
        observation: str | Sequence[str] = "state",
        size: int = 128,
        randomise: Randomise | None = None,
    ) -> None:
        self.task, self.count, self.size = task, count, size
        self.kinds = (observation,) if isinstance(observation, str) else tuple(observation)
        if not self.kinds or any(kind not in KINDS for kind in self.kinds):
            raise ValueError("observation: %r is not one of %s, nor several of them" % (observation, ", ".join(KINDS)))
        self.is_dict = not isinstance(observation, str)
        if not 64 <= size <= 512 or size % 16:
            raise ValueError("size: %r is not a multiple of 16 within 64 and 512" % (size,))
        self.randomise = randomise or Randomise()
        self.scene = Scene(task.scene)
        self.paths = VesselPaths(self.scene)
        self.targets = [self.scene.find_vessel(name) for name in task.targets]
        self.tools = [Tool(name) for name in task.tools]
        self.positions = len(self.tools)
        self.pool = Pool(threads)
        self.start = self._approached([self.tools])[0].snapshot()
        worlds = [self._world(self.tools) for _ in range(count)]
        self.batch = Batch(self.pool, worlds, points=POINTS, spacing_m=SPACING_M)
        self.worlds = worlds
        self.episodes = [Episode() for _ in range(count)]
        self.renderers = self._renderers(threads) if self.has_pictures else []
        self._grey: npt.NDArray[np.uint8] | None = None
        self._labels: npt.NDArray[np.uint8] | None = None

    @property
    def has_pictures(self) -> bool:
        return "fluoroscopy" in self.kinds or "labels" in self.kinds

    @property
    def state_width(self) -> int:
        return 3 * POINTS + 3 + 3 * self.positions + 3 + 2 * self.positions

    def _renderers(self, threads: int) -> list[XRay]:
        """Makes one renderer per environment, which keeps its view; many environments share one per thread."""
        return [XRay(self.scene, self.size) for _ in range(self.count if self.count <= OWN_RENDERERS else threads)]

    # --- episodes ---

    def _world(self, tools: Sequence[Tool]) -> World:
        return World(self.scene, tools, contact_ticks=self.task.contact_ticks)

    def _approached(self, tools: Sequence[Sequence[Tool]]) -> list[World]:
        """Makes a world for each of these sets of tools, and pushes all in to where the task begins."""
        worlds = [self._world(one) for one in tools]
        ticks = round(self.task.approach_m / APPROACH_M_PER_S * TICKS_PER_S)
        if ticks > 0:
            actions = np.zeros((len(worlds), 8), dtype=np.float32)
            actions[:, : self.positions] = APPROACH_M_PER_S
            Batch(self.pool, worlds, points=0).move(actions, ticks)
        return worlds

    def begin(self, which: Sequence[int], seeds: Sequence[tuple[int, int]]) -> None:
        """Begins an episode in each of some environments, from its seed and its number. What can be refused comes
        first, so that a refusal leaves all episodes as they are."""
        begun = [self._drawn_episode(seed, number) for seed, number in seeds]
        if self.randomise.changes_tools:
            worlds = self._approached([self._drawn_tools(episode.drawn) for episode in begun])
            for number, world in zip(which, worlds):
                self._replace(number, world)
            self.batch.read(which)
        else:
            self.batch.restore([self.start] * len(begun), which)
        for number, episode in zip(which, begun):
            self.episodes[number] = episode
            episode.path_m = self._path(number)

    def _drawn_episode(self, seed: int, number: int) -> Episode:
        random = np.random.default_rng([seed, number])
        vessel = self.targets[int(random.integers(len(self.targets)))]
        target, along = self.paths.point(vessel, float(random.uniform(*self.task.target_part)))
        exits, beyond = self.paths.towards(vessel, along)
        drawn = self.randomise.draw(random)
        no_action = np.zeros(2 * self.positions, dtype=np.float32)
        view = self._view(target, drawn)
        return Episode(seed, number, 0, target, exits, beyond, np.inf, 0.0, no_action, view, drawn)

    def _drawn_tools(self, drawn: dict[str, float]) -> list[Tool]:
        factors = {name: drawn[name] for name in TOOL_FACTORS}
        return [tool.scaled(**factors) for tool in self.tools]

    def _replace(self, number: int, world: World) -> None:
        self.worlds[number] = world
        self.batch.put(number, world)

    def _view(self, target: npt.NDArray[np.float64], drawn: dict[str, float]) -> View:
        base = self.task.view
        return replace(
            base,
            primary_deg=base.primary_deg + drawn["primary_deg"],
            secondary_deg=base.secondary_deg + drawn["secondary_deg"],
            dose_nGy=base.dose_nGy * drawn["dose"],
            isocentre_m=(float(target[0]), float(target[1]), float(target[2])),
        )

    # --- steps ---

    def step(self, actions: npt.NDArray[Any], which: Sequence[int]) -> tuple[npt.NDArray[Any], ...]:
        """Moves some environments, and returns rewards, terminated and truncated of all."""
        task, rows = self.task, np.zeros((len(which), 8), dtype=np.float32)
        parts = np.clip(np.asarray(actions, dtype=np.float32), -1.0, 1.0)
        rows[:, : self.positions] = parts[:, : self.positions] * task.push_max_m_per_s
        rows[:, 3 : 3 + self.positions] = parts[:, self.positions :] * task.turn_max_rad_per_s
        self.batch.move(rows, task.ticks, which)
        rewards = np.zeros(self.count)
        terminated, truncated = np.zeros(self.count, dtype=bool), np.zeros(self.count, dtype=bool)
        for row, number in enumerate(which):
            episode = self.episodes[number]
            episode.step += 1
            episode.action = parts[row].copy()
            path = self._path(number)
            gained, episode.path_m = episode.path_m - path, path
            episode.force_peak_N = max(episode.force_peak_N, self.figure(number, "wall_force_peak_N"))
            is_out = bool(self.figure(number, "is_out_of_range"))
            is_reached = self.tip_distance(number) <= task.reach_m and not is_out
            rewards[number] = task.reward_per_step + task.reward_per_m * gained
            if is_reached and self.is_safe(number):
                rewards[number] += task.reward_reached
            terminated[number] = is_reached or is_out
            truncated[number] = episode.step >= task.steps and not terminated[number]
            episode.is_done = bool(terminated[number] or truncated[number])
        return rewards, terminated, truncated

    def figure(self, number: int, name: str) -> float:
        return float(self.batch.states[number, self.batch.columns.figures][FIGURES.index(name)])

    def tip_distance(self, number: int) -> float:
        return float(np.linalg.norm(self.batch.states[number, :3] - self.episodes[number].target_m))

    def is_safe(self, number: int) -> bool:
        return self.episodes[number].force_peak_N <= self.task.force_limit_N

    def _path(self, number: int) -> float:
        """Returns the distance to the target along the vessels; where the tip's vessel is not known, the last one."""
        episode, vessel = self.episodes[number], int(self.batch.vessels[number])
        if vessel < 0:
            return episode.path_m if np.isfinite(episode.path_m) else self.tip_distance(number)
        return float(abs(self.batch.places[number, 0] - episode.exits[vessel]) + episode.beyond[vessel])

    def info(self, number: int) -> dict[str, Any]:
        episode = self.episodes[number]
        is_out = bool(self.figure(number, "is_out_of_range"))
        is_reached = self.tip_distance(number) <= self.task.reach_m and not is_out
        return {
            "is_success": is_reached and self.is_safe(number),
            "is_reached": is_reached,
            "is_out_of_range": is_out,
            "force_peak_N": episode.force_peak_N,
            "path_m": episode.path_m,
            "target_m": episode.target_m.copy(),
            "seed": episode.seed,
            "episode": episode.number,
        }

    # --- observations ---

    def observe(self, which: Sequence[int]) -> None:
        """Renders the pictures of some environments. States need no work."""
        if not self.has_pictures or not which:
            return
        self._grey, self._labels = self.batch.render(
            self.renderers,
            [self.episodes[number].view for number in which],
            [self._noise_seed(number) for number in which],
            labels="labels" in self.kinds,
            picture="fluoroscopy" in self.kinds,
            which=which,
        )

    def _noise_seed(self, number: int) -> int:
        episode = self.episodes[number]
        words = np.random.SeedSequence([episode.seed, episode.number, episode.step]).generate_state(1, np.uint64)
        return int(words[0])

    def observation(self, number: int) -> Any:
        """Returns the observation of one environment, in memory of its own."""
        parts: dict[str, Any] = {}
        for kind in self.kinds:
            if kind == "state":
                parts[kind] = self._state(number)
            else:
                pixels = self._grey if kind == "fluoroscopy" else self._labels
                assert pixels is not None
                parts[kind] = pixels[number].copy()
        return parts if self.is_dict else parts[self.kinds[0]]

    def _state(self, number: int) -> npt.NDArray[np.float32]:
        task, episode = self.task, self.episodes[number]
        row, columns = self.batch.states[number], self.batch.columns
        points = row[columns.points].reshape(POINTS, 3)
        heading = points[0] - points[1]
        hands = row[columns.hands].reshape(3, 3)[: self.positions]
        made = np.concatenate(
            [
                ((points - episode.target_m) / 0.1).ravel(),
                heading / max(float(np.linalg.norm(heading)), 1e-9),
                (hands / (1.0, 1.0, 0.01)).ravel(),
                [
                    self.figure(number, "wall_force_N") / task.force_limit_N,
                    episode.force_peak_N / task.force_limit_N,
                    episode.path_m,
                ],
                episode.action,
            ]
        )
        limited: npt.NDArray[np.float32] = np.clip(made, -STATE_LIMIT, STATE_LIMIT).astype(np.float32)
        return limited

    # --- snapshots ---

    def save(self, number: int) -> tuple[bytes, Episode]:
        return self.worlds[number].snapshot(), self.episodes[number].copy()

    def load(self, number: int, saved: tuple[bytes, Episode]) -> None:
        """Continues from a saved episode of any environment with the same task and options."""
        snapshot, episode = saved
        now = self.episodes[number]
        if self.randomise.changes_tools and episode.drawn != now.drawn:
            world = self._world(self._drawn_tools(episode.drawn))
            world.restore(snapshot)
            self._replace(number, world)
        self.batch.restore([snapshot], [number])
        self.episodes[number] = episode.copy()
