#!/usr/bin/env python3
"""Tests the Python package `cournand`: it computes the same bits as `cournand run`; its views need no copies and stay
valid; an exception leaves the world unchanged; it supports threads, pictures, recordings and the patient. Prints
TAP."""

import os
import random
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

SCENE = cournand.Scene("aorta")
WIRE = cournand.Tool("j_wire")
SCRIPT = "begin inserted 5 mm\nadvance 60 mm at 80 mm/s while rotate 1 turn\nwait 0.1 s\n"


def world(**options):
    return cournand.World(SCENE, [WIRE], **options)


def raises(kind, call):
    """Returns True if the call raises this exception with a non-empty text."""
    try:
        call()
    except kind as error:
        return type(error) is kind and len(str(error)) > 10
    return False


def run_of_the_program(folder):
    """Runs a session with `cournand run`, and returns its recording and the hash that the program prints."""
    script, path = os.path.join(folder, "a.session"), os.path.join(folder, "a.rec")
    with open(script, "w", encoding="ascii") as file:
        file.write(SCRIPT)
    data = os.path.join(prepare.SITE, "cournand", "data")
    words = [os.path.join(prepare.BUILD, "bin", "cournand"), "run", script, "--quiet", "--record", path]
    words += ["--scene", os.path.join(data, "scenes", "aorta.scene")]
    words += ["--instrument", os.path.join(data, "instruments", "j_wire.toml")]
    said = prepare.run(words + ["--json", os.path.join(folder, "a.json")])
    with open(os.path.join(folder, "a.json"), encoding="utf-8") as file:
        return cournand.Recording(path), file.read() + said


def the_inputs_of_a_session_of_run_give_its_hash():
    with tempfile.TemporaryDirectory() as folder:
        recording, report = run_of_the_program(folder)
        inputs = recording.inputs()
        made = world(inserted_m=[0.005])
        made.advance(inputs)
        replayed = recording.world(SCENE)
        replayed.replay(recording)
        own = "%016x" % made.hash()
        return (
            len(inputs) == recording.info.tick_count == made.tick
            and own in report
            and replayed.hash() == made.hash() == recording.info.last_hash
        )


def one_call_gives_the_same_bits_as_many():
    whole, parts = world(), world()
    whole.move(0.06, 1.0, ticks=300)
    for _ in range(3):
        parts.move(push=[0.06], turn=[1.0], seconds=0.1)
    return whole.tick == parts.tick == 300 and whole.hash() == parts.hash()


def worlds_have_the_same_bits_with_1_and_2_threads():
    actions = np.zeros((4, 8), dtype=np.float32)
    actions[:, 0] = [0.03, 0.04, 0.05, 0.06]
    seen = []
    for threads in (1, 2):
        worlds = [world() for _ in range(4)]
        batch = cournand.Batch(cournand.Pool(threads), worlds)
        for _ in range(3):
            batch.move(actions, 133)
        seen.append(([one.hash() for one in worlds], batch.states.copy()))
    return seen[0][0] == seen[1][0] and len(set(seen[0][0])) == 4 and np.array_equal(seen[0][1], seen[1][1])


def a_batch_reads_what_a_world_reads():
    made = world(contact_ticks=19)
    batch = cournand.Batch(cournand.Pool(1), [made], points=2, spacing_m=0.002)
    batch.move(np.array([[0.06, 0, 0, 1, 0, 0, 0, 0]], dtype=np.float32), 2000)
    reading, pose, tip = made.read(), made.pose(), made.tip()
    hands, figures = batch.states[0, batch.columns.hands], batch.states[0, batch.columns.figures]
    return (
        np.array_equal(batch.states[0, :3], pose.positions_m[0])
        and 0.0019 < np.linalg.norm(batch.states[0, 3:6] - pose.positions_m[0]) <= 0.0020001
        and hands[0] == np.float32(reading.inserted_m[0])
        and hands[1] == np.float32(reading.force_N[0])
        and figures[0] == np.float32(reading.wall_force_N) > 0
        and batch.vessels[0] == tip.vessel >= 0
        and batch.places[0, 0] == np.float32(tip.along_m)
    )


def a_restored_world_and_a_fork_continue_bit_for_bit():
    first = world(contact_ticks=19)
    first.move(0.06, ticks=2000)
    read = first.read()
    snapshot = first.snapshot()
    fork = first.fork()
    forked = fork.read()
    first.move(0.04, 2.0, ticks=300)
    after = first.hash(), first.read()
    fork.move(0.04, 2.0, ticks=300)
    first.restore(snapshot)
    restored = first.read()
    first.move(0.04, 2.0, ticks=300)
    return (
        (first.hash(), first.read()) == after == (fork.hash(), fork.read())
        and read == forked == restored
        and 0 < read.wall_force_N <= read.wall_force_peak_N
    )


def views_are_read_only_and_without_a_copy():
    made = world()
    made.move(0.06, ticks=100)
    first, second = made.pose(), made.pose()
    address = first.positions_m.__array_interface__["data"][0]
    return (
        address == second.positions_m.__array_interface__["data"][0]
        and first.positions_m.shape == (len(first.arcs_m), 3)
        and first.positions_m.dtype == np.float32
        and first.positions_q30.dtype == np.int32
        and np.allclose(first.positions_q30 / 2.0**30, first.positions_m, atol=1e-6)
        and not first.positions_m.flags.owndata
        and raises_on_write(first.positions_m)
        and raises_on_write(SCENE.vessels[0].points_m)
    )


def raises_on_write(array):
    try:
        array[0] = 0
    except ValueError:
        return True
    return False


def a_view_lives_longer_than_its_world():
    made = world()
    made.move(0.06, ticks=100)
    pose = made.pose()
    kept = [array.copy() for array in pose[1:]]
    del made
    rubbish = [world() for _ in range(3)]  # takes memory that a freed world would have given back
    for one in rubbish:
        one.move(0.05, ticks=50)
    return all(np.array_equal(old, new) for old, new in zip(kept, pose[1:]))


def an_old_view_keeps_its_place_while_the_shape_grows():
    made = world()
    old = made.pose()
    before = len(old.arcs_m)
    made.move(0.2, ticks=1500)
    new = made.pose()
    return len(new.arcs_m) > before + 50 and all(
        a.__array_interface__["data"][0] == b.__array_interface__["data"][0] for a, b in zip(old[1:], new[1:])
    )


def every_refusal_is_a_named_exception_and_changes_nothing():
    made = world()
    made.move(0.06, ticks=200)
    before = made.hash()
    snapshot = bytearray(made.snapshot())
    snapshot[5000] ^= 1
    inputs = np.zeros(1, dtype=cournand.INPUT)
    inputs["push_um"][0, 0] = 10**6
    cases = [
        (cournand.BadArgumentError, lambda: made.move(2.0, ticks=1)),
        (cournand.BadArgumentError, lambda: made.move(float("nan"), ticks=1)),
        (cournand.BadArgumentError, lambda: made.move(0.1, ticks=0)),
        (cournand.BadArgumentError, lambda: made.move([0.0, 0.1], ticks=1)),
        (cournand.BadArgumentError, lambda: made.advance(inputs)),
        (cournand.BadArgumentError, lambda: made.tip(2)),
        (cournand.BadArgumentError, lambda: SCENE.find_vessel("nose")),
        (cournand.BadArgumentError, lambda: WIRE.scaled(mass=100.0)),
        (cournand.BadSnapshotError, lambda: made.restore(bytes(snapshot))),
        (cournand.BadSnapshotError, lambda: made.restore(b"")),
        (cournand.BadStateError, lambda: cournand.Patient(made).inject(5, ml_per_s=5)),
        (cournand.BadStateError, lambda: made.record("late.rec").__enter__()),
        (cournand.BadFileError, lambda: cournand.Scene("/no/such.scene")),
        (cournand.BadFileError, lambda: cournand.Tool("j_wirre")),
        (cournand.BadFileError, lambda: cournand.Recording("/no/such.rec")),
        (cournand.RefusedError, lambda: made.exchange(0, 7)),
    ]
    failed = [number for number, (kind, call) in enumerate(cases) if not raises(kind, call)]
    print("".join("# case %d does not raise %s\n" % (number, cases[number][0].__name__) for number in failed), end="")
    return not failed and made.hash() == before and made.tick == 200


def the_exceptions_are_those_of_the_statuses():
    kinds = [cournand.errors.of_status(number) for number in range(1, 11)]
    names = [cournand._core.status_name(number) for number in range(1, 11)]
    return (
        [kind.status for kind in kinds] == names
        and len(set(kinds)) == 10
        and issubclass(cournand.BadArgumentError, ValueError)
        and issubclass(cournand.BadFileError, OSError)
        and all(issubclass(kind, cournand.Error) for kind in kinds)
    )


def ten_thousand_wrong_calls_do_not_crash():
    """Calls everything with arguments of any kind. Seed 23 reproduces a run."""
    draw = random.Random(23)
    made, xray, batch = world(), cournand.XRay(SCENE, 64), cournand.Batch(cournand.Pool(2), [world(), world()])
    treated = cournand.World(SCENE, [cournand.Tool("terumo_5f")], patient=True)
    with tempfile.TemporaryDirectory() as folder:
        script = os.path.join(folder, "a.session")
        with open(script, "w", encoding="ascii") as file:
            file.write(SCRIPT)
        play = cournand.Play(script, SCENE, [WIRE])
    junk = [None, -1, 0, 1, 3, 2**31, 2**64, -(2**70), 0.5, float("nan"), float("inf"), "", "x", "\0", b"", b"abc"]
    junk += [[], [1] * 20, ["a"], [None], (), {}, object(), made, xray, SCENE, WIRE, np.zeros(0), np.zeros((3, 3))]
    junk += [play, np.zeros((2, 8), dtype=np.float32), np.zeros((1, 8)), np.full((2, 8), np.nan, dtype=np.float32)]
    junk += [
        np.zeros(2, dtype=cournand.INPUT),
        b"\0" * len(made.snapshot()),
        treated.snapshot(),
        True,
        10**9,
        -0.0,
        [0.01],
        range(5),
    ]
    owners = [made, xray, batch, SCENE, WIRE, cournand.Patient(made), made._core, xray._core, batch._core, SCENE._core]
    owners += [WIRE._core, cournand, cournand._core, cournand.View(), treated, treated.patient, treated._core]
    owners += [play, play._core, play._script, play.world, play.world._core]
    calls = [(owner, name) for owner in owners for name in dir(owner) if not name.startswith("_")]
    left_out = {"record", "save"}  # they write files
    calls = [(owner, name) for owner, name in calls if name not in left_out and callable(getattr(owner, name))]
    raised = 0
    for _ in range(10000):
        owner, name = draw.choice(calls)
        arguments = [draw.choice(junk) for _ in range(draw.randrange(8))]
        named = {draw.choice(["ticks", "seconds", "which", "seed", "threads"]): draw.choice(junk)}
        try:
            getattr(owner, name)(*arguments, **(named if draw.random() < 0.3 else {}))
        except Exception:  # any exception is right; a crash ends the test
            raised += 1
    print("# %d of 10000 calls raised" % raised)
    made.move(0.01, ticks=1)
    return raised > 5000


def a_long_call_releases_the_lock_and_refuses_a_second_thread():
    made = world()
    began = threading.Event()

    def push():
        began.set()
        while made.tick == 0:
            try:
                made.move(0.06, ticks=4000)
            except cournand.BusyError:  # the other thread was inside first
                continue

    thread = threading.Thread(target=push)
    thread.start()
    began.wait()
    refused = counted = 0
    while thread.is_alive():
        counted += 1
        try:
            made.read()
        except cournand.BusyError:
            refused += 1
    thread.join()
    return refused > 10 and counted > 10 and made.tick == 4000


def pictures_have_labels_where_the_wire_is():
    made = world()
    made.move(0.06, ticks=2000)
    view = cournand.View(primary_deg=20, isocentre_m=made.tip().tip_m, field_m=0.2)
    one = cournand.XRay(SCENE, 256).render(made, view, labels=True, seed=3)
    two = cournand.XRay(SCENE, 256, threads=2).render(made, view, labels=True, seed=3)
    # The tip itself, at the isocentre, lies on a corner of four pixels, of which the wire covers one at least.
    pixels = view.project(made.pose().positions_m[1:20], 256).astype(int)
    on_wire = one.labels[pixels[:, 1], pixels[:, 0]] & cournand.Label.TOOL_0
    return (
        one.grey.shape == one.labels.shape == one.raw.shape == (256, 256)
        and (one.grey.dtype, one.raw.dtype) == (np.uint8, np.uint16)
        and np.array_equal(one.grey, two.grey)
        and np.array_equal(one.labels, two.labels)
        and bool(on_wire.all())
        and 20 < np.count_nonzero(one.labels) < 2000
        and one.grey.flags.owndata
    )


def a_picture_is_kept_while_the_renderer_makes_others():
    made, xray = world(), cournand.XRay(SCENE, 128)
    first = xray.render(made, seed=1)
    kept, seen = first.grey.copy(), xray.render(made, seed=2, copy=False)
    address = seen.grey.__array_interface__["data"][0]
    again = xray.render(made, seed=3, copy=False)
    del xray
    return np.array_equal(first.grey, kept) and again.grey.__array_interface__["data"][0] == address


def a_patient_receives_medium_and_changes_no_hash():
    catheter = [cournand.Tool("terumo_5f")]
    plain, other = cournand.World(SCENE, catheter), cournand.World(SCENE, catheter, patient=True)
    other.patient.inject(5, ml_per_s=5, iodine_mg_per_ml=350)
    for one in (plain, other):
        one.move(0.02, ticks=500)
    read = other.patient.read()
    labels = cournand.XRay(SCENE, 128).render(other, picture=False).labels
    return (
        plain.patient is None
        and 1.0 < read.injected_ml <= 5.0
        and 40 < read.pressure_mmHg < 200
        and bool((labels & cournand.Label.MEDIUM).any())
        and plain.hash() == other.hash()
    )


def a_world_with_a_patient_branches_bit_for_bit():
    made, xray = cournand.World(SCENE, [cournand.Tool("terumo_5f")], patient=True), cournand.XRay(SCENE, 128)
    made.move(0.05, ticks=300)
    made.patient.inject(5, ml_per_s=5)
    made.move(0.02, ticks=417)
    snapshot, seen = made.snapshot(), []
    view = cournand.View(isocentre_m=made.tip().tip_m)
    for branch in (made, made, made.fork()):
        branch.restore(snapshot)
        first = xray.render(branch, view, labels=True)
        branch.move(0.03, 1.0, ticks=603)
        last = xray.render(branch, view, labels=True)
        seen.append([branch.hash(), branch.patient.read(), branch.snapshot()])
        seen[-1] += [one.tobytes() for picture in (first, last) for one in (picture.raw, picture.labels)]
    print("# a snapshot with a patient has %d bytes" % len(snapshot))
    return seen[0] == seen[1] == seen[2] and seen[0][1].injected_ml > 4.9 and len(snapshot) > 50_000


def a_recorded_world_replays():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "b.rec")
        made = world()
        with made.record(path):
            made.move(0.06, 1.0, ticks=400)
        recording = cournand.Recording(path)
        replayed = recording.world(SCENE)
        replayed.replay(recording, 200)
        good = recording.info.is_complete and recording.info.tick_count == 400 and replayed.tick == 200
        fork = replayed.fork()
        good = good and fork.tick == 200 and fork.hash() == replayed.hash()
        fork.replay(recording)
        return good and fork.hash() == made.hash()


def a_session_is_led_pulse_by_pulse_and_recorded():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "c.rec")
        with cournand.Session(SCENE, [WIRE], pulses_per_s=15, size=64, labels=True, record=path) as session:
            frames = list(session.lead(lambda frame: (0.03, 0.0), seconds=0.4))
        plain = world()
        plain.move(0.03, ticks=400)
        recording = cournand.Recording(path)
        return (
            [frame.tick for frame in frames] == [67, 133, 200, 267, 333, 400]
            and session.world.hash() == plain.hash() == recording.info.last_hash
            and all(frame.picture.labels is not None for frame in frames)
        )


def a_child_of_fork_makes_its_own_pool():
    pool = cournand.Pool(2)
    made = world()
    batch = cournand.Batch(pool, [made])
    child = os.fork()
    if child == 0:
        good = raises(cournand.BadStateError, batch.read)
        cournand.Batch(cournand.Pool(2), [made]).read()
        os._exit(0 if good else 1)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def the_package_has_types_and_a_version():
    folder = os.path.join(prepare.SITE, "cournand")
    with open(os.path.join(prepare.ROOT, "shared", "version.h"), encoding="ascii") as file:
        is_release = 'CRN_VERSION "%s"' % cournand.__version__ in file.read()
    return is_release and all(os.path.exists(os.path.join(folder, name)) for name in ("py.typed", "_core.pyi"))


def nothing_leaks_at_the_end():
    script = (
        "import cournand as c, numpy as np, gymnasium, cournand.envs as e\n"
        "s = c.Scene(); w = c.World(s, [c.Tool('j_wire')]); w.move(0.05, ticks=20)\n"
        "p = w.pose(); x = c.XRay(s, 64); g = x.render(w, copy=False)\n"
        "v = e.NavigationVectorEnv(2, observation='labels', size=64); v.reset(seed=1)\n"
        "try: w.move(5.0, ticks=1)\nexcept c.Error: pass\n"
    )
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    print("# " + ended.stderr.replace("\n", "\n# "))
    return ended.returncode == 0 and ended.stderr == ""


tap.run(
    [
        the_inputs_of_a_session_of_run_give_its_hash,
        one_call_gives_the_same_bits_as_many,
        worlds_have_the_same_bits_with_1_and_2_threads,
        a_batch_reads_what_a_world_reads,
        a_restored_world_and_a_fork_continue_bit_for_bit,
        views_are_read_only_and_without_a_copy,
        a_view_lives_longer_than_its_world,
        an_old_view_keeps_its_place_while_the_shape_grows,
        every_refusal_is_a_named_exception_and_changes_nothing,
        the_exceptions_are_those_of_the_statuses,
        ten_thousand_wrong_calls_do_not_crash,
        a_long_call_releases_the_lock_and_refuses_a_second_thread,
        pictures_have_labels_where_the_wire_is,
        a_picture_is_kept_while_the_renderer_makes_others,
        a_patient_receives_medium_and_changes_no_hash,
        a_world_with_a_patient_branches_bit_for_bit,
        a_recorded_world_replays,
        a_session_is_led_pulse_by_pulse_and_recorded,
        a_child_of_fork_makes_its_own_pool,
        the_package_has_types_and_a_version,
        nothing_leaks_at_the_end,
    ]
)
