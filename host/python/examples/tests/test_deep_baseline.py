#!/usr/bin/python3
"""Tests the deep baseline (docs/tasks.md): the adapter to Stable-Baselines3 passes on what the environments return;
equal seeds train equal networks; the exported network acts as the trained one. The test needs PyTorch from Debian
(section [tracker] of tools/packages.txt), and therefore Debian's Python. Prints TAP."""

import contextlib
import io
import os
import re
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[3]
sys.path[:0] = [str(HERE.parent), str(ROOT / "tools" / "check"), str(ROOT / "host" / "python" / "tests")]
try:
    import torch
except ImportError as error:
    sys.exit("test_deep_baseline: %s. Remedy: sudo apt-get install python3-torch" % error)

import prepare  # noqa: E402

prepare.enter_deep(os.path.abspath(__file__))

import numpy as np  # noqa: E402
import tap  # noqa: E402
from cournand import BadFileError  # noqa: E402
from cournand.envs import NavigationEnv, NavigationVectorEnv, Task  # noqa: E402
from cournand.tasks import CHALLENGES, Challenge, Network, policy_of, score  # noqa: E402
from cournand.tasks.network import features  # noqa: E402
from deep_baseline import __main__ as program  # noqa: E402
from deep_baseline.curves import read_curve  # noqa: E402
from deep_baseline.demonstrations import demonstrate, imitate  # noqa: E402
from deep_baseline.train import Course, exported, learner, put, scenes_of, train  # noqa: E402
from deep_baseline.worlds import LAGS, Worlds  # noqa: E402
from stable_baselines3.common.env_checker import check_env  # noqa: E402

NEAR = Task(targets=("right iliac artery",), target_part=(0.3, 0.6), steps=30)
SHORT = Challenge("short", "a short push in the shipped iliac artery", NEAR, "own")
TINY = Course(steps=64, worlds=4, rollout=16, batch=32, epochs=2)
FOLDER = tempfile.TemporaryDirectory()


def path(name):
    return os.path.join(FOLDER.name, name)


def actions(steps, count=3):
    return np.random.default_rng(3).uniform(-0.2, 1.0, (steps, count, 2)).astype(np.float32)


def played(worlds, given, seed=5):
    """Returns what the adapter returns for these actions: first observations, then a list of steps."""
    worlds.seed(seed)
    return worlds.reset(), [worlds.step(action) for action in given]


def said(*words):
    """Runs a command of the program, and returns its exit code and its output."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        try:
            code = program.main([str(word) for word in words])
        except SystemExit as ended:
            code = ended.code
    return code, printed.getvalue()


def weights_of(network):
    return np.concatenate([one.ravel() for layer in network.layers for one in layer])


# --- the adapter ---


def stable_baselines3_accepts_the_single_environment():
    check_env(NavigationEnv(NEAR), warn=False)
    return True


def the_worlds_are_those_of_the_vector_environment():
    given = actions(40)
    envs = NavigationVectorEnv(3, NEAR, autoreset_mode="SameStep")
    first, _ = envs.reset(seed=5)
    begun, steps = played(Worlds(NEAR, ["aorta"], 3), given)
    width = features(first).shape[1]
    good = np.array_equal(begun[:, :width], features(first))
    for action, (seen, rewards, done, _) in zip(given, steps):
        observations, wanted, terminated, truncated, _ = envs.step(action)
        good = good and np.array_equal(seen[:, :width], features(observations))
        good = good and np.array_equal(rewards, wanted.astype(np.float32))
        good = good and np.array_equal(done, terminated | truncated)
    return good


def a_world_remembers_moments_of_the_same_episode_alone():
    begun, steps = played(Worlds(NEAR, ["aorta"], 3), actions(40))
    width = begun.shape[1] // len(LAGS)
    good, age, past, ends = True, 0, [begun[0, :width]], 0
    for seen, _, done, infos in steps:
        last = infos[0]["terminal_observation"] if done[0] else seen[0]
        past.append(last[:width])
        age += 1
        wanted = np.concatenate([past[max(age - lag, 0)] for lag in LAGS])
        good = good and np.array_equal(last, wanted)
        if done[0]:
            ends, age, past = ends + 1, 0, [seen[0, :width]]
            good = good and np.array_equal(seen[0], np.tile(past[0], len(LAGS)))
    return good and ends >= 1


def an_ended_episode_states_its_rewards_steps_and_success():
    _, steps = played(Worlds(NEAR, ["aorta"], 3), actions(70))
    total, count, good, ends = 0.0, 0, True, []
    for _, rewards, done, infos in steps:
        total, count = total + float(rewards[1]), count + 1
        if done[1]:
            ended = infos[1]["episode"]
            good = good and abs(ended["r"] - total) < 1e-5 and ended["l"] == count
            good = good and infos[1]["TimeLimit.truncated"] == (count == 30 and not infos[1]["is_success"])
            ends.append(infos[1]["is_success"])
            total, count = 0.0, 0
        else:
            good = good and infos[1] == {}
    print("# successes: %s" % ends)
    return good and len(ends) >= 2


def the_reward_for_coming_nearer_is_the_change_of_the_distance():
    """The sum over an episode is the difference of its first and last distances."""
    given = actions(30)
    plain, more = played(Worlds(NEAR, ["aorta"], 3), given), played(
        Worlds(NEAR, ["aorta"], 3, reward_per_nearer_m=10.0), given
    )
    width, worst, ended = plain[0].shape[1] // len(LAGS), 0.0, 0
    for world in range(3):
        first, extra = float(plain[0][world, width - 1]), 0.0
        for one, two in zip(plain[1], more[1]):
            extra += float(two[1][world]) - float(one[1][world])
            if one[2][world]:
                last = float(one[3][world]["terminal_observation"][width - 1])
                worst, ended = max(worst, abs(extra - 10.0 * 0.1 * (first - last))), ended + 1
                break
    print("# at most %.1e apart" % worst)
    return ended == 3 and worst < 1e-7  # float32 rewards; measured 2.9e-8


# --- training ---


def equal_courses_train_equal_networks():
    first = train(SHORT, TINY)[0]
    again = train(SHORT, replace(TINY, threads=2))[0]
    other = train(SHORT, replace(TINY, seed=2))[0]
    same = np.array_equal(weights_of(first), weights_of(again)) and np.array_equal(first.mean, again.mean)
    return same and not np.array_equal(weights_of(first), weights_of(other))


def the_exported_network_acts_as_the_trained_one():
    model, normalised = learner(SHORT, TINY, ["aorta"])
    model.learn(64)
    network, worst = exported(model, normalised, SHORT), 0.0
    for seen in np.random.default_rng(2).normal(size=(50, len(network.mean))).astype(np.float32):
        wanted = model.predict(normalised.normalize_obs(seen), deterministic=True)[0]
        worst = max(worst, float(np.abs(network.action(seen) - wanted).max()))
    print("# at most %.1e apart" % worst)
    return worst < 1e-7  # float32; measured 9.3e-9


def a_trained_network_is_judged_with_the_same_bits_by_1_and_2_threads():
    train(SHORT, TINY)[0].save(path("judged.npz"))
    cards = []
    for threads in (1, 2):
        made = score(SHORT, policy_of(path("judged.npz")), name="judged", episodes=3, threads=threads)
        cards.append({name: value for name, value in made.items() if name != "speed"})
    return cards[0] == cards[1]


def a_training_goes_on_with_an_earlier_network():
    """A model acts as the network that was put into it. The statistics are kept in double precision."""
    earlier = train(SHORT, TINY)[0]
    model, normalised = learner(SHORT, replace(TINY, seed=2), ["aorta"])
    put(earlier, model, normalised)
    now = exported(model, normalised, SHORT)
    worst = float(np.abs(now.scale / earlier.scale - 1.0).max())
    same = np.array_equal(weights_of(now), weights_of(earlier)) and np.array_equal(now.mean, earlier.mean)
    after = train(SHORT, TINY, begin_with=earlier)[0]
    print("# scales at most %.1e apart" % worst)
    try:
        put(replace(earlier, lags=[0]), model, normalised)
        return False
    except ValueError as error:
        good = same and worst < 1e-6 and not np.array_equal(weights_of(after), weights_of(now))
        return good and "sizes" in str(error)


def it_learns_to_push():
    """Without a push at the beginning, the first episodes fail, and the last ones reach their targets."""
    rows = train(SHORT, Course(steps=16_000, rollout=32))[1]
    print("# safe successes: %.2f, then %.2f" % (rows[0][4], rows[-1][4]))
    return rows[0][4] < 0.3 and rows[-1][4] > 0.6


def it_imitates_the_expert():
    model, normalised = learner(SHORT, TINY, ["aorta"])
    seen, wanted, is_good = demonstrate(SHORT, 4, FOLDER.name)
    errors = imitate(model, normalised, seen, wanted, is_good)
    network = exported(model, normalised, SHORT)
    chosen = np.stack([network.action(one) for one in seen[is_good]])
    error = float(np.mean((chosen - wanted[is_good]) ** 2))
    print("# %d moments; mean square %.3f, then %.3f" % (is_good.sum(), errors[0], error))
    return error < 0.2 * errors[0] and seen.shape[0] == len(wanted) == len(is_good)


# --- commands ---


def the_commands_train_judge_and_draw():
    CHALLENGES["short"] = SHORT
    try:
        code, text = said("train", "short", "--steps", 512, "--worlds", 4, "--out", path("short_1.npz"))
        again = said("train", "short", "--steps", 512, "--worlds", 4, "--seed", 2, "--out", path("short_2.npz"))[0]
    finally:
        del CHALLENGES["short"]
    good = code == again == 0 and "512 steps" in text and Network.load(path("short_1.npz")).task == "short"
    curve = read_curve(path("short_1.tsv"))
    good = good and curve["steps"].tolist() == [256.0, 512.0] and (curve["safe_success"] <= 1.0).all()
    code, _ = said("curves", path("short_1.tsv"), path("short_2.tsv"), "--out", path("curves.png"))
    return good and code == 0 and Path(path("curves.png")).read_bytes()[:4] == b"\x89PNG"


def the_commands_of_the_page_are_accepted():
    page = (ROOT / "docs" / "tasks.md").read_text(encoding="utf-8")
    commands = re.findall(r"^ +python -m deep_baseline ([^#\n]*)", page, flags=re.M)
    for words in commands:
        program._parser().parse_args(words.split())
    return len(commands) >= 2


def what_cannot_be_done_is_refused_with_the_remedy():
    code, text = said("train", "iliac", "--anatomies", FOLDER.name, "--out", path("none.npz"))
    good = code == 1 and "Remedy: python -m cournand.anatomies --task iliac" in text
    for content in ("", "steps\n1\n", "no table"):
        Path(path("wrong.tsv")).write_text(content, encoding="utf-8")
        code, text = said("curves", path("wrong.tsv"), "--out", path("none.png"))
        good = good and code == 1 and "Remedy" in text
    try:
        scenes_of(CHALLENGES["arch_variety"], FOLDER.name, 2)
        return False
    except BadFileError as error:
        good = good and "Remedy" in str(error) and "--episodes 2" in str(error)
    return good and not os.path.exists(path("none.npz"))


def wrong_options_are_refused():
    out = ("--out", path("none.npz"))
    codes = [
        said()[0],
        said("train", "nothing", *out)[0],
        said("train", "iliac")[0],
        said("train", "iliac", "--out", "none.txt")[0],
        said("train", "iliac", "--steps", "0", *out)[0],
        said("train", "iliac", "--push", "2", *out)[0],
        said("train", "iliac", "--push", "nan", *out)[0],
        said("curves", "--out", path("none.png"))[0],
    ]
    return set(codes) == {2}


torch.set_num_threads(1)
tap.run(
    [
        stable_baselines3_accepts_the_single_environment,
        the_worlds_are_those_of_the_vector_environment,
        a_world_remembers_moments_of_the_same_episode_alone,
        an_ended_episode_states_its_rewards_steps_and_success,
        the_reward_for_coming_nearer_is_the_change_of_the_distance,
        equal_courses_train_equal_networks,
        the_exported_network_acts_as_the_trained_one,
        a_trained_network_is_judged_with_the_same_bits_by_1_and_2_threads,
        a_training_goes_on_with_an_earlier_network,
        it_learns_to_push,
        it_imitates_the_expert,
        the_commands_train_judge_and_draw,
        the_commands_of_the_page_are_accepted,
        what_cannot_be_done_is_refused_with_the_remedy,
        wrong_options_are_refused,
    ]
)
