#!/usr/bin/env python3
"""Tests the environments of the named tasks (docs/gymnasium.md, "Environments of the named tasks"): every task of the
catalogue has a name, Gymnasium accepts its environments, and a folder without scenes is refused with the remedy. Copies
of the shipped scene stand for drawn anatomies. Prints TAP."""

import os
import sys
import tempfile
import warnings

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import cournand.envs  # noqa: E402
import cournand.registration  # noqa: E402
import gymnasium  # noqa: E402
import numpy as np  # noqa: E402
from cournand import BadFileError  # noqa: E402
from cournand.data import find  # noqa: E402
from cournand.envs import NavigationEnv, NavigationVectorEnv, Randomise  # noqa: E402
from cournand.tasks import CHALLENGES  # noqa: E402
from cournand.tasks.environments import scenes_of  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402
import tree  # noqa: E402

NAMES = cournand.registration.CHALLENGES
FOLDER = tempfile.TemporaryDirectory()


def folder_with(*seeds):
    """Returns a folder with the shipped scene as the scene of each of these seeds."""
    folder = tempfile.mkdtemp(dir=FOLDER.name)
    shipped = os.path.splitext(find("scenes", ".scene", "aorta"))[0]
    for seed in seeds:
        for ending in (".scene", ".bodies"):
            os.symlink(shipped + ending, os.path.join(folder, "aorta-%d%s" % (seed, ending)))
    return folder


SCENES = folder_with(*range(8))


def text_of(call, kind):
    """Returns the text of the exception that the call raises; "" if it raises none."""
    try:
        call()
    except kind as error:
        return str(error)
    return ""


def every_task_has_a_name_with_its_version():
    def name(challenge):
        return "cournand/%s-v%d" % ("".join(w.capitalize() for w in challenge.name.split("_")), challenge.version)

    return {name(one): one.name for one in CHALLENGES.values()} == NAMES


def gymnasium_accepts_the_environment_of_every_task():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*(not an image|symmetric and normalized|render_modes).*")
        for name in NAMES:
            env = gymnasium.make(name, scenes=SCENES)
            check_env(env.unwrapped, skip_render_check=True)
            task = CHALLENGES[NAMES[name]].task
            if env.unwrapped.task.targets != task.targets or env.unwrapped.task.steps != task.steps:
                return False
    return len(NAMES) == len(CHALLENGES)


def gymnasium_makes_the_vector_environments():
    for name in NAMES:
        more = {"scenes": SCENES, "threads": 2, "vectorization_mode": "vector_entry_point"}
        envs = gymnasium.make_vec(name, num_envs=2, **more)
        observations, _ = envs.reset(seed=1)
        good = isinstance(envs.unwrapped, NavigationVectorEnv) and envs.observation_space.contains(observations)
        if not good or envs.step(envs.action_space.sample())[1].shape != (2,):
            return False
    return True


def an_environment_of_many_is_the_single_one_with_its_seed():
    name = "cournand/Iliac-v1"
    envs = gymnasium.make_vec(name, num_envs=3, scenes=SCENES, vectorization_mode="vector_entry_point")
    one = gymnasium.make(name, scenes=SCENES)
    many, infos = envs.reset(seed=20)
    alone, info = one.reset(seed=21)
    good = np.array_equal(many[1], alone) and infos["scene"][1] == info["scene"]
    for number in range(3):
        action = np.full(2, 0.5 - 0.3 * number, dtype=np.float32)
        good = good and np.array_equal(envs.step(np.stack([action] * 3))[0][1], one.step(action)[0])
    return good


def training_and_judging_have_no_scene_in_common():
    for challenge in CHALLENGES.values():
        train, judge = (scenes_of(challenge, SCENES, split) for split in ("train", "judge"))
        if set(train) & set(judge) or len(train) != (4 if challenge.is_drawn else 0) or len(judge) != len(train):
            return False
    return scenes_of(CHALLENGES["iliac"], SCENES) == scenes_of(CHALLENGES["iliac"], SCENES, "train")


def a_folder_without_scenes_is_refused_with_the_remedy():
    empty, odd = folder_with(), folder_with(1, 3, 5, 7)
    texts = []
    for name, task in NAMES.items():
        for scenes in (empty, odd) if CHALLENGES[task].is_drawn else ():
            text = text_of(lambda: gymnasium.make(name, scenes=scenes), BadFileError)
            texts.append("Remedy: python -m cournand.anatomies --task %s" % task in text and "--out " + scenes in text)
    print("# %s" % text_of(lambda: gymnasium.make("cournand/ArchVariety-v1", scenes=empty), BadFileError))
    return len(texts) >= 10 and all(texts)


def wrong_arguments_are_refused():
    make, mine = gymnasium.make, Randomise(scenes=("aorta",))
    return (
        "split" in text_of(lambda: make("cournand/Iliac-v1", scenes=SCENES, split="test"), ValueError)
        and "scenes" in text_of(lambda: make("cournand/Iliac-v1", scenes=SCENES, randomise=mine), ValueError)
        and "observation" in text_of(lambda: make("cournand/ShippedArch-v1", observation="sound"), ValueError)
    )


def options_of_the_environment_are_passed_on():
    ranges = Randomise(friction=(0.5, 2.0))
    env = gymnasium.make("cournand/Iliac-v1", scenes=SCENES, split="judge", action="discrete", randomise=ranges)
    env.reset(seed=4)
    scenes = env.unwrapped._fleet.randomise.scenes
    return isinstance(env.unwrapped, NavigationEnv) and env.action_space.n == 7 and scenes[0].endswith("aorta-1.scene")


def the_page_lists_every_environment():
    page = tree.read("docs/gymnasium.md")
    names = {**cournand.registration.TASKS, **NAMES}
    missing = [name for name in names if "`%s`" % name not in page]
    print("".join("# docs/gymnasium.md does not name %s\n" % name for name in missing), end="")
    return not missing


tap.run(
    [
        every_task_has_a_name_with_its_version,
        gymnasium_accepts_the_environment_of_every_task,
        gymnasium_makes_the_vector_environments,
        an_environment_of_many_is_the_single_one_with_its_seed,
        training_and_judging_have_no_scene_in_common,
        a_folder_without_scenes_is_refused_with_the_remedy,
        wrong_arguments_are_refused,
        options_of_the_environment_are_passed_on,
        the_page_lists_every_environment,
    ]
)
