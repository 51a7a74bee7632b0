#!/usr/bin/env python3
"""These tests check the following. The shipped scene equals the scene that the tools make today, and a damaged
archive leaves no file behind. Prints TAP.

The test makes the scene without its bodies and with few checks, because neither bodies nor checks change the scene's
bytes. `make scene` also compares the bodies.
"""

import os
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools", "scenes"), os.path.join(ROOT, "tools", "check")]
import shipped  # noqa: E402
import tree  # noqa: E402

BUILD = os.environ.get("BUILD", "build")
ARCHIVE = "shared/examples/scenes/aorta.tar.xz"


def run(*words):
    done = subprocess.run(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.returncode, done.stdout


def made_scene(folder):
    """Makes the scene of the aorta and returns the bytes of aorta.scene, or a sentence that states the error."""
    for words in (
        ["%s/bin/anatomy" % BUILD, "aorta", "--no-bodies", "--quiet", "-o", folder + "/aorta"],
        [
            "%s/bin/bake" % BUILD,
            folder + "/aorta/scene.toml",
            "--points",
            "1000",
            "--poses",
            "0",
            "-o",
            folder + "/aorta.scene",
        ],
    ):
        code, said = run(*words)
        if code != 0:
            return said
    with open(folder + "/aorta.scene", "rb") as file:
        return file.read()


def check_scene(report, folder):
    files = shipped.read_archive(os.path.join(ROOT, ARCHIVE))
    report.check(
        "a scene and its bodies ship", [] if sorted(files) == ["aorta.bodies", "aorta.scene"] else [str(sorted(files))]
    )
    made = made_scene(folder)
    report.check(
        "the scene that ships has the bytes of the one that the tools make (make scene ACCEPT=1 ships a new one)",
        [made] if isinstance(made, str) else list(shipped.differences({"s": files["aorta.scene"]}, {"s": made})),
    )
    out = os.path.join(folder, "out")
    code, said = run("tools/scenes/shipped.py", "unpack", ARCHIVE, "-o", out)
    report.check("it is unpacked", [] if code == 0 and sorted(os.listdir(out)) == sorted(files) else [said])
    return files


def check_archives(report, folder, files):
    path = os.path.join(folder, "again.tar.xz")
    shipped.write_archive(path, files)
    with open(path, "rb") as file, open(os.path.join(ROOT, ARCHIVE), "rb") as other:
        data = file.read()
        report.check("the same files give the same archive", [] if data == other.read() else ["it differs"])
    for name, broken in (
        ("cut", data[: len(data) // 2]),
        ("empty", b""),
        ("flipped", data[:5000] + b"x" + data[5001:]),
    ):
        with open(path, "wb") as file:
            file.write(broken)
        code, said = run("tools/scenes/shipped.py", "unpack", path, "-o", os.path.join(folder, name))
        left = os.path.exists(os.path.join(folder, name))
        report.check(
            "an archive that is %s is refused, and nothing is written" % name,
            [] if code == 1 and "cannot be read" in said and "make scene" in said and not left else [said],
        )
    report.catches("a scene that differs is named", shipped.differences({"a": b"1"}, {"a": b"2"}))


def main():
    report = tree.Report()
    with tempfile.TemporaryDirectory() as folder:
        check_archives(report, folder, check_scene(report, folder))
    report.end()


if __name__ == "__main__":
    main()
