"""Lets a network imitate the scripted expert before it learns from its own episodes."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from cournand.tasks import Challenge, EpisodeSeed, Player, Policy
from cournand.tasks.network import Memory, features
from cournand.tasks.policies import POLICIES
from stable_baselines3.common.vec_env import VecNormalize

from .worlds import LAGS

_Floats = npt.NDArray[np.float32]
PASSES, BATCH = 40, 256
KEPT = 1000.0
"""Factor for the weight of the demonstrations in the statistics of the observations."""


class _Recorder:
    """The expert, who notes what the network would have seen, and what the expert did."""

    def __init__(self) -> None:
        self.moments: dict[EpisodeSeed, list[tuple[_Floats, _Floats]]] = {}

    def make(self, challenge: Challenge, episode: EpisodeSeed) -> Policy:
        expert, noted = POLICIES["expert"](challenge, episode), self.moments.setdefault(episode, [])

        def policy(observation: _Floats, info: dict[str, Any]) -> _Floats:
            action = expert(observation, info)
            noted.append((features(observation), action))
            return action

        return policy


def demonstrate(
    challenge: Challenge, count: int, anatomies: str | os.PathLike[str]
) -> tuple[_Floats, _Floats, npt.NDArray[np.bool_]]:
    """Lets the expert play the first `count` training episodes. Returns what the network would see and the expert's
    actions, [moments, width] each, and whether each moment belongs to a safe success, [moments]."""
    episodes, recorder = challenge.episodes("train", count), _Recorder()
    rows = Player(challenge, anatomies).play(episodes, recorder.make)
    seen, actions, is_good = [], [], []
    for episode, row in zip(episodes, rows):
        moments = recorder.moments[episode]
        is_good += [row.is_success] * len(moments)
        memory = Memory(LAGS, 1, len(moments[0][0]))
        memory.begin(0, moments[0][0])
        for number, (now, action) in enumerate(moments):
            if number:
                memory.add(now[None])
            seen.append(memory.seen()[0])
            actions.append(action)
    if not any(is_good):
        raise ValueError("the expert has no safe success in %d episodes of %s" % (count, challenge.name))
    return np.stack(seen), np.stack(actions), np.array(is_good)


def imitate(
    model: Any, normalised: VecNormalize, seen: _Floats, actions: _Floats, is_good: npt.NDArray[np.bool_]
) -> list[float]:
    """Brings the mean action of a model near the actions of safe successes, by least squares. Returns the mean square
    of the difference in each pass. The statistics of the observations come from all moments, and then hardly change, so
    that what the network has learned stays true."""
    normalised.obs_rms.update(seen)
    normalised.obs_rms.count *= KEPT
    seen, actions = seen[is_good], actions[is_good]
    inputs, wanted = torch.from_numpy(normalised.normalize_obs(seen)), torch.from_numpy(actions)
    parts = [*model.policy.mlp_extractor.policy_net.parameters(), *model.policy.action_net.parameters()]
    optimiser, errors = torch.optim.Adam(parts, lr=1e-3), []
    for _ in range(PASSES):
        order, total = torch.randperm(len(inputs)), 0.0
        for first in range(0, len(order), BATCH):
            chosen = order[first : first + BATCH]
            means = model.policy.action_net(model.policy.mlp_extractor.forward_actor(inputs[chosen]))
            loss = torch.nn.functional.mse_loss(means, wanted[chosen])
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            total += float(loss.detach()) * len(chosen)
        errors.append(total / len(order))
    return errors
