#!/usr/bin/env python3
"""Tests the named tasks of docs/tasks.md: fixed seeds; score cards with the same bits for any number of threads; a
success that a large force makes unsafe; policies by name, module and file; anatomies that are complete or absent.
Prints TAP."""

import contextlib
import io
import json
import os
import re
import shutil
import stat
import subprocess
import sys
import tempfile
from dataclasses import replace

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import numpy as np  # noqa: E402
from cournand import BadFileError, anatomies, judge, train  # noqa: E402
from cournand.data import find  # noqa: E402
from cournand.envs import Exchange, Move, NavigationEnv, NavigationVectorEnv, Task  # noqa: E402
from cournand.tasks import CHALLENGES, Challenge, Linear, card, expert, policy_of, score, table  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402
import tree  # noqa: E402

NEAR = Task(targets=("right iliac artery",), target_part=(0.5, 0.6), steps=40)
SHORT = Challenge("short", "a short push in the shipped iliac artery", NEAR, "own")


def refusal(call, kind=ValueError):
    """Returns the text of a refusal; "" if there is none."""
    try:
        call()
    except kind as error:
        return str(error)
    return ""


def said(main, *words):
    """Calls a command, and returns its exit code and its output."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        try:
            code = main(list(words))
        except SystemExit as ended:
            code = ended.code
    return code, out.getvalue()


def played(policy, challenge=SHORT, threads=1, episodes=3):
    made = score(challenge, policy_of(policy), name=policy, episodes=episodes, threads=threads)
    return {name: value for name, value in made.items() if name != "speed"}


def training_and_judging_have_no_seed_in_common():
    good = True
    for challenge in CHALLENGES.values():
        lists = [challenge.episodes(split, 60) for split in ("train", "judge")]
        seeds = [{one.seed for one in each} for each in lists]
        drawn = [{one.anatomy for one in each} for each in lists]
        good = good and not seeds[0] & seeds[1] and len(seeds[0]) == len(seeds[1]) == 60
        if challenge.is_drawn:
            good = good and not drawn[0] & drawn[1]
            good = good and all(one % 2 == odd for odd in (0, 1) for one in drawn[odd])
            good = good and all(drawn[odd] <= set(challenge.anatomies(("train", "judge")[odd], 60)) for odd in (0, 1))
    return good and len(CHALLENGES["arch_variety"].anatomies("judge", 60)) == 60


def seeds_follow_the_chain_of_steve_bench():
    random = np.random.default_rng(5)
    first, second = random.integers(0, 2**31), random.integers(0, 2**31)
    always_new, pooled = CHALLENGES["arch_variety"].episode(5), CHALLENGES["iliac"].episode(5)
    return always_new[1:] == (first, second) and pooled[1:] == (first % 8, second)


def a_card_has_the_same_bits_with_1_and_2_threads():
    return all(played(policy) == played(policy, threads=2) for policy in ("random", "expert"))


def a_random_policy_is_reproducible_and_differs_between_episodes():
    one, again = played("random"), played("random")
    return one == again and len({row["hash"] for row in one["episodes"]}) == 3


def a_force_above_the_limit_makes_a_success_unsafe():
    """With a force limit of nearly 0 N, the same pushes must reach the same targets in the same steps, but no success
    is safe."""
    strict = replace(SHORT, task=replace(NEAR, force_limit_N=1e-6))
    free, limited = played("push"), played("push", strict)
    print("# success %.2f, safe %.2f" % (limited["summary"]["success"], limited["summary"]["safe_success"]))
    return (
        free["summary"]["success"] == free["summary"]["safe_success"] == 1.0
        and limited["summary"]["success"] == 1.0
        and limited["summary"]["safe_success"] == 0.0
        and [row["steps"] for row in free["episodes"]] == [row["steps"] for row in limited["episodes"]]
    )


def a_resting_policy_goes_nowhere():
    """The tip of the J wire only curls up into its J shape, which the introducer had straightened; this moves the tip
    by 8 mm."""
    figures = played("rest")["summary"]
    return figures["success"] == 0.0 and figures["steps_median"] == 40 and figures["tip_travel_median_m"] < 0.025


def the_expert_reaches_an_easy_target_safely():
    figures = played("expert")["summary"]
    print("# safe success %.2f in %.0f steps" % (figures["safe_success"], figures["steps_median"]))
    return figures["safe_success"] == 1.0


def the_expert_turns_the_bend_towards_the_target():
    """The tip points along x and bends towards y: for a target on the side of z the angle is a right angle, and for one
    on the side of y it is 0."""
    shape = np.array([[0.004, 0.0004, 0.0], [0.002, 0.0, 0.0], [0.0, 0.0, 0.0]])
    right = expert.bend_angle(shape - (0.004, 0.0004, 0.02))
    none = expert.bend_angle(shape - (0.004, 0.02, 0.0))
    return abs(right - np.pi / 2) < 0.1 and abs(none) < 1e-6


def an_approach_by_one_move_is_the_same_as_its_length():
    start_m = NavigationEnv(NEAR).world.scene.start_m
    plain = NavigationEnv(replace(NEAR, approach_m=0.03))
    moved = NavigationEnv(replace(NEAR, approach=(Move(0, start_m + 0.03),)))
    begun = [env.reset(seed=5)[0] for env in (plain, moved)]
    print("# inserted %.4f m" % moved.world.read().inserted_m[0])
    return plain.world.hash() == moved.world.hash() and np.array_equal(*begun)


def an_approach_exchanges_a_tool():
    """The hand lags behind by some millimetres at most, as its grip is elastic."""
    approach = (Move(0, 0.1, 0.1), Move(0, -0.005, 0.1), Exchange(0, "terumo_stiff_angled"), Move(0, 0.02))
    task = replace(NEAR, tools=("terumo_stiff_angled",), approach=approach, approach_tools=("j_wire",))
    envs = NavigationVectorEnv(2, task, threads=2)
    envs.reset(seed=[1, 2])
    readings = [world.read() for world in envs._fleet.worlds]
    print("# inserted %.4f m" % readings[0].inserted_m[0])
    return all(read.line == (1,) and abs(read.inserted_m[0] - 0.02) < 0.005 for read in readings)


def wrong_approaches_are_refused():
    texts = [
        refusal(lambda: replace(NEAR, approach_m=0.1, approach=(Move(0, 0.1),))),
        refusal(lambda: replace(NEAR, approach_tools=("terumo_5f",))),
        refusal(lambda: replace(NEAR, approach=(Move(1, 0.1),))),
        refusal(lambda: replace(NEAR, approach=(Move(0, 3.0),))),
        refusal(lambda: replace(NEAR, approach=(Move(0, 0.1, 0.0),))),
        refusal(lambda: replace(NEAR, approach=(Exchange(0, "terumo_5f"),))),
        refusal(lambda: replace(NEAR, approach=(Move(0, 0.1),), approach_tools=("terumo_5f",))),
        refusal(lambda: replace(NEAR, approach=("push",))),
    ]
    print("# %s" % texts[-2])
    return all("approach" in text for text in texts)


def a_card_is_written_read_and_made_a_table():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "card.json")
        made = score(SHORT, policy_of("push"), name="push", episodes=2)
        card.write(made, path)
        cut = os.path.join(folder, "cut.json")
        with open(cut, "w", encoding="utf-8") as file:
            file.write("{")
        refused = refusal(lambda: card.read(cut), BadFileError)
        code, text = said(judge.main, "--table", path)
        return card.read(path) == made and code == 0 and "| `short` v1 | push | 2 | 100 % |" in text and cut in refused


def the_rows_of_the_page_are_those_of_its_cards():
    folder = os.path.join(prepare.ROOT, "docs", "cards")
    page, names, good = tree.read("docs/tasks.md"), sorted(os.listdir(folder)), True
    for name in names:
        made = card.read(os.path.join(folder, name))
        row = table([made]).splitlines()[-1]
        is_current = made["version"] == CHALLENGES[made["task"]].version and made["split"] == "judge"
        if row not in page or not is_current:
            print("# docs/cards/%s: docs/tasks.md has not the row %s, or the card is of an old version" % (name, row))
            good = False
    return good and page.count("| `") >= len(names) > 5


def the_commands_of_the_page_are_accepted():
    parsers = {"judge": judge._arguments, "train": train._arguments, "anatomies": anatomies._arguments}
    commands = re.findall(r"^ +python -m cournand\.(\w+) ([^#\n]*)", tree.read("docs/tasks.md"), flags=re.M)
    for program, words in commands:
        parsers[program](words.split())
    return len(commands) >= 6


def a_trained_policy_is_reproducible_and_judged_from_its_file():
    settings = train.Settings(directions=2, kept=1, episodes=4)
    short = replace(SHORT, task=replace(NEAR, steps=8))
    with tempfile.TemporaryDirectory() as folder:
        made = []
        for threads in (1, 2):
            search = train.Search(short, settings, threads=threads)
            for _ in range(2):
                search.iterate()
            made.append(search)
        path = os.path.join(folder, "policy.npz")
        made[0].policy().save(path)
        same = np.array_equal(made[0].weights, made[1].weights) and made[0].curve == made[1].curve
        width = NavigationEnv(NEAR).observation_space.shape[0]
        two = Linear(np.zeros((4, width + 1)), np.zeros(width), np.ones(width), "two", 1)
        refused = refusal(lambda: two.make(SHORT, SHORT.episode(0)))
        return same and np.any(made[0].weights) and played(path, short) == played(path, short) and "actions" in refused


def broken_policy_files_are_refused():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "policy.npz")
        Linear(np.zeros((2, 21)), np.zeros(20), np.ones(20), "iliac", 1).save(path)
        whole = open(path, "rb").read()
        texts = [refusal(lambda: Linear.load(os.path.join(folder, "none.npz")), BadFileError)]
        for wrong in (b"", whole[: len(whole) // 2], b"PK" + bytes(100)):
            with open(path, "wb") as file:
                file.write(wrong)
            texts.append(refusal(lambda: Linear.load(path), BadFileError))
        Linear(np.full((2, 21), np.nan), np.zeros(20), np.ones(20), "iliac", 1).save(path)
        texts.append(refusal(lambda: Linear.load(path), BadFileError))
        return all("Remedy" in text for text in texts)


def wrong_calls_are_refused_with_text():
    with tempfile.TemporaryDirectory() as folder:
        nowhere = said(judge.main, "iliac", "--anatomies", folder, "--policy", "push")
        texts = [
            refusal(lambda: policy_of("pushing")),
            refusal(lambda: policy_of("no_such_module:maker")),
            refusal(lambda: policy_of("math:pi")),
            refusal(lambda: score(SHORT, policy_of("rest"), name="rest", episodes=0)),
            refusal(lambda: SHORT.episodes("test", 1)),
            refusal(lambda: replace(SHORT, pool=3)),
            refusal(lambda: list(anatomies.make([-1], folder))),
            refusal(lambda: list(anatomies.make([1], folder, kind="lung"))),
            refusal(lambda: list(anatomies.make([1], folder, programs=folder)), BadFileError),
        ]
        codes = [
            said(judge.main, "nothing")[0],
            said(judge.main)[0],
            said(judge.main, "iliac", "--episodes", "0")[0],
            said(train.main, "iliac", "--out", "policy.txt")[0],
            said(anatomies.main, "--split", "judge")[0],
            said(anatomies.main, "--first", "-1")[0],
            said(anatomies.main, "--task", "iliac", "--bodies")[0],
            said(anatomies.main, "--task", "iliac", "--kind", "heart")[0],
            said(anatomies.main, "--kind", "lung")[0],
        ]
        print("# %s" % nowhere[1].strip(), codes)
        remedy = "python -m cournand.anatomies --task iliac --out " + folder
        return nowhere[0] == 1 and remedy in nowhere[1] and all(len(text) > 10 for text in texts) and set(codes) == {2}


def programs_of(folder, bake_words):
    """Writes two replacement programs into a folder: an `anatomy` that draws nothing, and a `bake` that copies the
    shipped scene."""
    scene = os.path.splitext(find("scenes", ".scene", "aorta"))[0]
    texts = {
        "anatomy": '#!/bin/sh\nfor last; do :; done\nmkdir -p "$last"\necho "$1" "$3" "$4" >>"%s/drawn"\n' % folder,
        "bake": '#!/bin/sh\nout=${3%%.scene}\ncp "%s.bodies" "$out.bodies"\n%s\ncp "%s.scene" "$3"\n'
        % (scene, bake_words, scene),
    }
    for name, text in texts.items():
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(os.path.join(folder, name), stat.S_IRWXU)


def a_scene_is_complete_or_absent_and_made_once():
    """Scripts that take no time replace the programs, because the test checks only the code that calls them."""
    with tempfile.TemporaryDirectory() as folder:
        programs, out = os.path.join(folder, "programs"), os.path.join(folder, "scenes")
        os.mkdir(programs)
        programs_of(programs, "exit 3")  # fails after the bodies
        failed = refusal(lambda: list(anatomies.make([4], out, programs=programs)), BadFileError)
        left = os.listdir(out)
        programs_of(programs, "")
        os.remove(os.path.join(programs, "drawn"))
        first = said(anatomies.main, "--count", "2", "--first", "4", "--out", out, "--programs", programs)
        os.remove(os.path.join(out, "aorta-5.scene"))
        again = said(anatomies.main, "--count", "3", "--first", "4", "--out", out, "--programs", programs)
        bodies = said(anatomies.main, "--count", "1", "--bodies", "--out", out, "--programs", programs)
        said(anatomies.main, "--count", "1", "--kind", "heart", "--out", out, "--programs", programs)
        drawn = sorted(open(os.path.join(programs, "drawn"), encoding="utf-8").read().splitlines())
        names = sorted(os.listdir(out))
        opened = NavigationEnv(replace(NEAR, scene=os.path.join(out, "aorta-6.scene"))).reset(seed=1)[1]["path_m"] > 0
    expected = ["aorta-0-bodies", "aorta-4", "aorta-5", "aorta-6", "heart-0"]
    return (
        "exit code 3" in failed
        and left == []
        and first[0] == again[0] == bodies[0] == 0
        and drawn
        == ["aorta 0 --quiet", *("aorta %d --no-bodies" % seed for seed in (4, 5, 5, 6)), "heart 0 --no-bodies"]
        and names == ["%s.%s" % (name, end) for name in expected for end in ("bodies", "scene")]
        and opened
    )


def a_killed_run_is_continued():
    """If SIGKILL comes while `bake` runs, there is no scene with the final name, and the next run makes it."""
    with tempfile.TemporaryDirectory() as folder:
        programs, out = os.path.join(folder, "programs"), os.path.join(folder, "scenes")
        os.mkdir(programs)
        programs_of(programs, "kill -9 $PPID")  # the Python program that waits for this script
        words = ["-m", "cournand.anatomies", "--count", "1", "--out", out, "--programs", programs]
        killed = subprocess.run([sys.executable, *words], check=False, capture_output=True).returncode
        # The script goes on after its parent's death, and writes into the hidden folder of the work.
        before = [name for name in os.listdir(out) if not name.startswith(".")]
        programs_of(programs, "")
        code = subprocess.run([sys.executable, *words], check=False, capture_output=True).returncode
        made = sorted(name for name in os.listdir(out) if not name.startswith("."))
        shutil.rmtree(out, ignore_errors=True)
    return killed == -9 and before == [] and code == 0 and made == ["aorta-0.bodies", "aorta-0.scene"]


def a_policy_of_a_module_is_judged():
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "mine_of_test.py"), "w", encoding="utf-8") as file:
            file.write("def half(challenge, episode):\n    return lambda observation, info: [0.5, 0.0]\n")
        sys.path.insert(0, folder)
        try:
            figures = played("mine_of_test:half")["summary"]
        finally:
            sys.path.remove(folder)
    return figures["safe_success"] == 1.0 and json.dumps(figures) != ""


tap.run(
    [
        training_and_judging_have_no_seed_in_common,
        seeds_follow_the_chain_of_steve_bench,
        a_card_has_the_same_bits_with_1_and_2_threads,
        a_random_policy_is_reproducible_and_differs_between_episodes,
        a_force_above_the_limit_makes_a_success_unsafe,
        a_resting_policy_goes_nowhere,
        the_expert_reaches_an_easy_target_safely,
        the_expert_turns_the_bend_towards_the_target,
        an_approach_by_one_move_is_the_same_as_its_length,
        an_approach_exchanges_a_tool,
        wrong_approaches_are_refused,
        a_card_is_written_read_and_made_a_table,
        the_rows_of_the_page_are_those_of_its_cards,
        the_commands_of_the_page_are_accepted,
        a_trained_policy_is_reproducible_and_judged_from_its_file,
        broken_policy_files_are_refused,
        wrong_calls_are_refused_with_text,
        a_scene_is_complete_or_absent_and_made_once,
        a_killed_run_is_continued,
        a_policy_of_a_module_is_judged,
    ]
)
