"""Trains a network by PPO, and writes it as a file that cournand.judge reads without PyTorch."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from cournand.tasks import Challenge
from cournand.tasks.environments import scenes_of as scenes_of_split
from cournand.tasks.network import SEEN_MAX, Network
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecNormalize

from .demonstrations import demonstrate, imitate
from .worlds import LAGS, Worlds

COLUMNS = ("steps", "seconds", "episodes", "rewards", "safe_success", "steps_median")
SEEDS_APART = 1000
"""World i of a training with the seed s has the seed 1000 s + i, so two trainings have no episode in common."""
SEEN_EARLIER = 3e6
"""Weight of an earlier training in the statistics of the observations, in observations: they hardly change."""
WATCHED = 50
"""Number of the last episodes whose results a point of the curve averages."""


@dataclass(frozen=True)
class Course:
    """Settings of a training. The rewards are those of the training alone: judging has no rewards."""

    steps: int = 60_000
    seed: int = 1
    """From 0 to 4,000,000."""
    worlds: int = 16
    threads: int = 1
    scenes: int = 8
    """Largest number of training anatomies, if every episode of the task has a new one."""
    rollout: int = 64
    """Steps of each world between two changes of the network."""
    batch: int = 256
    epochs: int = 10
    rate: float = 3e-4
    discount: float = 0.99
    hidden: tuple[int, ...] = (64, 64)
    noise: float = 0.135
    """Standard deviation of the exploration's weights at the beginning (state-dependent exploration). An action is the
    sum over the 64 outputs of the last layer, times such weights."""
    noise_steps: int = 8
    """Steps between two drawings of the exploration. A turn at the hand reaches the tip only after several steps in the
    same direction."""
    demonstrations: int = 0
    """Number of episodes in which the network imitates the scripted expert before it learns on its own."""
    push: float = 0.0
    """Mean push of all tools at the beginning, in parts of the largest speed."""
    reward_per_m: float = 10.0
    reward_reached: float = 5.0
    reward_per_nearer_m: float = 10.0
    """Reward for each metre by which the tip comes nearer to the target in a straight line."""
    reward_per_step: float = -0.02
    episode_steps: int = 150
    """Largest number of steps in an episode of the training, which is then longer only in judging."""


def scenes_of(challenge: Challenge, anatomies: str | os.PathLike[str], most: int) -> list[str]:
    """Returns the scenes of the training anatomies. Raises BadFileError with the remedy if one does not exist."""
    if not challenge.is_always_new:
        return list(scenes_of_split(challenge, anatomies, "train")) or [challenge.task.scene]
    challenge.need_scenes(anatomies, challenge.episodes("train", most))
    return [challenge.scene(anatomies, seed) for seed in challenge.anatomies("train", most)]


class _Curve(BaseCallback):
    """Notes the results of the episodes after each rollout."""

    def __init__(self, after: Callable[[Sequence[float]], None]) -> None:
        super().__init__()
        self.after, self.begin = after, time.process_time()
        self.ended: list[tuple[float, float, float]] = []

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                self.ended.append((info["episode"]["r"], float(info["is_success"]), info["episode"]["l"]))
        return True

    def _on_rollout_end(self) -> None:
        last = np.array(self.ended[-WATCHED:])
        if len(last):
            means = (float(last[:, 0].mean()), float(last[:, 1].mean()), float(np.median(last[:, 2])))
            self.after((self.num_timesteps, time.process_time() - self.begin, len(self.ended), *means))


def learner(challenge: Challenge, course: Course, scenes: Sequence[str]) -> tuple[Any, VecNormalize]:
    """Returns a model that has not learned yet, and its worlds with the statistics of what they return."""
    task = replace(
        challenge.task,
        reward_per_m=course.reward_per_m,
        reward_reached=course.reward_reached,
        reward_per_step=course.reward_per_step,
        steps=min(challenge.task.steps, course.episode_steps),
    )
    worlds = Worlds(
        task,
        scenes,
        course.worlds,
        threads=course.threads,
        reward_per_nearer_m=course.reward_per_nearer_m,
    )
    normalised = VecNormalize(worlds, gamma=course.discount, clip_obs=SEEN_MAX)
    model: Any = PPO(
        "MlpPolicy",
        normalised,
        n_steps=course.rollout,
        batch_size=course.batch,
        n_epochs=course.epochs,
        learning_rate=course.rate,
        gamma=course.discount,
        use_sde=True,
        sde_sample_freq=course.noise_steps,
        policy_kwargs={"net_arch": list(course.hidden), "log_std_init": float(np.log(course.noise))},
        seed=course.seed,
        device="cpu",
    )
    worlds.seed(SEEDS_APART * course.seed)  # after PPO, which seeds the worlds by the seed itself
    with torch.no_grad():
        model.policy.action_net.bias[: len(task.tools)] = course.push
    return model, normalised


def train(
    challenge: Challenge,
    course: Course,
    anatomies: str | os.PathLike[str] = "anatomies",
    after: Callable[[Sequence[float]], None] = lambda row: None,
    begin_with: Network | None = None,
) -> tuple[Network, list[tuple[float, ...]]]:
    """Trains on the training anatomies of a task. Returns the network and its curve, a row of COLUMNS per rollout;
    calls `after` with each row. The seconds are those of the processor. Equal courses give equal networks. With
    `begin_with`, this network learns on; without it, a new one begins."""
    torch.set_num_threads(1)
    model, normalised = learner(challenge, course, scenes_of(challenge, anatomies, course.scenes))
    if begin_with is not None:
        put(begin_with, model, normalised)
    if course.demonstrations:
        imitate(model, normalised, *demonstrate(challenge, course.demonstrations, anatomies))
    rows: list[tuple[float, ...]] = []

    def note(row: Sequence[float]) -> None:
        rows.append(tuple(row))
        after(row)

    model.learn(course.steps, callback=_Curve(note))
    return exported(model, normalised, challenge), rows


def _linear(model: Any) -> list[torch.nn.Linear]:
    """Returns the layers from the observation to the mean action."""
    hidden = [one for one in model.policy.mlp_extractor.policy_net if isinstance(one, torch.nn.Linear)]
    return [*hidden, model.policy.action_net]


def put(network: Network, model: Any, normalised: VecNormalize) -> None:
    """Makes a model act as a network does. Raises ValueError if the network has other sizes."""
    sizes = [tuple(one.weight.shape) for one in _linear(model)]
    given = [weights.shape for weights, _ in network.layers]
    if sizes != given or list(network.lags) != list(LAGS):
        raise ValueError(
            "the network of the task %s has the sizes %s and the lags %s; this training needs %s and %s"
            % (network.task, given, list(network.lags), sizes, list(LAGS))
        )
    with torch.no_grad():
        for layer, (weights, biases) in zip(_linear(model), network.layers):
            layer.weight.copy_(torch.from_numpy(weights))
            layer.bias.copy_(torch.from_numpy(biases))
    normalised.obs_rms.mean = network.mean.astype(np.float64)
    normalised.obs_rms.var = np.maximum(network.scale.astype(np.float64) ** 2 - normalised.epsilon, 0.0)
    normalised.obs_rms.count = SEEN_EARLIER


def exported(model: Any, normalised: VecNormalize, challenge: Challenge) -> Network:
    """Returns the mean action of a model, without its noise, as a network for NumPy."""
    layers = [(one.weight.detach().numpy().copy(), one.bias.detach().numpy().copy()) for one in _linear(model)]
    statistics = normalised.obs_rms
    return Network(
        layers,
        statistics.mean.astype(np.float32),
        np.sqrt(statistics.var + normalised.epsilon).astype(np.float32),
        LAGS,
        challenge.name,
        challenge.version,
    )


def write_curve(path: str | os.PathLike[str], rows: Sequence[Sequence[float]]) -> None:
    """Writes the rows of a curve as a table with tabs between its columns."""
    lines = ["\t".join(COLUMNS)] + ["\t".join("%.6g" % one for one in row) for row in rows]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
