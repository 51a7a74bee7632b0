#!/usr/bin/env python3
"""Tests contrast medium and the C-arm as actions of an environment, and random heart rates and scenes. All results must
be equal, bit for bit, with any number of threads and after a restored snapshot. Prints TAP."""

import os
import shutil
import sys
import tempfile
import warnings

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import cournand  # noqa: E402
import numpy as np  # noqa: E402
from cournand.data import find  # noqa: E402
from cournand.envs import NavigationEnv, NavigationVectorEnv, Randomise, Task  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402
from env_checks import refuses  # noqa: E402

MIX = ("state", "fluoroscopy", "labels")
CATHETER = Task(targets=("right iliac artery",), target_part=(0.5, 0.9), steps=6, tools=("terumo_5f",), approach_m=0.06)
WIRE = Task(targets=("right iliac artery",), target_part=(0.5, 0.9), steps=4)
PUSH, REST, FULL = [0.5, 0.0], [0.0, 0.0], [0.5, 0.0, 1.0]


def same(a, b):
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    return np.array_equal(a, b)


def played(envs, steps=8, seed=11):
    """Returns everything that a vector environment returns for random actions."""
    envs.action_space.seed(7)
    seen = [envs.reset(seed=seed)[0]]
    for _ in range(steps):
        seen += envs.step(envs.action_space.sample())[:4]
    return seen


def gymnasium_accepts_every_action():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*(not an image|symmetric and normalized|render_modes).*")
        for action in ("continuous", "discrete"):
            more = {"action": action, "contrast": True, "c_arm": True, "observation": MIX, "size": 64}
            check_env(NavigationEnv(CATHETER, **more), skip_render_check=True)
    return True


def contrast_medium_flows_as_the_action_says():
    env = NavigationEnv(CATHETER, contrast=True, observation=("state", "labels"), size=128)
    seen, _ = env.reset(seed=1)
    good = env.action_space.shape == (3,) and not (seen["labels"] & cournand.Label.MEDIUM).any()
    for _ in range(5):
        seen, _, _, _, info = env.step(np.array(FULL))
    flowing, injected = seen["state"][-5], info["injected_ml"]
    good = good and bool((seen["labels"] & cournand.Label.MEDIUM).any())
    seen, _, _, _, info = env.step(np.array([0.0, 0.0, 0.0]))
    print(
        "# %.3f ml after five steps and %.3f after a pause, at %.2f of the flow"
        % (injected, info["injected_ml"], flowing)
    )
    most = 4.0 * 0.133 * 5  # flow times time
    return (
        good
        and abs(flowing - 1.0) < 1e-6
        and most - 0.17 < injected <= most + 1e-6
        and info["injected_ml"] <= most + 1e-6
    )


def the_syringe_is_empty_after_its_volume():
    env = NavigationEnv(Task(**{**CATHETER.__dict__, "contrast_limit_ml": 1.0, "steps": 20}), contrast=True)
    env.reset(seed=1)
    for _ in range(12):
        info = env.step(np.array([0.0, 0.0, 1.0]))[4]
    return abs(info["injected_ml"] - 1.0) < 2e-3


def a_tool_without_a_lumen_injects_nothing():
    narrow = Task(**{**CATHETER.__dict__, "contrast_max_ml_per_s": 50.0})
    return refuses(lambda: NavigationEnv(WIRE, contrast=True)) and refuses(
        lambda: NavigationEnv(narrow, contrast=True), cournand.RefusedError
    )


def the_c_arm_turns_and_the_pedal_makes_pictures():
    env = NavigationEnv(WIRE, c_arm=True, observation=("state", "fluoroscopy"), size=64)
    first, info = env.reset(seed=1)
    held, _, _, _, after = env.step(np.array(REST + [1.0, -0.5, 0.0]))
    seen, _, _, _, last = env.step(np.array(REST + [1.0, -0.5, 1.0]))
    angles = seen["state"][-7:-5] * (120.0, 50.0)
    print("# the C-arm is at %.2f and %.2f degrees" % tuple(angles))
    return (
        same(first["fluoroscopy"], held["fluoroscopy"])
        and not same(held["fluoroscopy"], seen["fluoroscopy"])
        and [one["pictures"] for one in (info, after, last)] == [1, 1, 2]
        and np.allclose(angles, [2 * 25 * 0.133, -25 * 0.133], atol=1e-4)
    )


def the_c_arm_stays_within_its_limits():
    env = NavigationEnv(Task(**{**WIRE.__dict__, "steps": 60, "c_arm_max_deg_per_s": 180.0}), c_arm=True)
    env.reset(seed=1)
    for _ in range(8):
        seen = env.step(np.array(REST + [1.0, -1.0, 0.0]))[0]
    return np.allclose(seen[-7:-5], [1.0, -1.0])


def seeds_reproduce_with_1_2_and_4_threads():
    ranges = Randomise(heart_rate_per_min=(50, 120), primary_deg=(-20, 20))
    more = {"contrast": True, "c_arm": True, "observation": MIX, "size": 64, "randomise": ranges}
    seen = [played(NavigationVectorEnv(3, CATHETER, threads=threads, **more)) for threads in (1, 2, 4)]
    return all(same(a, b) for other in seen[1:] for a, b in zip(seen[0], other))


def a_snapshot_keeps_medium_view_and_held_picture():
    more = {"contrast": True, "c_arm": True, "observation": MIX, "size": 64}
    env, other = NavigationEnv(CATHETER, **more), NavigationEnv(CATHETER, **more)
    env.reset(seed=4)
    env.step(np.array(FULL + [1.0, 0.0, 1.0]))
    held = env.step(np.array(FULL + [1.0, 1.0, 0.0]))[0]
    snapshot, good = env.snapshot(), True
    actions = [np.array(FULL + [0.0, 1.0, pedal]) for pedal in (0.0, 1.0, 1.0)]
    after = [env.step(action) for action in actions]
    other.reset(seed=99)
    for restored in (env, other):
        good = good and same(restored.restore(snapshot), held)
        again = [restored.step(action) for action in actions]
        good = good and all(same(a[0], b[0]) and a[1:4] == b[1:4] for a, b in zip(after, again))
    return good and bool((after[-1][0]["labels"] & cournand.Label.MEDIUM).any())


def episodes_draw_the_heart_rate():
    long = Task(**{**WIRE.__dict__, "steps": 40})
    plain, fast = NavigationEnv(long), NavigationEnv(long, randomise=Randomise(heart_rate_per_min=(120, 120)))
    beats = []
    for env in (plain, fast):
        env.reset(seed=1)
        phases = []
        for _ in range(30):
            env.step(np.zeros(2))
            phases.append(env.world.read().heart_phase)
        beats.append(np.sum(np.mod(np.diff(phases), 1.0)))
    print("# beats within 29 steps: %.2f at 70 per minute, %.3f at 120" % tuple(beats))
    wrong = [(30, 70), (60, 300), (0, 70)]
    # Both begin with a beat of 70 per minute, and 29 steps are 3.86 s.
    return (
        abs(beats[0] - 3.86 * 70 / 60) < 0.3
        and beats[1] > 1.4 * beats[0]
        and all(refuses(lambda one=one: Randomise(heart_rate_per_min=one)) for one in wrong)
    )


def episodes_draw_the_scene():
    """The second scene is a copy of the first, so that episodes can differ only in the number of their scene."""
    with tempfile.TemporaryDirectory() as folder:
        path = find("scenes", ".scene", "aorta")
        for ending in (".scene", ".bodies"):
            shutil.copy(os.path.splitext(path)[0] + ending, os.path.join(folder, "other" + ending))
        other = os.path.join(folder, "other.scene")
        ranges = Randomise(scenes=("aorta", other))
        seen = [
            played(NavigationVectorEnv(3, WIRE, threads=threads, observation=MIX, size=64, randomise=ranges), 12)
            for threads in (1, 2)
        ]
        good = all(same(a, b) for a, b in zip(*seen))
        env, plain = NavigationEnv(WIRE, randomise=ranges), NavigationEnv(WIRE)
        scenes = []
        for seed in range(8):
            observation, info = env.reset(seed=seed)
            scenes.append(info["scene"])
            good = good and same(observation, plain.reset(seed=seed)[0])
        snapshot = env.snapshot()
        after = env.step(np.array(PUSH))[0]
        env.reset(seed=scenes.index(1 - scenes[-1]))
        env.restore(snapshot)
        return good and set(scenes) == {0, 1} and same(env.step(np.array(PUSH))[0], after)


def wrong_scenes_are_refused():
    return all(
        [
            refuses(lambda: Randomise(scenes="aorta")),
            refuses(lambda: Randomise(scenes=("aorta", "aorta"))),
            refuses(lambda: NavigationEnv(WIRE, randomise=Randomise(scenes=("nowhere",))), cournand.BadFileError),
            refuses(lambda: Task(targets=("nose",), contrast_limit_ml=0.0)),
            refuses(lambda: Task(targets=("nose",), c_arm_max_deg_per_s=float("nan"))),
        ]
    )


tap.run(
    [
        gymnasium_accepts_every_action,
        contrast_medium_flows_as_the_action_says,
        the_syringe_is_empty_after_its_volume,
        a_tool_without_a_lumen_injects_nothing,
        the_c_arm_turns_and_the_pedal_makes_pictures,
        the_c_arm_stays_within_its_limits,
        seeds_reproduce_with_1_2_and_4_threads,
        a_snapshot_keeps_medium_view_and_held_picture,
        episodes_draw_the_heart_rate,
        episodes_draw_the_scene,
        wrong_scenes_are_refused,
    ]
)
