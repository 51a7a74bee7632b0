"""Runs shipped sessions, with and without their turns, for tests that print TAP."""

import os
import re
import shutil
import subprocess
import sys
import tempfile

import made_scenes

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
BUILD = os.environ.get("BUILD", "build")
TURN = re.compile(r"^\s*(steer|engage|rotate)\b")
WITH_TURN = re.compile(r"\s+while\s+rotate\b.*")
EXPECTS = re.compile(r"^\s*expect\b", re.M)


def without_turns(text):
    """Returns the script of a session without the commands that turn or steer a tool or make it engage an ostium."""
    kept = [WITH_TURN.sub("", line) for line in text.splitlines() if not TURN.match(line)]
    return "\n".join(kept) + "\n"


def unpack_shipped(folder):
    """Unpacks the shipped scene into the folder, and returns the scene's path."""
    program, archive = "tools/scenes/shipped.py", "shared/examples/scenes/aorta.tar.xz"
    subprocess.run([os.path.join(ROOT, program), "unpack", os.path.join(ROOT, archive), "-o", folder], check=True)
    return os.path.join(folder, "aorta.scene")


class Sessions:
    """Runs sessions, which write their outputs into a temporary folder, and counts the passed and failed tests."""

    def __enter__(self):
        self.folder = tempfile.mkdtemp(prefix="cournand_sessions_")
        self.number = self.failed = 0
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.folder, ignore_errors=True)

    def result(self, is_good, name, why=""):
        """Prints one line of TAP."""
        self.number += 1
        self.failed += not is_good
        if not is_good:
            for line in why.splitlines()[-12:]:
                print("#", line)
        print(("ok" if is_good else "not ok"), self.number, "-", name, flush=True)

    def call(self, program, *words):
        """Runs a command and returns its exit code and its whole output."""
        done = subprocess.run(
            [f"{BUILD}/bin/{program}", *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
        )
        return done.returncode, done.stdout

    def scene(self, anatomy, lesion=None):
        """Returns the path of the scene of the shipped anatomy without its bodies (made_scenes.py). If a lesion of
        shared/examples/lesions is named, the scene contains this lesion."""
        try:
            return made_scenes.scene(BUILD, anatomy, lesion)
        except made_scenes.CannotMake as problem:
            self.result(False, f"{anatomy}_is_made", str(problem))
            self.end()

    def run(self, script, scene, tools, stent=None):
        """Runs one session without pictures, and returns its exit code and its whole output."""
        words = ["--scene", scene] if scene else []
        for tool in tools:
            words += ["--tool", f"shared/examples/instruments/{tool}.toml"]
        if stent:
            words += ["--stent", f"shared/examples/stents/{stent}.toml"]
        return self.call("cournand", "run", "--quiet", *words, "--session", script)

    def reaches(self, name, scene, tools, stent=None):
        """Tests that the session's script states an expected end, and that the session reaches it."""
        path = f"shared/examples/{name}.session"
        with open(path, encoding="utf-8") as file:
            text = file.read()
        code, said = self.run(path, scene, tools, stent)
        short = name.split("/")[1]
        self.result(code == 0 and EXPECTS.search(text) is not None, f"{short}_reaches_the_end_that_it_states", said)

    def misses(self, name, scene, tools, stent=None):
        """Tests that the session fails at an expectation of its script if the tools are not turned."""
        with open(f"shared/examples/{name}.session", encoding="utf-8") as file:
            text = file.read()
        short = name.split("/")[1]
        stripped = without_turns(text)
        if stripped == text.rstrip("\n") + "\n":
            return  # only pushes
        script = f"{self.folder}/{short}.session"
        with open(script, "w", encoding="utf-8") as file:
            file.write(stripped)
        code, said = self.run(script, scene, tools, stent)
        self.result(code == 1 and ": expected " in said, f"{short}_without_its_turns_misses_it", said)

    def starts(self, scene):
        """Tests that a session can begin with each shipped instrument if no inserted length is given."""
        script = f"{self.folder}/start.session"
        with open(script, "w", encoding="utf-8") as file:
            file.write("wait 20 ms\n")
        failures = []
        for name in sorted(os.listdir("shared/examples/instruments")):
            code, said = self.run(script, scene, [name[: -len(".toml")]])
            if code != 0:
                failures.append(f"{name}: {said}")
        name = os.path.basename(scene)[: -len(".scene")]
        self.result(not failures, f"every_tool_that_ships_can_start_in_{name}", "\n".join(failures))

    def changed(self, name, scene, tool, change, replacements):
        """Tests that the session also reaches its expected end with a different instrument."""
        with open(f"shared/examples/instruments/{tool}.toml", encoding="utf-8") as file:
            text = file.read()
        for old, new in replacements.items():
            assert old in text, old
            text = text.replace(old, new)
        path = f"{self.folder}/{change}.toml"
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        code, said = self.call(
            "cournand",
            "run",
            "--quiet",
            "--scene",
            scene,
            "--tool",
            path,
            "--session",
            f"shared/examples/{name}.session",
        )
        self.result(code == 0, f"{name.split('/')[1]}_reaches_its_end_with_{change}", said)

    def end(self):
        """Prints the TAP plan and returns the exit code."""
        print(f"1..{self.number}")
        sys.exit(1 if self.failed else 0)


AORTA = ["j_wire"]
CASES = {  # session: tools
    "sessions/demo": AORTA,
    "sessions/iliac_to_arch": AORTA,
    "sessions/room": AORTA,
    "sessions/over_the_wire": ["bentson", "beacon_5f"],
    "sessions/renal": ["bentson", "pigtail_5f"],
    "gallery/arch": AORTA,
    "gallery/pelvis": AORTA,
    "gallery/chest": AORTA,
    "gallery/loin": AORTA,
    "gallery/spine": AORTA,
}


def aorta(run, test):
    """Calls the function `test` (run.reaches or run.misses) for every session that is in the aorta or has no scene.
    Returns the path of the shipped scene."""
    scene = unpack_shipped(run.folder)
    test("sessions/free_space", "", AORTA)
    for name, tools in CASES.items():
        test(name, scene, tools)
    test(
        "sessions/pci_renal",
        run.scene("aorta", "renal_ostium"),
        ["j_wire", "terumo_stiff_angled", "balloon_6x20", "guide_jr4_6f"],
        "renal_6_0x18",
    )
    return scene


def angioplasty(run, test):
    """Calls the function `test` for the whole angioplasty of the LAD."""
    tools = ["j_wire", "coronary_014", "balloon_3x20", "guide_jl3_6f"]
    test("sessions/pci_lad", run.scene("heart", "lad_middle"), tools, "coronary_3_0x18")


def heart(run, test):
    """Calls the function `test` (run.reaches or run.misses) for every session in the beating heart except the
    angioplasty. Returns the path of the heart's scene."""
    scene = run.scene("heart", "lad_middle")
    test("sessions/coronary", scene, ["j_wire", "guide_jl3_6f"])
    test("sessions/coronary_right", scene, ["j_wire", "guide_ntr_6f"])
    return scene
