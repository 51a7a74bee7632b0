"""Makes the wheel of the Python package for the tests that install it, completed with auditwheel, and downloads what it
needs from PyPI."""

import glob
import os
import re
import shutil
import subprocess
import sys

import prepare

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tree  # noqa: E402

WORK = os.path.join(prepare.FOLDER, os.path.basename(sys.argv[0]).removesuffix(".py"))  # each test has its own
LAB = os.path.join(prepare.FOLDER, "requirements-lab.txt")


def environment():
    """Returns the path of the Python of a virtual environment with the tools of these tests."""
    os.makedirs(prepare.FOLDER, exist_ok=True)
    pinned = "".join(tree.read("host/python/requirements%s.txt" % name) for name in ("", "-lab"))
    if not os.path.exists(LAB) or open(LAB, encoding="utf-8").read() != pinned:
        with open(LAB, "w", encoding="utf-8") as file:
            file.write(pinned)
    return prepare.environment(os.path.join(prepare.FOLDER, "lab"), LAB)


PYTHON = environment()
TOOLS = dict(os.environ, PATH=os.path.dirname(PYTHON) + os.pathsep + os.environ["PATH"])


def succeeds(words, **more):
    """Runs a command, prints its output if it fails, and returns whether it succeeded."""
    ended = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, **more)
    if ended.returncode != 0:
        print("# " + ended.stdout.decode(errors="replace").replace("\n", "\n# "))
    return ended.returncode == 0


def found(pattern):
    """Returns the path of the only file below WORK that matches the pattern, or None."""
    names = glob.glob(os.path.join(WORK, pattern))
    return names[0] if len(names) == 1 else None


def pip_makes_a_wheel():
    """Makes the wheel in WORK."""
    shutil.rmtree(WORK, ignore_errors=True)
    words = [PYTHON, "-m", "pip", "wheel", ".", "--no-deps", "--no-build-isolation", "--wheel-dir", WORK]
    library = os.path.join(prepare.BUILD, "lib", "libcournand.a")
    words += ["--config-settings", "cmake.define.COURNAND_LIBRARY=" + library]  # Debian's pip does not know -C
    words += ["--config-settings", "build-dir=" + os.path.join(WORK, "build")]
    return succeeds(words, cwd=prepare.ROOT, env=TOOLS) and found("cournand-*-cp310-abi3-linux_x86_64.whl")


def auditwheel_completes_the_wheel():
    """Adds to the wheel the libraries that a user's machine may lack; the result is in WORK/complete."""
    words = [PYTHON, "-m", "auditwheel", "repair", str(found("*.whl")), "--wheel-dir", os.path.join(WORK, "complete")]
    return succeeds(words, env=TOOLS) and found("complete/*-manylinux_2_3*_x86_64.whl")


def downloaded():
    """Downloads the packages that the wheel needs, and returns their folder, or None if this failed."""
    names = ("numpy==", "nanobind-b")
    needs = [line for line in tree.read("host/python/requirements.txt").split() if line.startswith(names)]
    folder = os.path.join(WORK, "downloaded")
    words = [PYTHON, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", folder]
    return folder if succeeds(words + needs) else None


def five_lines():
    """Returns the Python example of the README."""
    return re.search(r"```python\n(.*?)```", tree.read("README.md"), re.S).group(1)
