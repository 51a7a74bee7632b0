#!/usr/bin/env python3
"""Measures the speed of the factory of labelled pictures (docs/factory.md): the frames per hour of one processor core,
with all labels and files, and the time for each stage.

  factory.py [--shards N] [--size N] [--formats LIST] [--compression stored|fast] [--output FILE]

The program measures processor time, which other work on the machine hardly changes. The program writes lines
`name<TAB>value<TAB>unit<TAB> context` to out/factory.tsv. The program always makes the shards of seed 1, so the figure
is a mean over the same sets of tools.
"""

import argparse
import os
import pathlib
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "host", "python", "tests"))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import cournand  # noqa: E402
from cournand.factory import Options, course, make_shard  # noqa: E402

SPENT = {"physics": 0.0, "pictures": 0.0}


def timed(kind, call):
    """Returns a function that adds the processor's time of its calls to SPENT."""

    def with_time(*words, **more):
        begin = time.process_time()
        try:
            return call(*words, **more)
        finally:
            SPENT[kind] += time.process_time() - begin

    return with_time


def measure(options, shards):
    """Returns the processor time in s for each frame of these shards."""
    course.World.move = timed("physics", cournand.World.move)
    course.XRay.render = timed("pictures", cournand.XRay.render)
    with tempfile.TemporaryDirectory() as folder:
        begin = time.process_time()
        for shard in range(shards):
            make_shard(options, pathlib.Path(folder) / str(shard), shard)
        total = time.process_time() - begin
    frames = sum(options.frames_of(shard) for shard in range(shards))
    return total / frames, {kind: spent / frames for kind, spent in SPENT.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--shards", type=int, default=15)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--formats", default="webdataset")
    parser.add_argument("--compression", default="stored")
    parser.add_argument("--output", default=os.path.join(prepare.ROOT, "out", "factory.tsv"))
    given = parser.parse_args()
    options = Options(
        frames=240 * given.shards,
        seed=1,
        size=given.size,
        formats=tuple(given.formats.split(",")),
        compression=given.compression,
    )
    each_s, parts_s = measure(options, given.shards)
    context = "size=%d formats=%s compression=%s" % (given.size, given.formats, given.compression)
    rest_s = each_s - sum(parts_s.values())
    rows = [("factory.frames_per_core_hour", "%.0f" % (3600 / each_s), "frames", context)]
    rows.append(("factory.frame_ms", "%.2f" % (each_s * 1e3), "ms", context))
    for kind, spent in [*parts_s.items(), ("files and worlds", rest_s)]:
        rows.append(("factory.part_ms", "%.2f" % (spent * 1e3), "ms", "%s part=%s" % (context, kind.replace(" ", "_"))))
    text = "".join("\t".join(row) + "\n" for row in rows)
    os.makedirs(os.path.dirname(given.output), exist_ok=True)
    with open(given.output, "w", encoding="utf-8") as file:
        file.write(text)
    print(text, end="")


if __name__ == "__main__":
    main()
