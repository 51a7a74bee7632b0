#!/usr/bin/env python3
"""Builds a wheel of the package with the static library of the build folder, completes it with auditwheel, and installs
it in an empty virtual environment. In the environment with the wheel, the five lines of the README, an environment from
gymnasium.make and the notebook must work. Checks the types by mypy. Prints TAP."""

import os
import re
import resource
import subprocess
import sys
import time
import venv
import zipfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402
import wheel  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402
import tree  # noqa: E402

from wheel import PYTHON, TOOLS, WORK, found, succeeds  # noqa: E402

LIMIT_S = 60  # of the issue: installation and picture, after the download; in the processor's time
UNWANTED = re.compile(r"lib(X|GL|EGL|OpenGL|glfw|dcm|ofstd|usb|png|archive|openh264|sqlite|pq)", re.IGNORECASE)
EMPTY = os.path.join(WORK, "empty")


def processor_s():
    """Returns the processor time of all commands so far, which does not depend on other work on the machine."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def the_wheel_carries_what_it_needs_and_nothing_else():
    with zipfile.ZipFile(found("complete/*.whl")) as opened:
        names = opened.namelist()
        opened.extractall(os.path.join(WORK, "opened"))
    needed = subprocess.run(
        ["readelf", "-d", os.path.join(WORK, "opened", "cournand", "_core.abi3.so")],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    wanted = ["_core.pyi", "py.typed", "data/scenes/aorta.scene", "data/scenes/aorta.bodies"]
    wanted += ["data/instruments/j_wire.toml", "data/stents/coronary_3_0x18.toml", "envs/navigation.py"]
    missing = [name for name in wanted if "cournand/" + name not in names]
    size = os.path.getsize(found("complete/*.whl"))
    print("# %d bytes; missing: %s" % (size, missing))
    return (
        not missing
        and not UNWANTED.search(needed)
        and not [name for name in names if UNWANTED.search(name)]
        and [name for name in names if name.startswith("cournand.libs/libccd")]
        and not [name for name in names if "/tests/" in name or name.endswith((".cpp", ".hpp"))]
        and size < 12_000_000
    )


def an_empty_environment_has_a_picture_in_a_minute():
    wheels = wheel.downloaded()
    if not wheels:
        return False
    example = wheel.five_lines()
    begin, before = time.monotonic(), processor_s()
    venv.create(EMPTY, with_pip=True)
    python = os.path.join(EMPTY, "bin", "python")
    install = [python, "-m", "pip", "install", "--quiet", "--no-index", "--find-links", wheels, found("complete/*.whl")]
    good = succeeds(install) and succeeds([python, "-c", example], cwd=WORK, env={"PATH": "/usr/bin:/bin"})
    took = processor_s() - before
    print("# a picture after %.0f s, %.0f s of them by the processor" % (time.monotonic() - begin, took))
    with open(os.path.join(WORK, "wire.png"), "rb") as file:
        return good and took < LIMIT_S and file.read(8) == b"\x89PNG\r\n\x1a\n"


def gymnasium_makes_the_environments():
    pins = [line for line in tree.read("host/python/requirements.txt").split("\n") if "==" in line]
    python = os.path.join(EMPTY, "bin", "python")
    needs = [pin for pin in pins if re.match("cloudpickle|Farama|gymnasium|typing", pin)]
    script = (
        "import cournand.envs, gymnasium as g; e = g.make('cournand/Aorta-v0'); e.reset(seed=1);"
        "e.step(e.action_space.sample());"
        "g.make('cournand.envs:cournand/ArchBranch-v0');"
        "v = g.make_vec('cournand/Aorta-v0', num_envs=2, vectorization_mode='vector_entry_point'); v.reset(seed=1)"
    )
    return succeeds([python, "-m", "pip", "install", "--quiet", "--no-deps", *needs]) and succeeds(
        [python, "-c", script], cwd=WORK
    )


def the_notebook_runs():
    script = (
        "import nbformat, nbclient, sys; n = nbformat.read(sys.argv[1], 4);"
        "nbclient.NotebookClient(n, timeout=300, kernel_name='python3').execute();"
        "print(''.join(o.get('text', '') for c in n.cells for o in c.get('outputs', [])))"
    )
    notebook = os.path.join(prepare.ROOT, "host", "python", "examples", "branches.ipynb")
    more = dict(TOOLS, PYTHONPATH=os.path.join(WORK, "opened"), JUPYTER_PLATFORM_DIRS="1", IPYTHONDIR=WORK)
    return succeeds([PYTHON, "-c", script, notebook], cwd=WORK, env=more)


def the_types_hold():
    package = os.path.join(prepare.ROOT, "host", "python", "cournand")
    more = dict(TOOLS, MYPYPATH=os.path.join(WORK, "opened"))
    words = [PYTHON, "-m", "mypy", "--strict", "--cache-dir", os.path.join(WORK, "mypy"), "-p", "cournand"]
    words += ["--disable-error-code", "type-arg"]  # tuples of the generated stub
    return os.path.isdir(package) and succeeds(words, cwd=WORK, env=more)


tap.run(
    [
        wheel.pip_makes_a_wheel,
        wheel.auditwheel_completes_the_wheel,
        the_wheel_carries_what_it_needs_and_nothing_else,
        an_empty_environment_has_a_picture_in_a_minute,
        gymnasium_makes_the_environments,
        the_notebook_runs,
        the_types_hold,
    ]
)
