#!/usr/bin/env python3
"""Tests session scripts in Python: a play gives the report and the recording of `cournand run` byte for byte, wherever
the program stops; a broken expectation is a result; a mistake in a script is an exception with its place. Prints TAP.
"""

import json
import os
import subprocess
import sys
import tempfile
import threading

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import cournand  # noqa: E402
import numpy as np  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402

DATA = os.path.join(prepare.SITE, "cournand", "data")
SESSION = """needs scene aorta
needs tools bentson, pigtail_5f
begin wire inserted 8 mm
begin catheter inserted 5 mm
follow tip
fluoro on rate 7.5 p/s
advance wire until inserted 60 mm at 100 mm/s
advance catheter 20 mm at 60 mm/s while rotate 0.5 turn
steer wire into right iliac artery at 60 mm/s until 30 mm within 3 s
fluoro off
cine on rate 15 f/s
inject 1 ml at 1.5 ml/s
wait 0.8 s
cine off
expect tip in right iliac artery
"""
BALLOON = """needs tools coronary_014, balloon_3x20
needs stent coronary_3_0x18
advance wire 30 mm at 40 mm/s
inflate to 12 bar at 20 bar/s
wait 0.3 s
deflate
"""
FOLDER = tempfile.TemporaryDirectory()


def written(name, text):
    path = os.path.join(FOLDER.name, name)
    with open(path, "w", encoding="ascii") as file:
        file.write(text)
    return path


def content(path):
    with open(path, "rb") as file:
        return file.read()


def run_of_the_program(script, tools, scene=None, stents=(), more=()):
    """Plays a script with `cournand run`, and returns the bytes of report and recording, and the exit code."""
    report, record = script + ".json", script + ".run.rec"
    code = exit_code_of_the_program(script, tools, record, scene, stents, ["--json", report, *more])
    return content(report), content(record), code


def exit_code_of_the_program(script, tools, record, scene=None, stents=(), more=()):
    words = [os.path.join(prepare.BUILD, "bin", "cournand"), "run", script, "--quiet", "--record", record, *more]
    words += ["--scene", os.path.join(DATA, "scenes", scene + ".scene")] if scene else []
    for tool in tools:
        words += ["--tool", tool if os.sep in tool else os.path.join(DATA, "instruments", tool + ".toml")]
    for stent in stents:
        words += ["--stent", os.path.join(DATA, "stents", stent + ".toml")]
    return subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode


def is_equal_to_run(name, text, tools, scene=None, stents=(), hands="", given=()):
    script = written(name, text)
    more = ["--hands", hands] if hands else []
    report, record, code = run_of_the_program(script, tools, scene, stents, more)
    path = script + ".rec"
    play = cournand.Play(script, tools=given, record=path, hands=hands)
    play.finish()
    differ = [key for key, value in json.loads(report).items() if play.report()[key] != value]
    print("# %s: %d ticks, %d bytes of recording; members that differ: %s" % (name, play.tick, len(record), differ))
    return play.report_json().encode() == report and content(path) == record and play.exit_status == code


def a_play_gives_report_and_recording_of_the_program():
    return is_equal_to_run("whole.session", SESSION, ["bentson", "pigtail_5f"], "aorta")


def a_stent_on_its_balloon_is_that_of_the_program():
    return is_equal_to_run("balloon.session", BALLOON, ["coronary_014", "balloon_3x20"], None, ["coronary_3_0x18"])


def a_novice_is_that_of_the_program():
    return is_equal_to_run("novice.session", SESSION, ["bentson", "pigtail_5f"], "aorta", hands="novice:3")


def a_slipping_hand_is_that_of_the_program():
    """A catheter that is five times as rough and three times as stiff in torsion slips in the hand."""
    text = content(os.path.join(DATA, "instruments", "guide_jl4_6f.toml")).decode()
    for name, value, other in (("kinetic", "0.12", "0.5"), ("static", "0.15", "0.6")):
        text = text.replace("friction_%s = { value = %s" % (name, value), "friction_%s = { value = %s" % (name, other))
    rough = written("rough.toml", text.replace("twist_to_bend = { value = 1.5", "twist_to_bend = { value = 5"))
    push = "needs scene aorta\nadvance 300 mm at 300 mm/s while rotate 5 turns at 1080 deg/s\n"
    slipped_deg = cournand.play(written("slip.session", push), tools=[rough])["tools"][0]["grip"]["slipped_deg"]
    print("# slipped by %.0f degrees" % slipped_deg)
    return slipped_deg > 100 and is_equal_to_run("slip.session", push, [rough], "aorta", given=[rough])


def pulses_pictures_and_a_branch_change_nothing():
    whole = cournand.play(written("a.session", SESSION))
    play, pulses, branch = cournand.Play(written("a.session", SESSION), size=64), 0, None
    for moment in play.pulses():
        picture = play.picture(labels=True, sequence=True)
        pulses += 1
        assert picture.tick == moment.tick == play.tick and picture.grey.shape == (64, 64)
        if pulses == 5:
            branch = play.world.fork()
            assert branch.hash() == play.world.hash()
            branch.move(0.05, ticks=50)
    assert branch is not None and branch.tick > 50
    iso = np.array(play.view().isocentre_m)
    print("# %d of %d pulses; the isocentre is %s" % (pulses, play.pulse_count, iso))
    return play.report() == whole and pulses >= play.pulse_count - 1 > 10 and iso.any()


def a_broken_expectation_is_a_result():
    script = written("broken.session", "needs tool j_wire\nwait 0.1 s\nexpect inserted at least 900 mm\n")
    play = cournand.Play(script)
    moments = list(play.moments(0.02))
    report = play.report()
    return (
        play.exit_status == 1
        and len(play.failures) == 1
        and "broken.session:3" in play.failures[0]
        and report["failures"] == play.failures
        and report["expected"][0]["held"] is False
        and moments[0].tick == 20
        and play.is_over
    )


def error_of(kind, call):
    try:
        call()
    except kind as error:
        return error
    return None


def a_mistake_is_an_exception_with_its_place():
    script = written("wrong.session", "needs tool j_wire\nwait 0.1 s\nadvanse 3 mm\n")
    error = error_of(cournand.ScriptError, lambda: cournand.Play(script))
    vessel = written("vessel.session", "needs scene aorta\nneeds tool j_wire\nsteer into elbow\n")
    other = error_of(cournand.ScriptError, lambda: cournand.play(vessel))
    missing = error_of(cournand.BadFileError, lambda: cournand.Play("no/such.session"))
    tool = written("tool.session", "needs tool no_such_wire\nwait 1 s\n")
    return (
        error is not None
        and (error.file, error.line, error.column) == (script, 3, 1)
        and "advance" in str(error)
        and other is not None
        and other.line == 3
        and missing is not None
        and error_of(cournand.BadFileError, lambda: cournand.Play(tool)) is not None
    )


def a_refused_play_leaves_the_file_of_an_earlier_recording():
    record = written("kept.rec", "an earlier recording")
    script = written("vessel.session", "needs scene aorta\nneeds tool j_wire\nsteer into elbow\n")
    refused = error_of(cournand.ScriptError, lambda: cournand.Play(script, record=record)) is not None
    ended = exit_code_of_the_program(script, ["j_wire"], record, "aorta")
    return refused and ended == 1 and content(record) == b"an earlier recording"


def a_recording_never_replaces_the_script():
    script = written("mine.session", SESSION)
    error = error_of(cournand.BadArgumentError, lambda: cournand.Play(script, record=script))
    print("# %s" % error)
    return error is not None and content(script) == SESSION.encode("ascii")


def reading_the_hash_changes_no_recording():
    files = []
    for is_read in (False, True):
        path = os.path.join(FOLDER.name, "hash%d.rec" % is_read)
        play = cournand.Play(written("h.session", SESSION), record=path)
        while not play.is_over:
            play.advance(ticks=35)
            if is_read:
                play.world.hash()
        files.append(content(path))
    return files[0] == files[1] and len(files[0]) > 1000


def only_the_script_moves_its_world():
    play = cournand.Play(written("b.session", SESSION))
    play.advance(seconds=0.16)
    calls = [
        lambda: play.world.move(0.01, ticks=1),
        lambda: play.world.exchange(0, 1),
        lambda: play.world.patient.inject(1, ml_per_s=1),
        lambda: play.world.restore(play.world.snapshot()),
        lambda: play.report(),
    ]
    refused = all(error_of(cournand.BadStateError, call) is not None for call in calls)
    wrong = all(
        error_of((TypeError, ValueError), call) is not None
        for call in (
            lambda: play.advance(),
            lambda: play.advance(ticks=0),
            lambda: play.advance(ticks=-1),
            lambda: play.advance(seconds=float("nan")),
            lambda: next(play.moments(0.0)),
            lambda: cournand.Play(written("b.session", SESSION), tools=[1]),
            lambda: cournand.Play(written("b.session", SESSION), hands="expart:1"),
        )
    )
    return refused and wrong and play.tick == 160


def a_long_call_releases_the_lock_and_refuses_a_second_thread():
    play = cournand.Play(written("long.session", "needs scene aorta\nneeds tool j_wire\nadvance 60 mm at 1 mm/s\n"))
    seen = []

    def lead():
        while error_of(cournand.BusyError, lambda: play.advance(ticks=20000)) is not None:
            pass

    thread = threading.Thread(target=lead)
    thread.start()
    while thread.is_alive():
        seen.append(type(error_of(cournand.Error, lambda: play.world.hash())))
    thread.join()
    print("# %d calls of the other thread meanwhile, %d refused" % (len(seen), seen.count(cournand.BusyError)))
    return cournand.BusyError in seen and set(seen) <= {cournand.BusyError, type(None)}


tap.run(
    [
        a_play_gives_report_and_recording_of_the_program,
        a_stent_on_its_balloon_is_that_of_the_program,
        a_novice_is_that_of_the_program,
        a_slipping_hand_is_that_of_the_program,
        pulses_pictures_and_a_branch_change_nothing,
        a_broken_expectation_is_a_result,
        a_mistake_is_an_exception_with_its_place,
        a_refused_play_leaves_the_file_of_an_earlier_recording,
        a_recording_never_replaces_the_script,
        reading_the_hash_changes_no_recording,
        only_the_script_moves_its_world,
        a_long_call_releases_the_lock_and_refuses_a_second_thread,
    ]
)
