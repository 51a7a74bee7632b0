#!/usr/bin/env python3
"""Measures the cost of a first build: the processor time, compiled files and packages of `make run`, and the processor
time of `make test`.

  build_cost.py [--test] [--write out/bench.tsv]

The program clones the last commit into a temporary folder and builds the clone without a compiler cache. The results
are lines `name<TAB>value<TAB>unit <TAB>context`. The value build.run_cpu_s is the processor time for compiling and
linking in `make run`. The value build.run_units is the number of compiled files. The value build.run_packages_mb is the
size of the archives that a minimal Debian 12 must download. With --test, build.test_cpu_s is the processor time of
`make test` in a clean folder. The value build.test_again_cpu_s is the time of `make test` after a change of one file of
host/xray. With --write the program puts its result lines into FILE and removes older lines with the same names. The
exit code is 1 when a build fails.
"""

import argparse
import json
import os
import re
import resource
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
MINIMAL = "Priority: required"  # what debootstrap --variant=minbase installs, besides apt
TOUCHED = "host/xray/chain.cpp"


class CannotMeasure(Exception):
    """The text says why."""


def spent(command, folder):
    """Runs a command and returns the processor seconds that the command and all its child processes used."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("CCACHE", "MAKE", "BUILD", "CMAKE"))}
    environment["CMAKE_ARGS"] = "-DCRN_CCACHE=OFF"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=folder, env=environment, stdout=sys.stderr, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise CannotMeasure("`%s` ended with %d" % (" ".join(command), done.returncode))
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def section(*names):
    """Packages of sections of tools/packages.txt."""
    found, on = [], False
    with open(os.path.join(ROOT, "tools", "packages.txt"), encoding="utf-8") as file:
        for line in file.read().split("\n"):
            if line.startswith("["):
                on = line.strip("[]") in names
            elif on and line and not line.startswith("#"):
                found.append(line.strip())
    return found


def archives(packages):
    """Returns the size in bytes of each file that apt would download for the given packages on a machine without any
    installed package."""
    with tempfile.NamedTemporaryFile() as empty:
        command = ["apt-get", "install", "--print-uris", "--no-install-recommends", "-qq", "-o", "Debug::NoLocking=1"]
        done = subprocess.run(
            [*command, "-o", "Dir::State::status=" + empty.name, *packages],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    if done.returncode != 0:
        raise CannotMeasure("apt-get: " + done.stderr.strip())
    return {name: int(size) for name, size in re.findall(r"^'\S+' (\S+\.deb) (\d+)", done.stdout, re.M)}


def packages_mb():
    listed = subprocess.run(["apt-cache", "dumpavail"], stdout=subprocess.PIPE, text=True, check=True).stdout
    minimal = [re.search(r"^Package: (\S+)", one, re.M).group(1) for one in listed.split("\n\n") if MINIMAL in one]
    wanted, base = archives(section("build") + ["apt"]), archives(minimal + ["apt"])
    return sum(size for name, size in wanted.items() if name not in base) / 1e6


def rows(options, folder):
    clone = os.path.join(folder, "clone")
    subprocess.run(["git", "clone", "-q", ROOT, clone], check=True)
    cpu_s = spent(["tools/build.sh", "release", "run", "cournand"], clone)
    with open(os.path.join(clone, "build", "compile_commands.json"), encoding="utf-8") as file:
        units = len(json.load(file))
    context = "%d cores, no cache" % os.cpu_count()
    yield "build.run_cpu_s", "%.0f" % cpu_s, "s", context
    yield "build.run_units", "%d" % units, "files", ""
    yield "build.run_packages_mb", "%.0f" % packages_mb(), "MB", "to download on a minimal Debian 12"
    if options.test:
        # `make test` counts from clean, so the cost of what `make run` has built is added.
        yield "build.test_cpu_s", "%.0f" % (cpu_s + spent(["make", "PACKAGES=skip", "test"], clone)), "s", context
        os.utime(os.path.join(clone, TOUCHED))
        yield "build.test_again_cpu_s", "%.0f" % spent(["tools/check/run_tests.sh", "build"], clone), "s", TOUCHED


def write(path, lines):
    kept = []
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            kept = [line for line in file.read().splitlines() if not line.startswith("build.")]
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(kept + lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--test", action="store_true", help="also make test, twice (20 minutes)")
    parser.add_argument("--write", metavar="FILE")
    options = parser.parse_args()
    lines = []
    try:
        with tempfile.TemporaryDirectory() as folder:
            for row in rows(options, folder):
                lines.append("\t".join(row))
                print(lines[-1], flush=True)
    except CannotMeasure as problem:
        print("build_cost: %s" % problem, file=sys.stderr)
        return 1
    if options.write:
        write(options.write, lines)
    return 0


if __name__ == "__main__":
    sys.exit(main())
