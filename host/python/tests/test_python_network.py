#!/usr/bin/env python3
"""Tests the policies that are small networks: what they see, what they compute, and their files. A network is judged
with the same bits by any number of threads. Prints TAP."""

import os
import sys
import tempfile
from dataclasses import replace

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import numpy as np  # noqa: E402
from cournand import BadFileError  # noqa: E402
from cournand.envs import Task  # noqa: E402
from cournand.tasks import CHALLENGES, Challenge, Linear, Network, policy_of, score  # noqa: E402
from cournand.tasks.network import TIP_FEATURES, Memory, features  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402

NEAR = Task(targets=("right iliac artery",), target_part=(0.5, 0.6), steps=30)
SHORT = Challenge("short", "a short push in the shipped iliac artery", NEAR, "own")
WIDTH = 20 + TIP_FEATURES
FOLDER = tempfile.TemporaryDirectory()


def refusal(call, kind=BadFileError):
    """Returns the text of a refusal; "" if there is none."""
    try:
        call()
    except kind as error:
        return str(error)
    return ""


def network(seed=3, lags=(0, 2), sizes=(8, 2), push=0.8):
    """Returns a network with random weights, which pushes."""
    random, inputs, layers = np.random.default_rng(seed), WIDTH * len(lags), []
    mean, scale = random.normal(size=inputs), random.uniform(0.5, 2.0, inputs)
    for outputs in sizes:
        layers.append((random.normal(size=(outputs, inputs)) * 0.1, np.zeros(outputs)))
        inputs = outputs
    layers[-1][1][0] = push
    layers = [(weights.astype(np.float32), biases.astype(np.float32)) for weights, biases in layers]
    return Network(layers, mean.astype(np.float32), scale.astype(np.float32), lags, "short", 1)


def path(name):
    return os.path.join(FOLDER.name, name)


def the_features_state_the_bend_and_the_target_in_the_tips_frame():
    """The tip points along x and bends towards y; the target is 20 mm ahead, 20 mm to the side of the bend, and 10 mm
    across: at a distance of 30 mm, its direction is (2, 2, 1) / 3."""
    points = np.array([[0.004, 0.0004, 0.0], [0.002, 0.0, 0.0], [0.0, 0.0, 0.0]])
    along = points[0] - points[1]
    along /= np.linalg.norm(along)
    side = np.array([0.0, 1.0, 0.0]) - along * along[1]
    side /= np.linalg.norm(side)
    target = points[0] + 0.02 * along + 0.02 * side + 0.01 * np.cross(along, side)
    observation = np.concatenate([((points - target) / 0.1).ravel(), np.arange(11.0)]).astype(np.float32)
    made = features(observation)
    worst = max(np.abs(made[20:23] - side).max(), np.abs(made[23:27] - (2 / 3, 2 / 3, 1 / 3, 0.3)).max())
    print("# at most %.1e apart" % worst)
    many = features(np.stack([observation, observation * 2]))
    return np.array_equal(made[:20], observation) and worst < 1.5e-6 and np.array_equal(many[0], made)


def the_features_of_a_straight_tip_are_finite():
    made = features(np.zeros((2, 20), dtype=np.float32))
    return made.shape == (2, WIDTH) and bool(np.isfinite(made).all())


def a_memory_returns_moments_of_the_given_ages():
    memory = Memory((0, 1, 3), 2, 1)
    for number in range(2):
        memory.begin(number, np.array([10.0 * number], dtype=np.float32))
    for moment in (1.0, 2.0):
        memory.add(np.array([[moment], [10.0 + moment]], dtype=np.float32))
    first = memory.seen().tolist() == [[2.0, 1.0, 0.0], [12.0, 11.0, 10.0]]
    memory.begin(0, np.array([7.0], dtype=np.float32))
    return first and memory.seen().tolist() == [[7.0, 7.0, 7.0], [12.0, 11.0, 10.0]]


def an_action_is_that_of_the_formula():
    """The reference is computed in double precision."""
    made, seen = network(), np.random.default_rng(5).normal(size=2 * WIDTH).astype(np.float32)
    values = np.clip((seen.astype(float) - made.mean) / made.scale, -10, 10)
    (first, bias), (second, last) = made.layers
    wanted = np.clip(second.astype(float) @ np.tanh(first.astype(float) @ values + bias) + last, -1, 1)
    worst = np.abs(made.action(seen) - wanted).max()
    print("# at most %.1e apart" % worst)
    return worst < 1e-7  # rounding of float32; measured 1.1e-8


def a_file_returns_the_network_that_was_written():
    made = network()
    made.save(path("same.npz"))
    read = Network.load(path("same.npz"))
    same = all(np.array_equal(a, b) for one, two in zip(made.layers, read.layers) for a, b in zip(one, two))
    same = same and np.array_equal(made.mean, read.mean) and np.array_equal(made.scale, read.scale)
    left = [name for name in os.listdir(FOLDER.name) if name.endswith(".part")]
    return same and read.lags == [0, 2] and (read.task, read.version) == ("short", 1) and not left


def a_network_is_judged_with_the_same_bits_by_1_and_2_threads():
    network().save(path("judged.npz"))
    cards = []
    for threads in (1, 2):
        made = score(SHORT, policy_of(path("judged.npz")), name="judged", episodes=3, threads=threads)
        cards.append({name: value for name, value in made.items() if name != "speed"})
    print("# %s" % [row["hash"] for row in cards[0]["episodes"]])
    return cards[0] == cards[1] and len({row["hash"] for row in cards[0]["episodes"]}) == 3


def each_episode_has_its_own_memory():
    made = network(lags=(0, 5))
    first, second = (made.make(SHORT, SHORT.episode(0)) for _ in range(2))
    random = np.random.default_rng(1).normal(size=(4, 20)).astype(np.float32)
    for observation in random:
        last = first(observation, {})
    return not np.array_equal(last, second(random[-1], {})) and np.array_equal(
        made.make(SHORT, SHORT.episode(0))(random[0], {}), made.action(np.tile(features(random[0]), 2))
    )


def a_linear_policy_is_still_read():
    Linear(np.zeros((2, 21)), np.zeros(20), np.ones(20), "iliac", 1).save(path("linear.npz"))
    policy = policy_of(path("linear.npz"))(SHORT, SHORT.episode(0))
    return isinstance(policy, Linear) and not Network.is_in(path("linear.npz"))


def broken_files_are_refused_with_the_remedy():
    made = network()
    made.save(path("whole.npz"))
    whole = open(path("whole.npz"), "rb").read()
    texts = [refusal(lambda: Network.load(path("none.npz")))]
    for wrong in (b"", whole[: len(whole) // 2], b"PK" + bytes(100)):
        with open(path("broken.npz"), "wb") as file:
            file.write(wrong)
        texts.append(refusal(lambda: Network.load(path("broken.npz"))))
        texts.append(refusal(lambda: policy_of(path("broken.npz"))))
    (weights, biases), last = made.layers
    for wrong in (
        replace(made, layers=[(weights * np.nan, biases), last]),
        replace(made, layers=[last]),
        replace(made, layers=[]),
        replace(made, layers=[(weights, biases[:-1]), last]),
        replace(made, lags=[0, 1, 2, 3, 4]),
        replace(made, lags=[0, -1]),
        replace(made, scale=made.scale * 0),
        replace(made, mean=made.mean[:-1]),
    ):
        wrong.save(path("wrong.npz"))
        texts.append(refusal(lambda: Network.load(path("wrong.npz"))))
    return all("Remedy" in text for text in texts) and len(texts) == 15


def a_policy_of_another_task_is_refused():
    two = CHALLENGES["two_devices"]
    actions = refusal(lambda: network().make(two, two.episode(0)), ValueError)
    wide = network(sizes=(8, 4))
    inputs = refusal(lambda: wide.make(two, two.episode(0)), ValueError)
    print("# %s" % inputs)
    return "2 actions" in actions and "needs 4" in actions and "inputs" in inputs


tap.run(
    [
        the_features_state_the_bend_and_the_target_in_the_tips_frame,
        the_features_of_a_straight_tip_are_finite,
        a_memory_returns_moments_of_the_given_ages,
        an_action_is_that_of_the_formula,
        a_file_returns_the_network_that_was_written,
        a_network_is_judged_with_the_same_bits_by_1_and_2_threads,
        each_episode_has_its_own_memory,
        a_linear_policy_is_still_read,
        broken_files_are_refused_with_the_remedy,
        a_policy_of_another_task_is_refused,
    ]
)
