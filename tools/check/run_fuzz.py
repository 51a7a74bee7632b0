#!/usr/bin/env python3
"""Runs libFuzzer targets. `make fuzz` calls this program, and run_tests.py calls it for a few seconds per target.

  run_fuzz.py --build build/san --seconds 60 --jobs 2 NAME...      this long each
  run_fuzz.py --build build/san --executions 5000000 NAME...       this many inputs each, however long it takes
  run_fuzz.py --build build/san --coverage NAME...                 lines that the committed corpus reaches
  run_fuzz.py --build build/san --keep NAME...                     minimised new inputs become the committed
  corpus

For a target NAME, BUILD/test/NAME is the fuzz program, and `BUILD/test/NAME_seeds DIRECTORY` writes valid inputs for
this program. The file NAME.corpus holds inputs that a longer run of the fuzz program has found, one input per line in
base64. The script keeps new inputs in the folder BUILD/corpus/NAME of the target. If an input crashes the program, the
script keeps it under out/fuzz and prints the command that reproduces the crash.
"""

import argparse
import base64
import concurrent.futures
import json
import os
import re
import subprocess
import sys
import tempfile

CRASH_FOLDER = os.path.join("out", "fuzz")
RSS_LIMIT_MB = 2048
INPUT_TIME_LIMIT_S = 10
OUTPUT_LINES = 40
INPUT_BYTES_MAX = 4096  # longer inputs are slower and reach nothing more


def write_seeds(build, name, corpus):
    """Writes the valid inputs of a fuzz target into the folder of its corpus. Returns None if the inputs could be
    written, and otherwise a sentence that states the error."""
    program = os.path.join(build, "test", name + "_seeds")
    if not os.access(program, os.X_OK):
        return "%s did not build" % program
    done = subprocess.run([program, corpus], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60, check=False)
    if done.returncode != 0:
        return "%s ended with %d: %s" % (program, done.returncode, done.stdout.decode("utf-8", "replace"))
    return None


def write_corpus(name, corpus):
    """Decodes the inputs of the file NAME.corpus and writes each input as a file into the corpus folder."""
    path = name + ".corpus"
    if not os.path.exists(path):
        return
    with open(path, encoding="ascii") as file:
        for number, line in enumerate(file):
            with open(os.path.join(corpus, "kept-%04d" % number), "wb") as out:
                out.write(base64.b64decode(line.strip(), validate=True))


def keep_corpus(build, name):
    """Writes the file NAME.corpus: the shortest inputs that together reach every control-flow edge that the inputs in
    BUILD/corpus/NAME reach. Returns (ok, text).

    When libFuzzer merges inputs, it writes a control file that states, for each input, the control-flow edges that no
    earlier input has reached. The merge keeps those inputs that reach a control-flow edge that no earlier input has
    reached."""
    program, learnt = os.path.join(build, "test", name), os.path.join(build, "corpus", name)
    inputs = []
    with tempfile.TemporaryDirectory() as folder:
        control, merged = os.path.join(folder, "control"), os.path.join(folder, "merged")
        os.mkdir(merged)
        done = subprocess.run(
            [program, "-merge=1", "-merge_control_file=" + control, "-max_len=%d" % INPUT_BYTES_MAX, merged, learnt],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )
        if done.returncode != 0:
            return False, done.stdout.decode("utf-8", "replace")
        with open(control, encoding="utf-8") as file:
            lines = file.read().splitlines()
        files = lines[2 : 2 + int(lines[0])]
        for words in (line.split() for line in lines[2 + len(files) :]):
            if words[0] != "COV" or len(words) < 3:
                continue
            with open(files[int(words[1])], "rb") as file:
                inputs.append(file.read())
    inputs.sort(key=lambda data: (len(data), data))
    with open(name + ".corpus", "w", encoding="ascii") as out:
        out.writelines(base64.b64encode(data).decode("ascii") + "\n" for data in inputs)
    return True, "%d inputs, %d bytes" % (len(inputs), sum(len(data) for data in inputs))


def show_coverage(build, name):
    """Measures, for each folder, how many lines of the tested code are executed by the valid inputs and the inputs of
    NAME.corpus. The fuzz program must be compiled for coverage measurement. Returns (ok, text)."""
    program = os.path.join(build, "test", name)
    with tempfile.TemporaryDirectory() as folder:
        corpus, counts = os.path.join(folder, "corpus"), os.path.join(folder, "counts")
        os.mkdir(corpus)
        problem = write_seeds(build, name, corpus)
        if problem:
            return False, problem
        write_corpus(name, corpus)
        steps = [
            [program, "-runs=0", "-max_len=%d" % INPUT_BYTES_MAX, corpus],
            ["llvm-profdata", "merge", "-o", counts, counts + ".raw"],
            ["llvm-cov", "export", "-summary-only", "-instr-profile=" + counts, program],
        ]
        for step in steps:
            done = subprocess.run(
                step,
                env=dict(os.environ, LLVM_PROFILE_FILE=counts + ".raw"),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                check=False,
            )
            if done.returncode != 0:
                return False, "%s: %s" % (" ".join(step), done.stderr.decode("utf-8", "replace"))
        inputs = len(os.listdir(corpus))
    lines = {}
    for file in json.loads(done.stdout)["data"][0]["files"]:
        place, count = os.path.relpath(file["filename"]), file["summary"]["lines"]
        if place.startswith("..") or "tests/" in place or count["covered"] == 0:
            continue
        covered, total = lines.get(os.path.dirname(place), (0, 0))
        lines[os.path.dirname(place)] = (covered + count["covered"], total + count["count"])
    text = ["%d inputs" % inputs]
    for folder, (covered, total) in sorted(lines.items()):
        text.append("    %-24s %5d of %5d lines, %3.0f %%" % (folder, covered, total, 100.0 * covered / total))
    return bool(lines), "\n".join(text)


def run_target(build, name, seconds, executions=0):
    """Returns (ok, text). The returned text names the target that was run and, after a crash, the command that repeats
    the crash."""
    program = os.path.join(build, "test", name)
    if not os.access(program, os.X_OK):
        return False, "%s did not build" % program
    corpus = os.path.join(build, "corpus", name)
    os.makedirs(corpus, exist_ok=True)
    os.makedirs(CRASH_FOLDER, exist_ok=True)
    problem = write_seeds(build, name, corpus)
    if problem:
        return False, problem
    write_corpus(name, corpus)
    limit = "-runs=%d" % executions if executions else "-max_total_time=%d" % seconds
    prefix = os.path.join(CRASH_FOLDER, os.path.basename(name) + "-")
    command = [
        program,
        limit,
        "-max_len=%d" % INPUT_BYTES_MAX,
        "-entropic_scale_per_exec_time=1",
        "-timeout=%d" % INPUT_TIME_LIMIT_S,
        "-print_final_stats=1",
        "-rss_limit_mb=%d" % RSS_LIMIT_MB,
        "-artifact_prefix=" + prefix,
        corpus,
    ]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    lines = done.stdout.decode("utf-8", "replace").splitlines()
    if done.returncode == 0:
        runs = [line.rsplit(":", 1)[1].strip() for line in lines if "number_of_executed_units" in line]
        edges = [found.group(1) for found in (re.search(r" cov: (\d+) ", line) for line in lines) if found]
        return True, "%s inputs, nothing found, %s edges reached" % (
            runs[0] if runs else "?",
            edges[-1] if edges else "?",
        )
    text = lines[-OUTPUT_LINES:]
    for line in lines:
        written = re.search(r"Test unit written to (\S+)", line)
        if written:
            text.append("reproduce: %s %s" % (program, written.group(1)))
    return False, "\n".join(text)


def every_target(build):
    """Returns the names of the fuzz targets that were built."""
    paths = [os.path.join(place, name) for place, _, names in os.walk(os.path.join(build, "test")) for name in names]
    names = [os.path.relpath(path, os.path.join(build, "test")) for path in paths if path.endswith("_seeds")]
    return sorted(name[: -len("_seeds")] for name in names)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build/san", help="build folder (default: build/san)")
    parser.add_argument("--seconds", type=int, default=60, help="time per target (default: 60)")
    parser.add_argument(
        "--executions", type=int, default=0, help="inputs per target instead of a time (default: 0, none)"
    )
    parser.add_argument("--coverage", action="store_true", help="only show what the committed corpus reaches")
    parser.add_argument("--keep", action="store_true", help="only write what was learnt to NAME.corpus")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="targets at a time (default: cores)")
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_args()
    if options.seconds < 1 or options.executions < 0:
        print(
            "run_fuzz: --seconds must be at least 1 and --executions at least 0, not %d and %d"
            % (options.seconds, options.executions),
            file=sys.stderr,
        )
        return 2
    if not options.names:
        options.names = every_target(options.build)
    if not options.names:
        print("run_fuzz: no fuzz targets (fuzz_*.c) found", file=sys.stderr)
        return 1
    found = 0
    work, arguments = run_target, (options.seconds, options.executions)
    if options.coverage or options.keep:
        work, arguments = show_coverage if options.coverage else keep_corpus, ()
    with concurrent.futures.ThreadPoolExecutor(max(1, options.jobs)) as pool:
        futures = {pool.submit(work, options.build, name, *arguments): name for name in options.names}
        each = "%d inputs each" % options.executions if options.executions else "%d s each" % options.seconds
        print(
            "%d targets, %s, %d at a time" % (len(futures), each if arguments else "corpus only", max(1, options.jobs)),
            flush=True,
        )
        for future in concurrent.futures.as_completed(futures):
            ok, text = future.result()
            found += not ok
            print("%s %s: %s" % ("ok    " if ok else "FAILED", futures[future], text), flush=True)
    print("%d of %d targets failed" % (found, len(futures)))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
