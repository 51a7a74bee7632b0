#!/usr/bin/env python3
"""Tests the scenes that several tests share: each scene is made only once, even if several tests ask for it at the same
time. A scene is made anew after a program or an input has changed. If a scene cannot be made, nothing is kept in its
place. Prints TAP.

Small programs stand in for `anatomy` and `bake`, because only the contents of the program files matter here.
The script test_sessions.py makes real scenes.
"""

import concurrent.futures
import os
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import made_scenes  # noqa: E402
import tree  # noqa: E402


class Bench:
    """Makes a build folder with two substitute programs; its function `maker` counts its own calls."""

    def __init__(self, folder):
        self.build = folder
        self.made = []
        os.mkdir(os.path.join(folder, "bin"))
        for program in made_scenes.PROGRAMS:
            self.change(program, "first")

    def change(self, program, text):
        with open(os.path.join(self.build, "bin", program), "w", encoding="utf-8") as file:
            file.write(text)

    def maker(self, _, anatomy, lesion, folder):
        time.sleep(0.05)
        self.made.append((anatomy, lesion))
        with open(os.path.join(folder, (lesion or anatomy) + ".scene"), "w", encoding="utf-8") as file:
            file.write("scene %d" % len(self.made))

    def text(self, anatomy, lesion=None):
        with open(made_scenes.scene(self.build, anatomy, lesion, self.maker), encoding="utf-8") as file:
            return file.read()

    def kept(self):
        return sorted(os.listdir(os.path.join(self.build, "test_scenes")))


def same(got, wanted):
    return [] if got == wanted else ["is %r, wanted %r" % (got, wanted)]


def check_sharing(report, bench):
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        texts = list(pool.map(lambda _: bench.text("aorta"), range(8)))
    report.check("eight callers at once make the scene once", same((set(texts), len(bench.made)), ({"scene 1"}, 1)))
    report.check("another lesion is another scene", same(bench.text("aorta", "renal_ostium"), "scene 2"))
    both = (bench.text("aorta"), bench.text("aorta", "renal_ostium"))
    report.check("both are kept", same(both, ("scene 1", "scene 2")))


def check_changes(report, bench):
    for program in made_scenes.PROGRAMS:
        count = len(bench.made)
        bench.change(program, "second")
        report.check("a change of %s makes it anew" % program, same(bench.text("aorta"), "scene %d" % (count + 1)))
    known, made_scenes.ANATOMIES = made_scenes.ANATOMIES, os.path.join(bench.build, "bin", "bake")
    report.check("so does a change of the anatomies' texts", same(bench.text("aorta"), "scene 5"))
    made_scenes.ANATOMIES = known
    scenes = [name for name in bench.kept() if not name.endswith(".lock")]
    report.check("only the newest scene of an anatomy is kept", same(len(scenes), 2))


def check_failure(report, bench):
    def fails(*_):
        raise made_scenes.CannotMake("no disk")

    bench.change("bake", "third")
    before = len(bench.made)
    try:
        made_scenes.scene(bench.build, "aorta", None, fails)
        said = ""
    except made_scenes.CannotMake as problem:
        said = str(problem)
    report.check("a maker that fails is reported", same(said, "no disk"))
    report.check("it leaves no folder", same([name for name in bench.kept() if name.startswith("aorta-")], []))
    report.check("and the next caller makes the scene", same(bench.text("aorta"), "scene %d" % (before + 1)))


def main():
    report = tree.Report()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(folder)
        check_sharing(report, bench)
        check_changes(report, bench)
        check_failure(report, bench)
    report.end()


if __name__ == "__main__":
    main()
