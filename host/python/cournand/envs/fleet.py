"""Holds many episodes of one task; the single and the vector environment share this code.

All random numbers of episode e of an environment with seed s come from numpy.random.default_rng([s, e]). An episode
depends neither on other environments, nor on earlier episodes, nor on the number of threads.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..batch import FIGURES, Batch, Pool
from ..scene import Scene, Tool
from ..world import TICKS_PER_S, Order, World
from ..xray import View, XRay
from .actions import Actions
from .task import TOOL_FACTORS, Exchange, Randomise, Task, VesselPaths

POINTS, SPACING_M = 3, 0.002
KINDS = ("state", "fluoroscopy", "labels")
STATE_LIMIT = 10.0
APPROACH_M_PER_S = 0.06
OWN_RENDERERS = 16
STARTS_MAX = 64
HEART_RATE = 1  # the action of an order for the rhythm
ANGLES_MAX_DEG = np.array([120.0, 50.0])
LEAST_ML, LEAST_ML_PER_S = 0.001, 0.001


@dataclass
class Episode:
    """Holds the state of one episode, except for its world."""

    seed: int = 0
    number: int = 0
    step: int = 0
    target_m: npt.NDArray[np.float64] = None  # type: ignore[assignment]
    """Target in the reference pose."""
    moved_m: npt.NDArray[np.float64] = None  # type: ignore[assignment]
    """Target at the tick `moved_at`, in a scene that moves."""
    moved_at: int = -1
    exits: npt.NDArray[np.float64] = None  # type: ignore[assignment]
    beyond: npt.NDArray[np.float64] = None  # type: ignore[assignment]
    path_m: float = 0.0
    force_peak_N: float = 0.0
    action: npt.NDArray[np.float32] = None  # type: ignore[assignment]
    view: View = View()
    drawn: dict[str, float] = None  # type: ignore[assignment]
    is_done: bool = False
    ordered_ml: float = 0.0
    """Volume that the syringe was ordered to inject; the injected volume reaches it within 40 ticks."""
    injected_ml: float = 0.0
    flow_ml_per_s: float = 0.0
    pictures: int = 1
    """Number of pictures that were made with the pedal down, plus the picture at the beginning of the episode."""
    wants_picture: bool = True
    held: dict[str, npt.NDArray[np.uint8]] = field(default_factory=dict)
    """Holds the last picture of each kind; these arrays are never changed in place."""

    def following(self) -> tuple[int, int]:
        """Returns the seed and the episode number of the next episode."""
        return self.seed, self.number + 1

    @property
    def stage(self) -> int:
        """Number of the episode's scene in the fleet's list of scenes."""
        return int(self.drawn["scene"])

    def copy(self) -> Episode:
        return replace(self, action=self.action.copy(), held=dict(self.held))


class Stage:
    """Holds a scene, and the vessels in it that contain the task's targets."""

    def __init__(self, name: str, task: Task) -> None:
        self.scene = Scene(name)
        self.paths = VesselPaths(self.scene)
        self.targets = [self.scene.find_vessel(target) for target in task.targets]
        self.renderers: list[XRay] = []


class Fleet:
    """Holds the worlds and the episodes of `count` environments."""

    def __init__(
        self,
        task: Task,
        count: int,
        *,
        threads: int = 1,
        observation: str | Sequence[str] = "state",
        action: str = "continuous",
        contrast: bool = False,
        c_arm: bool = False,
        size: int = 128,
        randomise: Randomise | None = None,
    ) -> None:
        self.task, self.count, self.size, self.threads = task, count, size, threads
        self.kinds = (observation,) if isinstance(observation, str) else tuple(observation)
        if not self.kinds or any(kind not in KINDS for kind in self.kinds):
            raise ValueError("observation: %r is not one of %s, nor several of them" % (observation, ", ".join(KINDS)))
        self.is_dict = not isinstance(observation, str)
        if not 64 <= size <= 512 or size % 16:
            raise ValueError("size: %r is not a multiple of 16 within 64 and 512" % (size,))
        self.randomise = randomise or Randomise()
        self.stages = [Stage(name, task) for name in self.randomise.scenes or (task.scene,)]
        self.tools = [Tool(name) for name in task.all_tools()]
        self.positions = len(task.tools)
        self.actions = Actions(self.positions, action, contrast=contrast, c_arm=c_arm)
        if contrast and not any(tool.is_catheter for tool in self.tools[: self.positions]):
            raise ValueError("contrast: no tool of the task has a lumen: name a catheter in Task.tools")
        self.pool = Pool(threads)
        self._starts: OrderedDict[tuple[Any, ...], bytes] = OrderedDict()
        self._ready: list[dict[int, World]] = [{} for _ in range(count)]  # by scene; unchanged tools alone
        worlds = [self._ready_world(number, 0) for number in range(count)]
        self.batch = Batch(self.pool, worlds, points=POINTS, spacing_m=SPACING_M)
        self.worlds = worlds
        if contrast:
            self._check_flow()
        self.episodes = [Episode(drawn={"scene": 0.0}) for _ in range(count)]

    @property
    def has_pictures(self) -> bool:
        return "fluoroscopy" in self.kinds or "labels" in self.kinds

    @property
    def has_contrast(self) -> bool:
        return self.actions.contrast is not None

    @property
    def has_c_arm(self) -> bool:
        return self.actions.c_arm is not None

    @property
    def state_width(self) -> int:
        return 3 * POINTS + 3 + 3 * self.positions + 3 + 2 * self.has_contrast + 2 * self.has_c_arm + self.actions.width

    def _check_flow(self) -> None:
        """Raises an exception if the task's largest flow does not pass through the lumen of its tool."""
        tried = self._world(self.tools, 0)
        assert tried.patient is not None
        tried.patient.inject(1.0, ml_per_s=self.task.contrast_max_ml_per_s)

    # --- worlds ---

    def _world(self, tools: Sequence[Tool], stage: int) -> World:
        line = [self.task.all_tools().index(name) + 1 for name in self.task.first_line()]
        ticks = self.task.contact_ticks
        return World(self.stages[stage].scene, tools, line=line, contact_ticks=ticks, patient=self.has_contrast)

    def _ready_world(self, number: int, stage: int) -> World:
        """Returns an environment's world with the unchanged tools in this scene; the world is made only once."""
        ready = self._ready[number]
        if stage not in ready:
            ready[stage] = self._world(self.tools, stage)
        return ready[stage]

    def _world_of(self, number: int, episode: Episode) -> World:
        """Returns a world with the tools and the scene of an episode; its state may be any."""
        if not self.randomise.changes_tools:
            return self._ready_world(number, episode.stage)
        return self._world(self._drawn_tools(episode.drawn), episode.stage)

    def _start_key(self, episode: Episode) -> tuple[Any, ...]:
        factors = tuple(episode.drawn.get(name, 1.0) for name in TOOL_FACTORS) if self.randomise.changes_tools else ()
        return (episode.stage, *factors)

    def _approach(self, worlds: Sequence[World], episodes: Sequence[Episode]) -> None:
        """Brings worlds to the state in which the task begins: by restoring a snapshot or, if there is none, by pushing
        the tools in. The snapshots after the last approaches are kept, so that episodes with fixed seeds do not push
        the tools in again."""
        keys = [self._start_key(episode) for episode in episodes]
        new = list({key: number for number, key in enumerate(keys) if key not in self._starts}.values())
        starts = {key: self._starts[key] for key in keys if key in self._starts}
        if new:
            pushed = [self._world_at_start(worlds[number], episodes[number]) for number in new]
            with ThreadPoolExecutor(self.threads) as threads:
                list(threads.map(self._push_in, pushed))
            starts.update({keys[number]: world.snapshot() for number, world in zip(new, pushed)})
        for key in keys:
            self._starts[key] = starts[key]
            self._starts.move_to_end(key)
        while len(self._starts) > STARTS_MAX:
            self._starts.popitem(last=False)
        Batch(self.pool, worlds, points=0).restore([starts[key] for key in keys])

    def _push_in(self, world: World) -> None:
        """Moves the tools of a world to where the task begins."""
        task = self.task
        if task.approach_m > 0.0:
            world.move(
                [APPROACH_M_PER_S] * self.positions, ticks=round(task.approach_m / APPROACH_M_PER_S * TICKS_PER_S)
            )
        for one in task.approach:
            if isinstance(one, Exchange):
                world.exchange(one.position, task.all_tools().index(one.tool) + 1)
                world.move(ticks=1)
                continue
            way_m = one.inserted_m - world.read().inserted_m[one.position]
            speeds = [0.0] * self.positions
            speeds[one.position] = math.copysign(one.speed_m_per_s, way_m)
            world.move(speeds, ticks=max(round(abs(way_m) / one.speed_m_per_s * TICKS_PER_S), 1))

    def _world_at_start(self, world: World, episode: Episode) -> World:
        """Returns a world at tick 0 that is like `world`, because an episode may still be using `world`."""
        if world.tick == 0:
            return world
        tools = self._drawn_tools(episode.drawn) if self.randomise.changes_tools else self.tools
        return self._world(tools, episode.stage)

    def _put(self, number: int, world: World) -> None:
        if self.worlds[number] is not world:
            self.worlds[number] = world
            self.batch.put(number, world)

    # --- episodes ---

    def begin(self, which: Sequence[int], seeds: Sequence[tuple[int, int]]) -> None:
        """Begins an episode in each of the given environments, from its seed and its episode number. Everything that
        can be refused is done first, so that a refusal changes no episode."""
        begun = [self._drawn_episode(seed, number) for seed, number in seeds]
        worlds = [self._world_of(number, episode) for number, episode in zip(which, begun)]
        self._approach(worlds, begun)
        for number, world in zip(which, worlds):
            self._put(number, world)
        self._set_heart_rates(which, begun)
        self.batch.read(which)
        for number, episode in zip(which, begun):
            self.episodes[number] = episode
            episode.path_m = self._path(number)

    def _set_heart_rates(self, which: Sequence[int], begun: Sequence[Episode]) -> None:
        """Gives each heart its rate. The order for the heart rate takes one tick, during which the tools rest."""
        rates = [round(episode.drawn["heart_rate_per_min"]) for episode in begun]
        if not any(rates):
            return
        for number, rate in zip(which, rates):
            self.worlds[number].order(Order.RHYTHM, HEART_RATE, rate)
        self.batch.move(np.zeros((len(which), 8), dtype=np.float32), 1, which)

    def _drawn_episode(self, seed: int, number: int) -> Episode:
        random = np.random.default_rng([seed, number])
        index, part = int(random.integers(len(self.task.targets))), float(random.uniform(*self.task.target_part))
        drawn = self.randomise.draw(random)
        stage = self.stages[int(drawn["scene"])]
        target, along = stage.paths.point(stage.targets[index], part)
        exits, beyond = stage.paths.towards(stage.targets[index], along)
        no_action = np.zeros(self.actions.width, dtype=np.float32)
        view = self._view(target, drawn)
        return Episode(
            seed,
            number,
            target_m=target,
            exits=exits,
            beyond=beyond,
            path_m=np.inf,
            action=no_action,
            view=view,
            drawn=drawn,
        )

    def _drawn_tools(self, drawn: dict[str, float]) -> list[Tool]:
        factors = {name: drawn[name] for name in TOOL_FACTORS}
        return [tool.scaled(**factors) for tool in self.tools]

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

    def step(self, parts: npt.NDArray[np.float32], which: Sequence[int]) -> tuple[npt.NDArray[Any], ...]:
        """Moves the given environments by their actions (as numbers of Actions.parts()). Returns the rewards, and
        whether each episode is terminated or truncated, for all environments."""
        task, rows = self.task, np.zeros((len(which), 8), dtype=np.float32)
        rows[:, : self.positions] = parts[:, self.actions.push] * task.push_max_m_per_s
        rows[:, 3 : 3 + self.positions] = parts[:, self.actions.turn] * task.turn_max_rad_per_s
        if self.has_contrast:
            for row, number in enumerate(which):
                self._inject(number, float(parts[row, self.actions.contrast]))
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
            if self.has_contrast:
                self._read_syringe(number)
            episode.wants_picture = True
            if self.has_c_arm:
                rewards[number] += self._move_c_arm(episode) * task.reward_per_picture
            terminated[number] = is_reached or is_out
            truncated[number] = episode.step >= task.steps and not terminated[number]
            episode.is_done = bool(terminated[number] or truncated[number])
        return rewards, terminated, truncated

    def _inject(self, number: int, part: float) -> None:
        """Injects contrast medium during the next step, as long as the syringe is not empty."""
        flow = part * self.task.contrast_max_ml_per_s
        episode = self.episodes[number]
        left_ml = self.task.contrast_limit_ml - episode.ordered_ml
        ml = min(flow * self.task.ticks / TICKS_PER_S, left_ml)
        if flow >= LEAST_ML_PER_S and ml >= LEAST_ML:
            patient = self.worlds[number].patient
            assert patient is not None
            patient.inject(ml, ml_per_s=flow)
            episode.ordered_ml += ml

    def _read_syringe(self, number: int) -> None:
        patient, episode = self.worlds[number].patient, self.episodes[number]
        assert patient is not None
        reading = patient.read()
        episode.injected_ml, episode.flow_ml_per_s = reading.injected_ml, reading.injection_flow_ml_per_s

    def _move_c_arm(self, episode: Episode) -> bool:
        """Turns the C-arm by this step's action, and returns whether the pedal is down."""
        first = self.actions.c_arm
        assert first is not None
        most_deg = self.task.c_arm_max_deg_per_s * self.task.ticks / TICKS_PER_S
        angles = np.array([episode.view.primary_deg, episode.view.secondary_deg])
        angles = np.clip(angles + most_deg * episode.action[first : first + 2], -ANGLES_MAX_DEG, ANGLES_MAX_DEG)
        episode.view = replace(episode.view, primary_deg=float(angles[0]), secondary_deg=float(angles[1]))
        episode.wants_picture = bool(episode.action[first + 2] > 0.5)
        episode.pictures += episode.wants_picture
        return episode.wants_picture

    def figure(self, number: int, name: str) -> float:
        return float(self.batch.states[number, self.batch.columns.figures][FIGURES.index(name)])

    def tip_distance(self, number: int) -> float:
        return float(np.linalg.norm(self.batch.states[number, :3] - self.target_now_m(number)))

    def target_now_m(self, number: int) -> npt.NDArray[np.float64]:
        """Returns the target, which moves with the vessel's wall."""
        episode = self.episodes[number]
        if not self.stages[episode.stage].scene.moves:
            return episode.target_m
        if episode.moved_at != self.worlds[number].tick:
            episode.moved_at = self.worlds[number].tick
            episode.moved_m = self.worlds[number].moved(episode.target_m[None])[0]
        return episode.moved_m

    def is_safe(self, number: int) -> bool:
        return self.episodes[number].force_peak_N <= self.task.force_limit_N

    def _path(self, number: int) -> float:
        """Returns the tip's distance to the target along the vessels; if the tip's vessel is not known, returns the
        last known distance."""
        episode, vessel = self.episodes[number], int(self.batch.vessels[number])
        if vessel < 0:
            return episode.path_m if np.isfinite(episode.path_m) else self.tip_distance(number)
        return float(abs(self.batch.places[number, 0] - episode.exits[vessel]) + episode.beyond[vessel])

    def info(self, number: int) -> dict[str, Any]:
        episode = self.episodes[number]
        is_out = bool(self.figure(number, "is_out_of_range"))
        is_reached = self.tip_distance(number) <= self.task.reach_m and not is_out
        more: dict[str, Any] = {"injected_ml": episode.injected_ml} if self.has_contrast else {}
        if self.has_c_arm:
            more["pictures"] = episode.pictures
        if len(self.stages) > 1:
            more["scene"] = episode.stage
        return {
            "is_success": is_reached and self.is_safe(number),
            "is_reached": is_reached,
            "is_out_of_range": is_out,
            "force_peak_N": episode.force_peak_N,
            "path_m": episode.path_m,
            "target_m": self.target_now_m(number).copy(),
            "seed": episode.seed,
            "episode": episode.number,
            **more,
        }

    # --- observations ---

    def observe(self, which: Sequence[int]) -> None:
        """Renders the pictures that the given environments need. States need no work."""
        wanted = [number for number in which if self.episodes[number].wants_picture]
        if not self.has_pictures:
            return
        for index, stage in enumerate(self.stages):
            self._render(stage, [number for number in wanted if self.episodes[number].stage == index])

    def _render(self, stage: Stage, which: Sequence[int]) -> None:
        if not which:
            return
        if not stage.renderers:  # one per environment, which keeps its view; many environments share one per thread
            count = self.count if self.count <= OWN_RENDERERS and len(self.stages) == 1 else self.threads
            stage.renderers = [XRay(stage.scene, self.size) for _ in range(count)]
        grey, labels = self.batch.render(
            stage.renderers,
            [self.episodes[number].view for number in which],
            [self._noise_seed(number) for number in which],
            labels="labels" in self.kinds,
            picture="fluoroscopy" in self.kinds,
            which=which,
        )
        for number in which:
            episode = self.episodes[number]
            for kind, pixels in (("fluoroscopy", grey), ("labels", labels)):
                if kind in self.kinds:
                    assert pixels is not None
                    episode.held[kind] = pixels[number].copy()

    def _noise_seed(self, number: int) -> int:
        episode = self.episodes[number]
        words = np.random.SeedSequence([episode.seed, episode.number, episode.step]).generate_state(1, np.uint64)
        return int(words[0])

    def observation(self, number: int) -> Any:
        """Returns a copy of one environment's observation."""
        held = self.episodes[number].held
        parts = {kind: self._state(number) if kind == "state" else held[kind].copy() for kind in self.kinds}
        return parts if self.is_dict else parts[self.kinds[0]]

    def _state(self, number: int) -> npt.NDArray[np.float32]:
        task, episode = self.task, self.episodes[number]
        row, columns = self.batch.states[number], self.batch.columns
        points = row[columns.points].reshape(POINTS, 3)
        heading = points[0] - points[1]
        hands = row[columns.hands].reshape(3, 3)[: self.positions]
        more: list[float] = []
        if self.has_contrast:
            more += [
                episode.flow_ml_per_s / task.contrast_max_ml_per_s,
                episode.injected_ml / task.contrast_limit_ml,
            ]
        if self.has_c_arm:
            more += [episode.view.primary_deg / ANGLES_MAX_DEG[0], episode.view.secondary_deg / ANGLES_MAX_DEG[1]]
        made = np.concatenate(
            [
                ((points - self.target_now_m(number)) / 0.1).ravel(),
                heading / max(float(np.linalg.norm(heading)), 1e-9),
                (hands / (1.0, 1.0, 0.01)).ravel(),
                [
                    self.figure(number, "wall_force_N") / task.force_limit_N,
                    episode.force_peak_N / task.force_limit_N,
                    episode.path_m,
                ],
                more,
                episode.action,
            ]
        )
        limited: npt.NDArray[np.float32] = np.clip(made, -STATE_LIMIT, STATE_LIMIT).astype(np.float32)
        return limited

    # --- snapshots ---

    def save(self, number: int) -> tuple[bytes, Episode]:
        return self.worlds[number].snapshot(), self.episodes[number].copy()

    def load(self, number: int, saved: tuple[bytes, Episode]) -> None:
        """Restores a saved episode of any environment with the same task and options."""
        snapshot, episode = saved
        if self._start_key(episode) != self._start_key(self.episodes[number]):
            world = self._world_of(number, episode)
            world.restore(snapshot)
            self._put(number, world)
        self.batch.restore([snapshot], [number])
        self.episodes[number] = episode.copy()
        if episode.held:  # the picture of the snapshot's step; otherwise it was taken from other observations
            self.episodes[number].wants_picture = False
