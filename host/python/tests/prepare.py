"""Prepares the tests of the Python package: makes a virtual environment with the pinned packages of requirements.txt,
and builds the module with the static library of the build folder; both are below BUILD/python.

A test calls enter(), which continues the test in that environment.
"""

import fcntl
import hashlib
import os
import shutil
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import pinned_environment  # noqa: E402

BUILD = os.path.join(ROOT, os.environ.get("BUILD", "build"))
FOLDER = os.path.join(BUILD, "python")
SITE = os.path.join(FOLDER, "site")
REQUIREMENTS = os.path.join(ROOT, "host", "python", "requirements.txt")


def run(words, **more):
    """Runs a command without printing its output; if it fails, prints the output and ends the program."""
    ended = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, **more)
    if ended.returncode != 0:
        sys.exit("%s\n%s: exit code %d" % (ended.stdout.decode(errors="replace"), " ".join(words), ended.returncode))
    return ended.stdout.decode(errors="replace")


def environment(folder, requirements, with_debian=False):
    """Makes a virtual environment with pinned packages, unless it exists already, and returns the path of its
    Python."""
    try:
        return pinned_environment.make(folder, requirements, with_debian=with_debian)
    except pinned_environment.EnvironmentFault as fault:
        sys.exit(str(fault))
    except pinned_environment.PackagesFault as fault:
        sys.exit(
            "%s\nPyPI could not be reached, or a version of %s is gone. Remedy: run this test once with a network, or "
            "set PIP_NO_INDEX=1 and PIP_FIND_LINKS=FOLDER for a folder of wheels that `pip download -r` has filled."
            % (fault, os.path.relpath(requirements, ROOT))
        )


def build(python):
    """Builds the module, and installs the package into SITE."""
    module = os.path.join(FOLDER, "module")
    library = os.path.join(BUILD, "lib", "libcournand.a")
    if not os.path.exists(library):
        sys.exit("%s does not exist. Remedy: tools/build.sh release run cournand_library" % library)
    if not os.path.exists(os.path.join(module, "build.ninja")):
        words = ["cmake", "-G", "Ninja", "-S", os.path.join(ROOT, "host", "python", "module"), "-B", module]
        run(words + ["-DPython_EXECUTABLE=" + python, "-DCOURNAND_LIBRARY=" + library])
    run(["ninja", "-C", module])
    shutil.rmtree(SITE, ignore_errors=True)
    run(["cmake", "--install", module, "--prefix", SITE])


def prepare():
    """Builds everything once, even if several tests begin at the same time, and returns the path of the environment's
    Python."""
    os.makedirs(FOLDER, exist_ok=True)
    with open(os.path.join(FOLDER, "lock"), "w", encoding="ascii") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        python = environment(os.path.join(FOLDER, "venv"), REQUIREMENTS)
        newest = os.path.join(FOLDER, "built.sha256")
        state = digest()
        if not os.path.exists(newest) or open(newest, encoding="ascii").read() != state:
            build(python)
            with open(newest, "w", encoding="ascii") as file:
                file.write(state)
    return python


def sources():
    """Returns the path of every source file of the package."""
    places = ["host/python/cournand", "host/python/module", "shared/examples/instruments", "shared/examples/stents"]
    single = ["host/library/cournand.h", "host/library/cournand_play.h"]
    single += ["shared/version.h", "shared/examples/scenes/aorta.tar.xz"]
    files = [REQUIREMENTS, os.path.join(BUILD, "lib", "libcournand.a")] + [os.path.join(ROOT, one) for one in single]
    for place in places:
        for folder, folders, names in os.walk(os.path.join(ROOT, place)):
            folders[:] = sorted(one for one in folders if one != "__pycache__")
            files += [os.path.join(folder, name) for name in sorted(names)]
    return files


def digest():
    """Returns a hash of all source files of the package."""
    hashed = hashlib.sha256()
    for path in sources():
        with open(path, "rb") as file:
            hashed.update(hashlib.sha256(file.read()).digest() + path.encode())
    return hashed.hexdigest()


def joined(more):
    """Returns the path of a requirements file that combines the packages of the tests with those of another file."""
    path = os.path.join(FOLDER, more)
    text = ""
    for name in ("requirements.txt", more):
        with open(os.path.join(ROOT, "host", "python", name), encoding="utf-8") as file:
            text += file.read()
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def enter(script, more=None):
    """Continues a test script in the environment of the package, unless it is there already. `more` names a file with
    additional packages; there is a separate environment for them."""
    if os.environ.get("COURNAND_PYTHON_TEST") == script:
        return
    python = prepare()
    if more is not None:
        python = environment(os.path.join(FOLDER, more.removesuffix(".txt")), joined(more))
    names = dict(os.environ, COURNAND_PYTHON_TEST=script, PYTHONPATH=SITE, PYTHONDONTWRITEBYTECODE="1")
    sys.stdout.flush()
    os.execve(python, [python, script] + sys.argv[1:], names)


def deep():
    """Makes the environment of the deep baseline, and returns the path of its Python. The caller is Debian's Python,
    whose PyTorch and NumPy the environment also sees."""
    more = os.path.join(ROOT, "host", "python", "requirements-deep.txt")
    return environment(os.path.join(FOLDER, "deep"), more, with_debian=True)


def enter_deep(script):
    """Continues a test script of Debian's Python in the environment of the deep baseline, which also sees Debian's
    PyTorch and NumPy, unless it is there already."""
    if os.environ.get("COURNAND_PYTHON_TEST") == script:
        return
    prepare()
    python = deep()
    names = dict(os.environ, COURNAND_PYTHON_TEST=script, PYTHONPATH=SITE, PYTHONDONTWRITEBYTECODE="1")
    sys.stdout.flush()
    os.execve(python, [python, script] + sys.argv[1:], dict(names, OMP_NUM_THREADS="1"))


if __name__ == "__main__":
    print(prepare())
