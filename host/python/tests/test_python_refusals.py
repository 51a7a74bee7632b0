#!/usr/bin/env python3
"""Tests what the Python package refuses: a refused batch moves no world; texts of refusals may contain any letter;
arrays of other types are not accepted as inputs; threads that share objects get exceptions. Prints TAP."""

import os
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import cournand  # noqa: E402
import numpy as np  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402
import tree  # noqa: E402

FREE = cournand.Scene(None)
WIRE = cournand.Tool("j_wire")


def world(**options):
    return cournand.World(FREE, [WIRE], **options)


def exception_of(call):
    try:
        call()
    except Exception as error:  # the caller says which one it expects
        return error
    return None


def raises(kind, call):
    """Returns True if the call raises this exception with a non-empty text."""
    error = exception_of(call)
    return type(error) is kind and len(str(error)) > 10


def a_refused_row_moves_no_world():
    worlds = [world() for _ in range(3)]
    batch = cournand.Batch(cournand.Pool(2), worlds)
    actions = np.zeros((3, 8), dtype=np.float32)
    actions[:, 0] = 0.03
    good = True
    for column, number in ((0, np.nan), (0, 1.5), (1, 0.1), (3, 200.0), (6, -1.0), (7, 1.0)):
        bad = actions.copy()
        bad[1, column] = number
        error = exception_of(lambda given=bad: batch.move(given, 133))
        good = good and type(error) is cournand.BadArgumentError and "world 1" in str(error)
        good = good and [one.tick for one in worlds] == [0, 0, 0]
    good = good and raises(cournand.BadArgumentError, lambda: batch.move(actions, 0))
    batch.move(actions, 133)
    return good and [one.tick for one in worlds] == [133, 133, 133]


def a_refused_snapshot_restores_no_world():
    worlds = [world() for _ in range(3)]
    batch, states = cournand.Batch(cournand.Pool(2), worlds), []
    for push in (0.01, 0.02):
        batch.move(np.full((3, 8), [push] + [0.0] * 7, dtype=np.float32), 133)
        states.append((batch.states.copy(), [one.snapshot() for one in worlds]))
    damaged = bytearray(states[0][1][1])
    damaged[5000] ^= 1
    mixed = [states[0][1][0], bytes(damaged), states[0][1][2]]
    good = raises(cournand.BadSnapshotError, lambda: batch.restore(mixed))
    good = good and [one.snapshot() for one in worlds] == states[1][1] and np.array_equal(batch.states, states[1][0])
    batch.restore(states[0][1])
    return good and [one.snapshot() for one in worlds] == states[0][1] and np.array_equal(batch.states, states[0][0])


def the_text_of_a_refusal_survives_any_letters():
    names = ["/" + "x" * extra + letters for letters in ("ö" * 2000, "医" * 900) for extra in range(3)]
    return all(raises(cournand.BadFileError, lambda path=name: cournand.Tool(path)) for name in names)


def a_refused_call_of_a_play_changes_nothing():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "a.session")
        with open(path, "w", encoding="ascii") as file:
            file.write("needs tool j_wire\nadvance 50 mm at 50 mm/s\n")
        play = cournand.Play(path)
        other = cournand.Play(path)
        no_folder = os.path.join(folder, "no", "a.rec")
        good = raises(cournand.BadFileError, lambda: cournand.Play(path, record=no_folder))
    play.advance(ticks=100)
    before = play.world.hash()
    good = good and raises(cournand.BadStateError, play.world.snapshot)  # 100 is no multiple of 16
    for ticks in (0, 600001):
        good = good and raises(cournand.BadArgumentError, lambda given=ticks: play.advance(ticks=given))
    for ticks in (-1, 2**32, "1", None, 0.5):
        good = good and exception_of(lambda given=ticks: play._core.advance(given, False)) is not None
    for tools in ([None], [play], ["no_such_wire"], [WIRE] * 9):
        good = good and exception_of(lambda given=tools: cournand.Play(path, tools=given)) is not None
    good = good and play.world.hash() == before and play.tick == 100
    other.finish()
    names = ["/" + "x" * extra + letters for letters in ("ö" * 2000, "医" * 900) for extra in range(3)]
    good = good and all(raises(cournand.ScriptError, lambda path=one: cournand.Play(path)) for one in names)
    return good and other.tick > 1000


def only_inputs_are_taken_for_inputs():
    made = world()
    wrong = [np.zeros(3), np.zeros((2, 42), dtype=np.int32), np.zeros(168, dtype=np.uint8), [0, 1], None]
    wrong += [np.zeros((2, 2), dtype=cournand.INPUT)]
    good = all(raises(TypeError, lambda given=one: made.advance(given)) for one in wrong) and made.tick == 0
    made.advance(np.zeros(6, dtype=cournand.INPUT)[::2])
    return good and made.tick == 3


def a_renderer_needs_a_size():
    return raises(cournand.BadArgumentError, lambda: cournand.XRay(FREE, 0)) and raises(
        cournand.BadArgumentError, lambda: cournand.View().matrix(0)
    )


def a_batch_returns_only_the_pictures_of_the_call():
    batch = cournand.Batch(cournand.Pool(1), [world()])
    xray, view = [cournand.XRay(FREE, 64)], [cournand.View()]
    grey, labels = batch.render(xray, view, [1])
    only_labels = batch.render(xray, view, [1], picture=False)
    again = batch.render(xray, view, [1])
    return (
        grey.shape == (1, 64, 64)
        and labels is None
        and only_labels[0] is None
        and only_labels[1].shape == (1, 64, 64)
        and again[0] is not None
        and again[1] is None
    )


def a_refused_picture_does_not_decide_the_size():
    batch = cournand.Batch(cournand.Pool(1), [world()])
    bad = cournand.View(primary_deg=500.0)
    refused = raises(
        cournand.BadArgumentError, lambda: batch.render([cournand.XRay(FREE, 64)], [bad], [1], labels=True)
    )
    xray = [cournand.XRay(FREE, 128)]
    grey, labels = batch.render(xray, [cournand.View()], [1], labels=True)
    alone = xray[0].render(world(), cournand.View(), labels=True, seed=1)
    return refused and np.array_equal(grey[0], alone.grey) and np.array_equal(labels[0], alone.labels)


def two_threads_in_one_batch_get_whole_exceptions():
    batch = cournand.Batch(cournand.Pool(2), [world() for _ in range(4)])
    snapshot = bytearray(world().snapshot())
    snapshot[5000] ^= 1
    seen = []

    def work():
        for _ in range(300):
            seen.append(exception_of(lambda: batch.restore([bytes(snapshot)] * 4)))

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    snapshots = [error for error in seen if type(error) is cournand.BadSnapshotError and "snapshot" in str(error)]
    busy = [error for error in seen if type(error) is cournand.BusyError and "another thread" in str(error)]
    return len(snapshots) + len(busy) == 600 and len(snapshots) >= 300


def lets_another_thread_run(call):
    """Returns whether another thread could run during the call, which is possible only if the call releases the
    interpreter's lock. During this time no thread releases the lock by itself."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    try:
        ran, door = [], threading.Lock()
        door.acquire()
        thread = threading.Thread(target=lambda: (door.acquire(), ran.append(True)))
        thread.start()
        door.release()
        begin = time.monotonic()
        while time.monotonic() < begin + 0.002:  # the thread wakes up, and waits for the interpreter's lock
            pass
        call()
        has_run = bool(ran)
        thread.join()
        return has_run
    finally:
        sys.setswitchinterval(before)


def calls_that_open_files_release_the_lock():
    made, opens, records = world(), 0, 0
    with tempfile.TemporaryDirectory() as folder:
        path, file = os.path.join(folder, "long.toml"), os.path.join(folder, "a.rec")
        with open(path, "w", encoding="utf-8") as long:
            long.write(tree.read("shared/examples/instruments/j_wire.toml") + "# a comment\n" * 20000)
        for tries in range(500):  # a busy machine may not let the other thread run within every call
            if opens and records:
                break
            opens += lets_another_thread_run(lambda: cournand._core.Tool(path))
            records += lets_another_thread_run(lambda: made._core.record(file, "x" * 1000))
            made._core.end_recording()
    print("# another thread ran within %d and %d of %d calls" % (opens, records, tries))
    return opens > 0 and records > 0


def the_tests_build_the_package_again_when_a_source_changes():
    wanted = ["shared/examples/scenes/aorta.tar.xz", "shared/version.h", "host/python/module/batches.cpp"]
    sources = [os.path.relpath(path, prepare.ROOT) for path in prepare.sources()]
    with open(os.path.join(prepare.FOLDER, "module", "build.ninja"), encoding="utf-8") as file:
        configures_again = "aorta.tar.xz" in file.read()
    return all(path in sources for path in wanted) and configures_again


tap.run(
    [
        a_refused_row_moves_no_world,
        a_refused_snapshot_restores_no_world,
        the_text_of_a_refusal_survives_any_letters,
        a_refused_call_of_a_play_changes_nothing,
        only_inputs_are_taken_for_inputs,
        a_renderer_needs_a_size,
        a_batch_returns_only_the_pictures_of_the_call,
        a_refused_picture_does_not_decide_the_size,
        two_threads_in_one_batch_get_whole_exceptions,
        calls_that_open_files_release_the_lock,
        the_tests_build_the_package_again_when_a_source_changes,
    ]
)
