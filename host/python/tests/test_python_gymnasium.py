#!/usr/bin/env python3
"""Tests the environments for Gymnasium: Gymnasium's own checks, the ends of episodes, snapshots and domain
randomisation. Equal seeds must give equal results, bit for bit, in a single and in a vector environment, with any
number of threads. Prints TAP."""

import os
import sys
import warnings

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import cournand.envs  # noqa: E402
import cournand.registration  # noqa: E402
import gymnasium  # noqa: E402
import numpy as np  # noqa: E402
from cournand.envs import AORTA, EnvSnapshot, NavigationEnv, NavigationVectorEnv, Randomise, Task  # noqa: E402
from cournand.envs.task import VesselPaths  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402
from env_checks import refuses  # noqa: E402

MIX = ("state", "fluoroscopy", "labels")
SHORT = Task(targets=("right iliac artery",), target_part=(0.5, 0.9), steps=4)
REACHED = Task(targets=("right iliac artery",), target_part=(0.6, 0.8), steps=60, reach_m=0.02)


def same(a, b):
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    return np.array_equal(a, b)


def row(observations, number):
    if isinstance(observations, dict):
        return {key: value[number] for key, value in observations.items()}
    return observations[number]


def actions(env, steps, seed=7):
    space = env.action_space
    space.seed(seed)
    return [space.sample() for _ in range(steps)]


def played(envs, given, seed=11):
    """Returns everything that a vector environment returns for these actions."""
    seen = [envs.reset(seed=seed)[0]]
    for action in given:
        seen += envs.step(action)[:4]
    return seen


def gymnasium_accepts_every_kind_of_environment():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*(not an image|symmetric and normalized|render_modes).*")
        for name in cournand.registration.TASKS:
            check_env(gymnasium.make(name).unwrapped, skip_render_check=True)
        check_env(gymnasium.make("cournand/Aorta-v0", observation=MIX, size=64, action="discrete").unwrapped)
        check_env(gymnasium.make("cournand/Aorta-v0", observation="labels", size=64).unwrapped)
    return True


def gymnasium_makes_the_vector_environment_itself():
    envs = gymnasium.make_vec("cournand/Aorta-v0", num_envs=2, vectorization_mode="vector_entry_point")
    observations, _ = envs.reset(seed=1)
    return isinstance(envs.unwrapped, NavigationVectorEnv) and envs.observation_space.contains(observations)


def seeds_reproduce_with_1_2_and_4_threads():
    seen = []
    for threads in (1, 2, 4):
        envs = NavigationVectorEnv(4, SHORT, threads=threads, observation=MIX, size=64)
        seen.append(played(envs, actions(envs, 7)))
    return all(same(a, b) for other in seen[1:] for a, b in zip(seen[0], other))


def an_environment_of_many_is_the_single_one_with_its_seed():
    envs = NavigationVectorEnv(3, SHORT, observation=MIX, size=64)
    given = actions(envs, 9)
    seen = [envs.reset(seed=11)[0]] + [envs.step(action) for action in given]
    single = NavigationEnv(SHORT, observation=MIX, size=64)
    good = same(row(seen[0], 1), single.reset(seed=12)[0])
    is_done = False
    for action, many in zip(given, seen[1:]):
        if is_done:  # the vector environment has begun the next episode in this step
            good = good and same(row(many[0], 1), single.reset()[0])
            is_done = False
            continue
        observation, reward, terminated, truncated, _ = single.step(action[1])
        is_done = terminated or truncated
        good = good and same(row(many[0], 1), observation) and reward == many[1][1]
        good = good and (terminated, truncated) == (many[2][1], many[3][1])
    return good


def different_seeds_give_different_episodes():
    single = NavigationEnv()
    targets = [tuple(single.reset(seed=seed)[1]["target_m"]) for seed in range(5)]
    targets.append(tuple(single.reset()[1]["target_m"]))
    return len(set(targets)) == 6 and tuple(single.reset(seed=3)[1]["target_m"]) == targets[3]


def an_episode_is_truncated_after_its_steps():
    single = NavigationEnv(SHORT)
    single.reset(seed=1)
    ends = [single.step(np.zeros(2))[2:4] for _ in range(4)]
    return ends == [(False, False)] * 3 + [(False, True)]


def a_push_reaches_the_target_safely():
    single = NavigationEnv(REACHED)
    _, info = single.reset(seed=1)
    path, total, terminated = info["path_m"], 0.0, False
    while not terminated:
        _, reward, terminated, truncated, info = single.step(np.array([1.0, 0.0]))
        total += reward
        if truncated:
            return False
    forced = NavigationEnv(Task(**{**REACHED.__dict__, "force_limit_N": 1e-6}))
    forced.reset(seed=1)
    ended = False
    while not ended:
        _, reward, ended, _, pressed = forced.step(np.array([1.0, 0.0]))
    return (
        info["is_success"]
        and 0 < info["force_peak_N"] <= 2.0
        and info["path_m"] < path
        and total > 0.7
        and pressed["is_reached"]
        and not pressed["is_success"]
        and reward < 0.5
    )


def the_next_episode_begins_by_the_chosen_mode():
    def ends(mode):
        envs = NavigationVectorEnv(2, SHORT, autoreset_mode=mode)
        envs.reset(seed=5)
        zero = np.zeros((2, 2))
        return envs, [envs.step(zero) for _ in range(4)], zero

    envs, seen, zero = ends("NextStep")
    after = envs.step(zero)
    good = envs.metadata["autoreset_mode"].value == "NextStep" and seen[3][3].all() and not after[3].any()
    good = good and (after[1] == 0).all() and list(after[4]["episode"]) == [1, 1]
    first = after[0]
    envs, seen, zero = ends("SameStep")
    last = seen[3]
    good = good and last[3].all() and same(last[0], first) and not same(last[4]["final_obs"][0], last[0][0])
    good = good and last[4]["final_info"]["episode"][1] == 0 and last[4]["episode"][1] == 1
    envs, seen, zero = ends("Disabled")
    try:
        envs.step(zero)
        good = False
    except RuntimeError:
        pass
    observations, _ = envs.reset(options={"reset_mask": np.array([True, True])})
    return good and same(observations, first)


def a_mask_begins_some_environments_again():
    envs = NavigationVectorEnv(3, SHORT)
    before, _ = envs.reset(seed=5)
    moved = envs.step(np.ones((3, 2)))[0]
    after, infos = envs.reset(seed=5, options={"reset_mask": np.array([False, True, False])})
    return same(after[[0, 2]], moved[[0, 2]]) and same(after[1], before[1]) and list(infos["_episode"]) == [0, 1, 0]


def a_snapshot_branches_bit_for_bit():
    single = NavigationEnv(AORTA, observation=("state", "fluoroscopy"), size=64)
    single.reset(seed=4)
    single.step(np.array([1.0, 0.5]))
    snapshot = single.snapshot()
    one = [single.step(np.array([1.0, -0.5])) for _ in range(3)]
    other = NavigationEnv(AORTA, observation=("state", "fluoroscopy"), size=64)
    other.reset(seed=99)
    other.restore(snapshot)
    two = [other.step(np.array([1.0, -0.5])) for _ in range(3)]
    envs = NavigationVectorEnv(2, AORTA, observation=("state", "fluoroscopy"), size=64)
    envs.reset(seed=1)
    envs.restore(1, snapshot)
    three = [envs.step(np.array([[0.0, 0.0], [1.0, -0.5]])) for _ in range(3)]
    return all(
        same(a[0], b[0]) and a[1] == b[1] == c[1][1] and same(a[0], row(c[0], 1)) for a, b, c in zip(one, two, three)
    )


def a_restored_environment_has_the_observation_of_the_snapshot():
    task = Task(**{**AORTA.__dict__, "ticks": 10, "contact_ticks": 7})  # steps and samples at different ticks
    single, draw, good, forces = NavigationEnv(task), np.random.default_rng(5), True, 0
    single.reset(seed=4)
    for _ in range(120):
        single.step(np.array([1.0, 0.5]))
    for _ in range(30):
        seen = single.step(np.array([1.0, 0.5]))
        forces += single.world.read().wall_force_N > 0
        snapshot, action = single.snapshot(), draw.uniform(-1.0, 1.0, 2)
        after = single.step(action)
        good = good and same(single.restore(snapshot), seen[0])
        again = single.step(action)
        good = good and same(again[0], after[0]) and again[1:4] == after[1:4]
    return good and forces > 10


def a_snapshot_of_an_ended_episode_has_ended():
    one = NavigationEnv(SHORT)
    one.reset(seed=5)
    for _ in range(4):
        one.step(np.zeros(2))
    envs = NavigationVectorEnv(2, SHORT)
    envs.reset(seed=5)
    for _ in range(4):
        envs.step(np.zeros((2, 2)))
    ended = envs.snapshot(0)
    first = envs.step(np.zeros((2, 2)))
    other = NavigationVectorEnv(2, SHORT)
    good = True
    for snapshot in (ended, one.snapshot()):
        other.reset(seed=99)
        other.restore(0, snapshot)
        seen = other.step(np.ones((2, 2)))
        good = good and snapshot.is_done and same(seen[0][0], first[0][0]) and seen[1][0] == 0
        good = good and not seen[3][0] and seen[4]["episode"][0] == 1
    return good


def a_refusal_changes_no_episode():
    envs, other = NavigationVectorEnv(2, SHORT), NavigationVectorEnv(2, SHORT)
    unbegun = NavigationVectorEnv(2, SHORT)
    good = refuses(lambda: unbegun.restore(0, EnvSnapshot(b"", None)), RuntimeError)
    good = good and refuses(lambda: unbegun.snapshot(0), RuntimeError)
    good = good and refuses(lambda: unbegun.step(np.zeros((2, 2))), RuntimeError)
    for one in (envs, other):
        one.reset(seed=5)
        one.step(np.ones((2, 2)))
    bad = [-3, 2**63, 2**32, 2**32 - 1, [1, -1], [1, 2**32], [1], [0, 2, 3]]  # 2**32 - 1 leaves none for the second
    good = good and all(refuses(lambda seed=seed: envs.reset(seed=seed)) for seed in bad)
    good = good and refuses(lambda: envs.reset(seed=[1, 0.5]), TypeError)
    nan = np.ones((2, 2))
    nan[1, 0] = np.nan
    good = good and refuses(lambda: envs.step(nan)) and [one.tick for one in envs._fleet.worlds] == [133, 133]
    good = good and refuses(lambda: envs.restore(1, EnvSnapshot(b"", envs.snapshot(0).episode)))
    stepped = [one.step(np.ones((2, 2))) for one in (envs, other)]
    good = good and same(stepped[0][0], stepped[1][0]) and [one.step for one in envs._fleet.episodes] == [2, 2]
    again = [one.reset() for one in (envs, other)]
    return good and same(again[0][0], again[1][0]) and list(again[0][1]["episode"]) == [1, 1]


def an_environment_whose_tools_are_refused_keeps_its_episode():
    varied = NavigationVectorEnv(2, SHORT, randomise=Randomise(mass=(0.9, 1.1)))
    before = varied.reset(seed=5)[0]
    varied._fleet.randomise = Randomise(mass=(100.0, 100.0))
    good = refuses(lambda: varied.reset()) and [one.number for one in varied._fleet.episodes] == [0, 0]
    varied._fleet.randomise = Randomise(mass=(0.9, 1.1))
    return good and same(varied.reset(seed=5)[0], before)


def the_largest_seed_is_one_of_its_own():
    single = NavigationEnv(SHORT)
    largest = single.reset(seed=2**32 - 1)[1]
    refused = refuses(lambda: single.reset(seed=2**32))
    return refused and largest["seed"] == single.snapshot().episode.seed == 2**32 - 1


def actions_have_the_shape_and_the_type_of_their_space():
    several, discrete = Task(**{**SHORT.__dict__, "tools": ("j_wire", "terumo_5f")}), "discrete"
    made = [NavigationEnv(SHORT), NavigationEnv(SHORT, action=discrete), NavigationEnv(several, action=discrete)]
    made += [NavigationVectorEnv(2, SHORT), NavigationVectorEnv(2, SHORT, action=discrete)]
    right = [np.zeros(2), 1, np.array([1, 2]), np.zeros((2, 2)), np.array([1, 2])]
    shapes = [(2, 1), (1,), (1, 2), (4,), (2, 1)]
    good = True
    for env, action, shape in zip(made, right, shapes):
        env.reset(seed=1)
        good = good and refuses(lambda: env.step(np.zeros(shape, dtype=env.action_space.dtype)))
        good = good and refuses(lambda: env.step(np.zeros(np.shape(action), dtype=bool)), TypeError)
        if np.asarray(action).dtype.kind == "i":
            good = good and refuses(lambda: env.step(np.asarray(action, dtype=np.float32)), TypeError)
        env.step(action)
    return good


def a_picture_is_rendered_on_request():
    single = NavigationEnv(SHORT, render_mode="rgb_array")
    single.reset(seed=1)
    picture = single.render()
    single.step(np.array([1.0, 0.0]))
    return (
        picture.shape == (512, 512, 3)
        and picture.dtype == np.uint8
        and picture.std() > 5
        and not same(picture, single.render())
        and NavigationEnv(SHORT).render() is None
    )


def observations_have_memory_of_their_own():
    envs = NavigationVectorEnv(2, SHORT, observation=MIX, size=64)
    first, _ = envs.reset(seed=1)
    kept = {key: value.copy() for key, value in first.items()}
    envs.step(np.ones((2, 2)))
    return same(first, kept)


def randomised_tools_and_views_reproduce():
    ranges = Randomise(bend_stiffness=(0.5, 2.0), friction=(0.5, 2.0), primary_deg=(-30, 30), dose=(0.2, 2.0))
    envs = NavigationVectorEnv(2, SHORT, observation=MIX, size=64, randomise=ranges)
    plain = NavigationVectorEnv(2, SHORT, observation=MIX, size=64)
    given = actions(envs, 6)
    one, two, three = played(envs, given), played(envs, given), played(plain, given)
    single = NavigationEnv(SHORT, randomise=ranges)
    single.reset(seed=1)
    single.step(np.ones(2))
    snapshot = single.snapshot()
    after = single.step(np.ones(2))[0]
    single.reset(seed=2)
    single.restore(snapshot)
    return (
        all(same(a, b) for a, b in zip(one, two))
        and not same(one[-4]["state"], three[-4]["state"])
        and not same(one[0]["fluoroscopy"], three[0]["fluoroscopy"])
        and same(single.step(np.ones(2))[0], after)
    )


def paths_go_through_the_tree_of_vessels():
    scene = cournand.Scene("aorta")
    paths = VesselPaths(scene)
    left, right = scene.find_vessel("left iliac artery"), scene.find_vessel("right iliac artery")
    descending = scene.find_vessel("descending aorta")
    exits, beyond = paths.towards(left, 0.1)
    over = abs(0.05 - exits[right]) + beyond[right]  # back to the bifurcation, then into the other artery
    above = abs(scene.vessels[descending].length_m - 0.1 - exits[descending]) + beyond[descending]
    return abs(over - 0.15) < 0.01 and abs(above - 0.2) < 0.01 and abs(exits[left] - 0.1) < 1e-12


def wrong_arguments_are_refused():
    single = NavigationEnv(SHORT, action="discrete")
    envs = NavigationVectorEnv(2, SHORT)
    return all(
        [
            refuses(lambda: NavigationEnv(SHORT, observation="sound")),
            refuses(lambda: NavigationEnv(SHORT, observation=())),
            refuses(lambda: NavigationEnv("heart")),
            refuses(lambda: NavigationEnv(SHORT, action="wish")),
            refuses(lambda: NavigationEnv(SHORT, size=65)),
            refuses(lambda: NavigationEnv(SHORT, render_mode="human")),
            refuses(lambda: NavigationVectorEnv(0, SHORT)),
            refuses(lambda: Task(targets=())),
            refuses(lambda: Task(targets=("nose",), contact_ticks=0)),
            refuses(lambda: Task(targets=("nose",), ticks=10)),
            refuses(lambda: Task(targets=("nose",), force_limit_N=0.0)),
            refuses(lambda: Task(targets=("nose",), force_limit_N=float("nan"))),
            refuses(lambda: Randomise(mass=(2.0, 1.0))),
            refuses(lambda: NavigationEnv(Task(targets=("nose",)))),
            refuses(lambda: single.step(0), RuntimeError),
            refuses(lambda: (single.reset(seed=1), single.step(7))),
            refuses(lambda: (envs.reset(seed=1), envs.step(np.full((2, 2), np.nan)))),
            refuses(lambda: envs.reset(seed=[1])),
        ]
    )


tap.run(
    [
        gymnasium_accepts_every_kind_of_environment,
        gymnasium_makes_the_vector_environment_itself,
        seeds_reproduce_with_1_2_and_4_threads,
        an_environment_of_many_is_the_single_one_with_its_seed,
        different_seeds_give_different_episodes,
        an_episode_is_truncated_after_its_steps,
        a_push_reaches_the_target_safely,
        the_next_episode_begins_by_the_chosen_mode,
        a_mask_begins_some_environments_again,
        a_snapshot_branches_bit_for_bit,
        a_restored_environment_has_the_observation_of_the_snapshot,
        a_snapshot_of_an_ended_episode_has_ended,
        a_refusal_changes_no_episode,
        an_environment_whose_tools_are_refused_keeps_its_episode,
        the_largest_seed_is_one_of_its_own,
        actions_have_the_shape_and_the_type_of_their_space,
        a_picture_is_rendered_on_request,
        observations_have_memory_of_their_own,
        randomised_tools_and_views_reproduce,
        paths_go_through_the_tree_of_vessels,
        wrong_arguments_are_refused,
    ]
)
