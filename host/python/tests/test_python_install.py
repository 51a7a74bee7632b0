#!/usr/bin/env python3
"""`pip install .` in an empty virtual environment compiles the C library and the module from source, as for a user, and
the five lines of the README make a picture. The test compiles for minutes, so it has the label `hours`. Prints TAP."""

import os
import re
import subprocess
import sys
import tempfile
import venv

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402
import tree  # noqa: E402


def pip_install_compiles_everything_and_gives_a_picture():
    example = re.search(r"```python\n(.*?)```", tree.read("README.md"), re.S).group(1)
    with tempfile.TemporaryDirectory() as folder:
        venv.create(os.path.join(folder, "venv"), with_pip=True)
        python = os.path.join(folder, "venv", "bin", "python")
        place = "build-dir=" + os.path.join(folder, "build")
        words = [python, "-m", "pip", "install", "--config-settings", place, prepare.ROOT]
        for command in (words, [python, "-c", example]):
            ended = subprocess.run(
                command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, text=True
            )
            if ended.returncode != 0:
                print("# " + ended.stdout.replace("\n", "\n# "))
                return False
        return os.path.getsize(os.path.join(folder, "wire.png")) > 1000


tap.run([pip_install_compiles_everything_and_gives_a_picture])
