"""Makes the scenes of the shipped anatomies for tests, and keeps them below the build folder, so that each scene is
made only once for all tests. A scene is made anew when a program that makes it or an input of the scene changes."""

import fcntl
import glob
import hashlib
import os
import re
import shutil
import subprocess
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
ANATOMIES = os.path.join(glob.escape(ROOT), "shared/examples/anatomies/*")
PROGRAMS = ("anatomy", "bake")
BODIES = "--no-bodies"
CHECKS = ("--points", "1000", "--poses", "0")


class CannotMake(Exception):
    """The text of the exception is the output of the program that failed."""


def lesion_text(lesion):
    """Returns the lesion's table for a scene that has no bodies, without the line `inside`, which names a body."""
    with open(os.path.join(ROOT, "shared/examples/lesions", lesion + ".toml"), encoding="utf-8") as file:
        return re.sub(r"(?m)^inside = .*\n", "", file.read())


def key_of(build, anatomy, lesion):
    """Returns a hash of everything that determines the scene: both programs, their options, the texts of the shipped
    anatomies, and the lesion's text."""
    digest = hashlib.sha256(repr((anatomy, BODIES, CHECKS, lesion and lesion_text(lesion))).encode())
    for path in [f"{build}/bin/{program}" for program in PROGRAMS] + sorted(glob.glob(ANATOMIES)):
        with open(path, "rb") as file:
            digest.update(hashlib.sha256(file.read()).digest())
    return digest.hexdigest()[:16]


def call(*words):
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        raise CannotMake(done.stdout)


def make(build, anatomy, lesion, folder):
    """Makes the scene as `make scene` does, but without the bodies, which only pictures need. Writes the files that
    belong to the scene into the folder."""
    with tempfile.TemporaryDirectory(prefix="cournand_scene_") as work:
        made, text = f"{work}/{anatomy}", f"{work}/{anatomy}/scene.toml"
        call(f"{build}/bin/anatomy", anatomy, BODIES, "--quiet", "-o", made)
        if lesion:
            with open(text, "a", encoding="utf-8") as file:
                file.write(lesion_text(lesion))
        call(f"{build}/bin/bake", text, *CHECKS, "-o", os.path.join(folder, (lesion or anatomy) + ".scene"))


def scene(build, anatomy, lesion=None, maker=make):
    """Returns the path of the kept scene, which callers must not change. The first caller makes the scene; another test
    that asks for the same scene meanwhile waits until it is made."""
    name = f"{anatomy}+{lesion}" if lesion else anatomy
    kept = os.path.join(build, "test_scenes")
    os.makedirs(kept, exist_ok=True)
    folder = os.path.join(kept, f"{name}-{key_of(build, anatomy, lesion)}")
    with open(os.path.join(kept, name + ".lock"), "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not os.path.exists(folder):
            for old in glob.glob(os.path.join(glob.escape(kept), glob.escape(name) + "-*")):
                shutil.rmtree(old)
            part = tempfile.mkdtemp(prefix=name + "-", dir=kept)
            try:
                maker(build, anatomy, lesion, part)
                os.rename(part, folder)
            finally:
                shutil.rmtree(part, ignore_errors=True)
    return os.path.join(folder, (lesion or anatomy) + ".scene")
