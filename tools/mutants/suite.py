"""The tests that mutants are shown to: CMocka programs of firmware/tests one test at a time, and the cases of the
validation suite. Tests that look at a hash of the state are left out, because a hash notices every change and would not
show whether a test knows the physics."""

import dataclasses
import os
import re
import resource
import shlex
import subprocess

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
UNITS = (
    "vector fixed line length tip rod tools lumen motion rhythm lesion strut balloon near exchange tools_friction set "
    "wall/wall"
).split()
VALIDATE = "validate"
CORE_ARCHIVE = "lib/libfirmware_core.a"
FUNCTION = re.compile(r"^(?:static )?[a-z_0-9 \*]*?\b(\w+)\([^;{}]*\)\n\{\n.*?^\}\n", re.M | re.S)
LISTED = re.compile(r"cmocka_unit_test\w*\(\s*(\w+)")


class CannotRun(Exception):
    """A program is missing, or does not build or link."""


@dataclasses.dataclass(frozen=True)
class Test:
    program: str  # target of the build
    name: str

    def __str__(self):
        return "%s: %s" % (self.program.replace("test_firmware_tests_", ""), self.name)


def tests_of_source(text):
    """Returns the tests that a CMocka source lists, and those of them that use a hash of the state, directly or through
    other functions of the file."""
    bodies = {found[1]: found[0] for found in FUNCTION.finditer(text)}
    hashed = {name for name, body in bodies.items() if "hash" in body}
    while True:
        more = {
            name
            for name, body in bodies.items()
            if name not in hashed | {"main"}
            and hashed - {"main"}
            and re.search(r"\b(%s)\(" % "|".join(hashed - {"main"}), body)
        }
        if not more:
            break
        hashed |= more
    listed = LISTED.findall(text)
    return listed, [name for name in listed if name in hashed or "hash" in name]


def unit_tests(units=UNITS):
    """Returns the tests of firmware/tests without a hash, and the names of the others."""
    tests, excluded = [], []
    for unit in units:
        folder, name = os.path.split(unit)
        with open(os.path.join(ROOT, "firmware", "tests", folder, "test_%s.c" % name), encoding="utf-8") as file:
            listed, hashed = tests_of_source(file.read())
        program = "test_firmware_tests_%stest_%s" % (folder + "_" if folder else "", name)
        tests += [Test(program, name) for name in listed if name not in hashed]
        excluded += [Test(program, name) for name in hashed]
    return tests, excluded


def output_of(command, **options):
    run = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if run.returncode != 0:
        raise CannotRun("%s\n%s%s" % (shlex.join(command), run.stdout[-2000:], run.stderr[-2000:]))
    return run.stdout


class Programs:
    """The test programs, linked to the core as a shared library, so that a mutant needs one link only."""

    def __init__(self, build, folder, library):
        self.build, self.folder, self.library = build, folder, library
        os.makedirs(folder, exist_ok=True)

    def path(self, program):
        return os.path.join(self.folder, program)

    def filter_object(self):
        path = os.path.join(self.folder, "one_test.o")
        output_of(["cc", "-O1", "-fPIC", "-c", os.path.join(HERE, "tests", "one_test.c"), "-o", path])
        return path

    def link(self, program):
        """Links a program as the build does, with the shared core in the place of the archive."""
        line = output_of(["ninja", "-C", self.build, "-t", "commands", program]).strip().split("\n")[-1]
        steps = [step for step in line.split("&&") if " -o " in step]
        if not steps or CORE_ARCHIVE not in steps[0]:
            raise CannotRun("%s: the build's command does not link %s:\n%s" % (program, CORE_ARCHIVE, line))
        words = shlex.split(steps[0])
        words[words.index("-o") + 1] = self.path(program)
        words[words.index(CORE_ARCHIVE)] = self.library
        if program != VALIDATE:
            words.append(self.filter_object())
        output_of(words, cwd=self.build)

    def cases(self):
        text = output_of([self.path(VALIDATE), "--list"], env=self.environment(self.library))
        return [Test(VALIDATE, name) for name in text.split()]

    def environment(self, library, **more):
        return {**os.environ, "LD_LIBRARY_PATH": os.path.dirname(library), **more}

    def run(self, test, library, limit_s):
        """Runs a test with a core. Returns (what made it fail or "", its seconds of processor time)."""
        command = [self.path(test.program)]
        more = {"CMOCKA_MESSAGE_OUTPUT": "TAP"}
        if test.program == VALIDATE:
            command += ["--quick", "--tap", "--jobs", "1", "--only", test.name]
        else:
            more["MUTANT_TEST"] = test.name
        limits = lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit_s, limit_s + 5))  # noqa: E731
        process = subprocess.Popen(
            command,
            cwd=ROOT,
            env=self.environment(library, **more),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            preexec_fn=limits,
        )
        output = process.stdout.read().decode(errors="replace")
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        used_s = usage.ru_utime + usage.ru_stime
        if process.returncode < 0:
            is_late = used_s >= limit_s - 0.5
            return ("no end after %d s" % limit_s if is_late else "signal %d" % -process.returncode), used_s
        if process.returncode == 0:
            if not re.search(r"^ok ", output, re.M):
                raise CannotRun("%s ran no test:\n%s" % (test, output[-1000:]))
            return "", used_s
        return reason_of(output), used_s


def reason_of(output):
    """Returns the line that says why a test failed."""
    lines = [line.lstrip("# ").strip() for line in output.split("\n") if not line.startswith(("ok ", "1.."))]
    lines = [line for line in lines if line and not line.startswith(("not ok", "[ "))]
    return (lines[0] if lines else "failed")[:160]
