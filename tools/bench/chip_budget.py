"""Prices ticks of the core in cycles of three boards, with the memory in which a scene lies (docs/budget.md), as rows
of firmware/bench/budget.tsv. `make budget` and `make budget-search` call it."""

import concurrent.futures
import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOUND = os.path.join("firmware", "bench", "chip", "found.tsv")
SESSIONS_FOLDER = os.path.join("shared", "examples", "sessions")
TOOLS_FOLDER = os.path.join("shared", "examples", "instruments")
# Session that ships, its scene in out/, and what the row says about it.
SESSIONS = (
    ("demo", "aorta", "tools=1"),
    ("over_the_wire", "aorta", "tools=2"),
    ("renal", "aorta", "tools=2"),
    ("coronary", "heart", "beating tools=2"),
    ("pci_renal", "renal_pci", "tools=4 stent"),
    ("pci_lad", "lad_pci", "beating tools=4 stent"),
)
# Scene and tools, from the innermost, in which `make budget-search` looks for the dearest tick.
SEARCHED = (
    ("aorta", ("j_wire",)),
    ("aorta", ("bentson", "beacon_5f")),
    ("aorta", ("terumo_stiff_angled", "balloon_6x20", "guide_jr4_6f")),
    ("heart", ("j_wire",)),
    ("heart", ("j_wire", "guide_jl3_6f")),
    ("lad_pci", ("coronary_014", "balloon_3x20", "guide_jl3_6f")),
)
SEEDS, DRIVE_TICKS = 16, 10000
BOARDS_CYCLES = (("rt1062", 600000), ("rt1176", 1000000), ("stm32h735", 550000))
MEAN, HIGH, MOST = 0, 1, 2  # columns of the program's output
SAMPLES = 1000


class CannotPrice(Exception):
    """Raised when a tick cannot be priced; the text gives the reason."""


def run(command):
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise CannotPrice("%s: exit code %d: %s" % (" ".join(command), done.returncode, done.stderr.strip()[-400:]))
    return done.stdout


def figures(text):
    """Reads the lines "name value ..." of the program `chip`."""
    return {words[0]: [int(word) for word in words[1:]] for words in map(str.split, text.splitlines())}


def chip(build, image, *arguments):
    program = os.path.join(build, "bench", "chip")
    if not os.path.exists(os.path.join(ROOT, program)):
        raise CannotPrice("%s is missing: `make budget` builds it" % program)
    return figures(run([program, "--image", os.path.join(build, "m7", image), *arguments]))


def rows_of(read, column, context):
    """Yields the rows of one case: `column` chooses mean, 99.9th percentile or largest value."""
    yield "chip.instructions", read["instructions"][column], "instructions", context
    yield "chip.cycles", read["cycles_rt1062"][column], "cycles", context
    yield "chip.pipeline_cycles", read["core_cycles"][column], "cycles", context
    yield "chip.misses", read["misses"][column], "lines", context
    yield "chip.near_misses", read["near_misses"][column], "lines", context
    yield "chip.lines", read["lines"][column], "lines", context
    yield "chip.bricks", read["bricks"][column], "bricks", context
    for board, cycles in BOARDS_CYCLES:
        share = round(1000 * read["cycles_" + board][column] / cycles)
        yield "chip.share_permille", share, "1/1000", "%s board=%s" % (context, board)


# --- the cases of the instruction budget ------------------------------------------------------------------------------
def case_rows(build, path, context, column, instructions):
    """`instructions` is QEMU's count of the same case, which must agree."""
    read = chip(build, "chip_case.elf", "case", path)
    counted = read["instructions"][column]
    if abs(counted - instructions) > 0.005 * instructions:
        raise CannotPrice("%s: %d instructions here, %d in QEMU" % (context, counted, instructions))
    return list(rows_of(read, column, context))


# --- sessions that ship -----------------------------------------------------------------------------------------------
def scene_path(scene):
    path = os.path.join("out", scene + ".scene")
    if not os.path.exists(os.path.join(ROOT, path)):
        raise CannotPrice("%s is missing: `make budget` makes it" % path)
    return path


def session_rows(build, folder, session):
    name, scene, what = session
    recording = os.path.join(folder, name + ".rec")
    script = os.path.join(SESSIONS_FOLDER, name + ".session")
    run([os.path.join(build, "bin", "cournand"), "run", "--scene", scene_path(scene), "--session", script]
        + ["--record", recording, "--quiet"])
    read = chip(build, "chip_device.elf", "session", recording, "--samples", str(SAMPLES))
    context = "session=%s %s p99.9" % (name, what)
    return list(rows_of(read, HIGH, context)) + [
        ("chip.app_cycles", read["app_cycles"][0], "cycles", context),
        ("chip.nodes", read["nodes"][0], "nodes", context),
        ("chip.positions", read["positions"][0], "positions", context),
        ("chip.estimate_cycles", read["estimate"][0], "cycles", context),
        ("chip.scene_bytes", read["scene_bytes"][0], "bytes", "scene=" + scene),
    ]


# --- ticks that a search found ----------------------------------------------------------------------------------------
def drive(scene, tools):
    words = ["--scene", scene_path(scene)]
    for tool in tools:
        words += ["--tool", os.path.join(TOOLS_FOLDER, tool + ".toml")]
    return words


def found_ticks():
    with open(os.path.join(ROOT, FOUND), encoding="utf-8") as file:
        for line in file:
            if not line.startswith("#"):
                scene, tools, seed, tick = line.rstrip("\n").split("\t")
                yield scene, tuple(tools.split(",")), seed, tick


def found_rows(build, found):
    scene, tools, seed, tick = found
    read = chip(build, "chip_device.elf", "found", *drive(scene, tools), "--seed", seed, "--tick", tick)
    return list(rows_of(read, MOST, "found scene=%s tools=%s" % (scene, ",".join(tools))))


def search(build, job):
    scene, tools = job
    read = chip(build, "chip_device.elf", "search", *drive(scene, tools), "--seeds", str(SEEDS), "--ticks",
                str(DRIVE_TICKS))
    print("%-8s %-52s seed %2d tick %5d: %9d cycles, %5d misses" % (
        scene, ",".join(tools), read["seed"][0], read["tick"][0], read["cycles_rt1062"][0], read["misses"][0]),
        flush=True)
    return "%s\t%s\t%d\t%d\n" % (scene, ",".join(tools), read["seed"][0], read["tick"][0])


def search_all(build, jobs):
    """Looks for the dearest ticks anew, and writes them to firmware/bench/chip/found.tsv."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        lines = list(pool.map(lambda job: search(build, job), SEARCHED))
    with open(os.path.join(ROOT, FOUND), "w", encoding="utf-8") as file:
        file.write("# scene, tools, seed of the drive, tick: written by `make budget-search` (docs/budget.md)\n")
        file.writelines(lines)


# --- all --------------------------------------------------------------------------------------------------------------
def measure(build, folder, cases, jobs):
    """Returns the rows of the cases (path, context, column, instructions), of the sessions and of the found ticks."""
    tasks = [lambda case=case: case_rows(build, *case) for case in cases]
    tasks += [lambda one=one: session_rows(build, folder, one) for one in reversed(SESSIONS)]
    tasks += [lambda one=one: found_rows(build, one) for one in found_ticks()]
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        done = list(pool.map(lambda task: task(), tasks))
    rows = [row for part in done for row in part]
    return list(dict.fromkeys(rows))
