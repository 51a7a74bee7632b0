"""The command line of the factory.

    python -m cournand.factory --frames 1000 --seed 1 --out DIR     make a data set
    python -m cournand.factory resume DIR                           continue a run that was stopped
    python -m cournand.factory check DIR                            compare all files with their hashes
    python -m cournand.factory stats DIR                            write data sheet, statistics and indexes again
    python -m cournand.factory plan --frames 1000 --seed 1          say what would be made
    python -m cournand.factory slurm --frames 1000 --seed 1 --out DIR    begin a data set, and print a script for Slurm

Exit codes: 0 done, 1 failed, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .. import __version__
from ..errors import Error
from . import dataset as data
from . import executors, slurm
from .options import COMPRESSIONS, DOSE_NGY, FORMATS, TOOL_SETS, VARIATION, Options, UsageError, varied
from .plan import describe, plan_shard
from .store import StoreError, only_run, remove_parts

COMMANDS = ("run", "resume", "check", "stats", "plan", "slurm")
BYTES_PER_PIXEL = {"stored": 3.02, "fast": 2.0}  # of a frame in WebDataset
PLANS_SHOWN = 10
WORKERS_MAX = 1024
RANGES = (
    ("dose", "nGy at the detector", "dose of a picture"),
    ("primary", "degrees", "angle of the C-arm, LAO positive"),
    ("secondary", "degrees", "angle of the C-arm, cranial positive"),
)


class Parser(argparse.ArgumentParser):
    """A parser of the command line that raises an error where argparse would end the program."""

    def error(self, message: str) -> Any:
        raise UsageError("%s. Remedy: see --help" % message)


def _names(text: str) -> tuple[str, ...]:
    return tuple(name for name in text.split(",") if name)


def _default(name: str) -> tuple[float, float]:
    """Returns the range of an option of RANGES if the option is not given."""
    if name == "dose":
        return VARIATION.dose[0] * DOSE_NGY, VARIATION.dose[1] * DOSE_NGY
    return VARIATION.primary_deg if name == "primary" else VARIATION.secondary_deg


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--frames", type=int, required=True, help="number of frames")
    parser.add_argument("--seed", type=int, default=0, help="from which everything is drawn (default 0)")
    parser.add_argument("--size", type=int, default=512, help="pixels of an edge, 64 to 2048 in steps of 16 (512)")
    parser.add_argument("--formats", type=_names, default=("webdataset",), help="several of %s" % ",".join(FORMATS))
    parser.add_argument("--scenes", type=_names, default=("aorta",), help="shipped names or files, separated by commas")
    parser.add_argument(
        "--tools",
        type=_names,
        default=TOOL_SETS,
        help="sets of tools, from the innermost: j_wire,j_wire+beacon_5f,rosen+balloon_6x20@renal_6_0x18",
    )
    parser.add_argument("--compression", choices=COMPRESSIONS, default="stored", help="of pictures (stored)")
    parser.add_argument("--pulses", type=float, default=15.0, help="frames per simulated second (15)")
    parser.add_argument("--shard-frames", type=int, default=240, help="frames of a shard (240)")
    parser.add_argument("--block-frames", type=int, default=24, help="frames from one view (24)")
    for name, unit, what in RANGES:
        least, most = _default(name)
        parser.add_argument(
            "--" + name,
            type=float,
            nargs=2,
            metavar=("LOW", "HIGH"),
            default=(least, most),
            help="%s, drawn for each view, in %s (%g %g)" % (what, unit, least, most),
        )
    parser.add_argument(
        "--offset",
        type=float,
        default=Options.offset_part,
        help="largest distance from the leading tip to the isocentre along each axis, as a part of the field (0.24)",
    )


def _add_work(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--workers", type=int, default=1, help="processes (1)")
    parser.add_argument("--executor", choices=executors.EXECUTORS, default="processes", help="processes, or ray")
    parser.add_argument("--shards", default="0/1", metavar="I/N", help="only every Nth shard, from shard I on (0/1)")
    parser.add_argument("--quiet", action="store_true", help="print errors alone")


def make_parser() -> Parser:
    parser = Parser(
        prog="python -m cournand.factory", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(dest="command", required=True, parser_class=Parser)
    run = commands.add_parser("run", help="make a data set (the word `run` may be left out)")
    _add_options(run)
    run.add_argument("--out", type=Path, required=True, help="folder of the data set")
    _add_work(run)
    resume = commands.add_parser("resume", help="continue a run that was stopped")
    resume.add_argument("out", type=Path, help="folder of the data set")
    _add_work(resume)
    check = commands.add_parser("check", help="compare all files with their hashes")
    check.add_argument("out", type=Path, help="folder of the data set")
    check.add_argument("--again", type=int, metavar="SHARD", help="also make this shard again, and compare its bytes")
    stats = commands.add_parser("stats", help="write data sheet, statistics and indexes again")
    stats.add_argument("out", type=Path, help="folder of the data set")
    plan = commands.add_parser("plan", help="say what would be made")
    _add_options(plan)
    array = commands.add_parser("slurm", help="begin a data set, and print a script for Slurm")
    _add_options(array)
    array.add_argument(
        "--out", type=Path, required=True, help="folder of the data set, on a disk that all machines see"
    )
    array.add_argument("--tasks", type=int, default=16, help="tasks of the array (16)")
    array.add_argument("--cpus", type=int, default=4, help="processors of each task (4)")
    array.add_argument("--time", default="04:00:00", help="limit of a task (04:00:00)")
    return parser


def _options(given: argparse.Namespace) -> Options:
    names = ("frames", "seed", "size", "shard_frames", "block_frames", "scenes", "tools", "formats", "compression")
    options = Options(
        pulses_per_s=given.pulses,
        variation=varied(given.dose, given.primary, given.secondary),
        offset_part=given.offset,
        **{name: getattr(given, name) for name in names},
    )
    if "lerobot" in options.formats:
        try:
            import pyarrow  # type: ignore[import-not-found, import-untyped, unused-ignore]  # noqa: F401
        except ImportError as error:
            raise UsageError("--formats lerobot needs pyarrow. Remedy: pip install 'cournand[lerobot]'") from error
    return options


def _part(given: argparse.Namespace) -> tuple[int, int]:
    """Returns the part of the shards that this run makes. The function also checks the number of workers."""
    if not 1 <= given.workers <= WORKERS_MAX:
        raise UsageError("--workers: %d is not within 1 and %d" % (given.workers, WORKERS_MAX))
    try:
        first, count = (int(one) for one in given.shards.split("/"))
    except ValueError:
        raise UsageError("--shards: %r is not I/N, such as 0/16" % given.shards) from None
    if not 0 <= first < count:
        raise UsageError("--shards: in %r, I is not within 0 and N - 1" % given.shards)
    return first, count


class Progress:
    """Prints a line for each shard."""

    def __init__(self, is_quiet: bool, total: int) -> None:
        self._is_quiet, self._total, self._done, self._frames = is_quiet, total, 0, 0
        self._begin = time.monotonic()

    def __call__(self, shard: int, frames: int) -> None:
        self._done, self._frames = self._done + 1, self._frames + frames
        if not self._is_quiet:
            rate = self._frames / max(time.monotonic() - self._begin, 1e-9)
            print(
                "shard %06d: %d of %d shards, %.1f frames/s" % (shard, self._done, self._total, rate), file=sys.stderr
            )


def _work(given: argparse.Namespace, options: Options) -> int:
    """Makes the missing shards of this part, and completes the data set when no shard is missing."""
    first, count = _part(given)
    out: Path = given.out
    mine = range(first, options.shards, count)
    with only_run(out, "%d-of-%d" % (first, count)):
        remove_parts(out, list(mine))
        absent = set(data.missing(out, options))
        todo = [shard for shard in mine if shard in absent]
        progress = Progress(given.quiet, len(todo))
        executors.run(options, out, todo, given.workers, given.executor, progress)
        absent = set(data.missing(out, options))
        if absent:
            print(
                "%d shards of other parts are missing; `resume` completes the data set" % len(absent), file=sys.stderr
            )
            return 0
        data.complete(out, options)
    if not given.quiet:
        print("%d frames in %s; see datasheet.md and statistics.html" % (options.frames, out))
    return 0


def _check(given: argparse.Namespace) -> int:
    options = data.load(given.out)
    found = data.faults(given.out, options)
    if given.again is not None and not found:
        found += data.differences(given.out, options, given.again)
    for fault in found:
        print(fault, file=sys.stderr)
    if not found:
        print("%d frames in %d shards are as they were written" % (options.frames, options.shards))
    return 1 if found else 0


def _show_plan(given: argparse.Namespace) -> int:
    options = _options(given)
    size = options.frames * options.size**2 * BYTES_PER_PIXEL[options.compression]
    print("%d frames in %d shards; about %.1f GB as WebDataset" % (options.frames, options.shards, size * 1e-9))
    for shard in range(min(options.shards, PLANS_SHOWN)):
        row = describe(plan_shard(options, shard))
        print("  ".join("%s %s" % pair for pair in row.items()))
    if options.shards > PLANS_SHOWN:
        print("... and %d more" % (options.shards - PLANS_SHOWN))
    return 0


def _slurm(given: argparse.Namespace) -> int:
    options = _options(given)
    if not 1 <= given.tasks <= 100_000 or not 1 <= given.cpus <= 1024:
        raise UsageError("--tasks is not within 1 and 100000, or --cpus not within 1 and 1024")
    data.begin(given.out, options)
    print(slurm.script(given.out.resolve(), given.tasks, given.cpus, given.time, sys.executable), end="")
    return 0


def _dispatch(words: Sequence[str]) -> int:
    given = make_parser().parse_args(words)
    if given.command == "run":
        options = _options(given)
        _part(given)  # refuses before anything is written
        data.begin(given.out, options)
        return _work(given, options)
    if given.command == "resume":
        return _work(given, data.load(given.out))
    if given.command == "check":
        return _check(given)
    if given.command == "stats":
        data.complete(given.out, data.load(given.out))
        return 0
    return _show_plan(given) if given.command == "plan" else _slurm(given)


def main(words: Sequence[str] | None = None) -> int:
    """Runs one command line of the factory, and returns the exit code."""
    given = list(sys.argv[1:] if words is None else words)
    if given and given[0] not in COMMANDS and given[0] not in ("-h", "--help", "--version"):
        given.insert(0, "run")
    try:
        return _dispatch(given)
    except UsageError as error:
        print("factory: %s" % error, file=sys.stderr)
        return 2
    except (StoreError, Error, OSError) as error:
        print("factory: %s" % error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("factory: stopped; `resume` continues", file=sys.stderr)
        return 1
    except BrokenPipeError:
        os._exit(1)
