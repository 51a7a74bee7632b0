#!/usr/bin/env python3
"""Run libFuzzer targets. Called by `make fuzz` and, for a few seconds each, by run_tests.py.

  run_fuzz.py --build build/fuzz --seconds 60 --jobs 2 NAME...

BUILD/test/NAME is the fuzz program, BUILD/test/NAME_seeds DIRECTORY writes its valid inputs. What the fuzzer learns is
kept in BUILD/corpus/NAME; an input that crashes is kept under out/fuzz and the command to reproduce it is printed.
"""
import argparse
import concurrent.futures
import os
import re
import subprocess
import sys

CRASH_FOLDER = os.path.join("out", "fuzz")
RSS_LIMIT_MB = 2048
INPUT_TIME_LIMIT_S = 10
OUTPUT_LINES = 40


def write_seeds(build, name, corpus):
    """Valid inputs into the corpus. Returns a sentence when that fails, else None."""
    program = os.path.join(build, "test", name + "_seeds")
    if not os.access(program, os.X_OK):
        return "%s did not build" % program
    done = subprocess.run([program, corpus], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60, check=False)
    if done.returncode != 0:
        return "%s ended with %d: %s" % (program, done.returncode, done.stdout.decode("utf-8", "replace"))
    return None


def run_target(build, name, seconds):
    """(ok, text): text says what was run and, after a crash, how to see it again."""
    program = os.path.join(build, "test", name)
    if not os.access(program, os.X_OK):
        return False, "%s did not build" % program
    corpus = os.path.join(build, "corpus", name)
    os.makedirs(corpus, exist_ok=True)
    os.makedirs(CRASH_FOLDER, exist_ok=True)
    problem = write_seeds(build, name, corpus)
    if problem:
        return False, problem
    prefix = os.path.join(CRASH_FOLDER, os.path.basename(name) + "-")
    command = [program, "-max_total_time=%d" % seconds, "-timeout=%d" % INPUT_TIME_LIMIT_S, "-print_final_stats=1",
               "-rss_limit_mb=%d" % RSS_LIMIT_MB, "-artifact_prefix=" + prefix, corpus]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    lines = done.stdout.decode("utf-8", "replace").splitlines()
    if done.returncode == 0:
        runs = [line.rsplit(":", 1)[1].strip() for line in lines if "number_of_executed_units" in line]
        return True, "%s inputs in %d s, nothing found" % (runs[0] if runs else "?", seconds)
    text = lines[-OUTPUT_LINES:]
    for line in lines:
        written = re.search(r"Test unit written to (\S+)", line)
        if written:
            text.append("reproduce: %s %s" % (program, written.group(1)))
    return False, "\n".join(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build/fuzz", help="build folder (default: build/fuzz)")
    parser.add_argument("--seconds", type=int, default=60, help="time per target (default: 60)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="targets at a time (default: cores)")
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_args()
    if options.seconds < 1:
        print("run_fuzz: --seconds must be at least 1, not %d" % options.seconds, file=sys.stderr)
        return 2
    if not options.names:
        print("run_fuzz: no fuzz targets (fuzz_*.c) found", file=sys.stderr)
        return 1
    found = 0
    with concurrent.futures.ThreadPoolExecutor(max(1, options.jobs)) as pool:
        futures = {pool.submit(run_target, options.build, name, options.seconds): name for name in options.names}
        print("%d targets, %d s each, %d at a time" % (len(futures), options.seconds, max(1, options.jobs)), flush=True)
        for future in concurrent.futures.as_completed(futures):
            ok, text = future.result()
            found += not ok
            print("%s %s: %s" % ("ok    " if ok else "FAILED", futures[future], text), flush=True)
    print("%d of %d targets failed" % (found, len(futures)))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
