"""Trains and judges the tracker of tips.

    python3 -m tip_tracker train DATA --out DIR            learn from a data set of cournand.factory
    python3 -m tip_tracker judge DIR NAME=DATA --out DIR   measure the error in other data sets
    python3 -m tip_tracker doses DIR DOSE=DATA --out DIR   compare the errors at several doses in the same courses

Exit codes: 0 done, 1 failed, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import pickle
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import torch

from . import doses
from .data import COVERED, DataError, Frames, read, split
from .judge import COLUMNS, judged
from .model import Tracker
from .train import Course, Rows, train, write_curve

WATCHED_PART = 0.06  # of the shards


def _read(data: Path, keep: Path) -> Frames:
    return read(data, keep / (data.resolve().name + ".npz"))


def _loaded(folder: Path) -> Tracker:
    tracker = Tracker()
    try:
        tracker.load_state_dict(torch.load(folder / "tracker.pt"))
    except (OSError, RuntimeError, TypeError, AttributeError, EOFError, pickle.UnpicklingError) as error:
        raise DataError("%s has no tracker (%s). Remedy: tip_tracker train" % (folder, error)) from error
    return tracker


def _train(given: argparse.Namespace) -> int:
    given.out.mkdir(parents=True, exist_ok=True)
    frames = _read(given.data, given.keep or given.out)
    numbers, watched = split(frames, WATCHED_PART, given.seed)
    learned, seen = frames.chosen(numbers).seen(COVERED), frames.chosen(watched).seen()
    if not len(learned):
        raise DataError("%s has no frame with a tip in the picture. Remedy: more frames" % given.data)
    text = "%d frames: %d to learn from, %d with clear tips to watch"
    print(text % (len(frames), len(learned), len(seen)), flush=True)
    course = Course(
        given.crop_epochs, given.whole_epochs, rate=given.rate, seed=given.seed, is_short=given.bfloat16
    )

    def after_epoch(tracker: Tracker, rows: Rows) -> None:
        torch.save(tracker.state_dict(), given.out / "tracker.part.pt")
        write_curve(given.out / "curve.tsv", rows)
        print("epoch %d, %.0f s, edge %d: loss %.3f; median %.2f px, %.3f within 3 px" % rows[-1], flush=True)

    train(learned, seen, course, after_epoch, _loaded(given.begin_with) if given.begin_with else None)
    (given.out / "tracker.part.pt").replace(given.out / "tracker.pt")
    return 0


def _judge(given: argparse.Namespace) -> int:
    tracker = _loaded(given.tracker)
    given.out.mkdir(parents=True, exist_ok=True)
    rows, figures = [COLUMNS], ""
    for name, data in given.sets:
        frames = _read(data, given.keep or given.out)
        with torch.autocast("cpu", torch.bfloat16, enabled=given.bfloat16):
            found = judged(tracker, name, frames, given.out / (name + ".png"), given.turned)
        rows += found
        figures += "tracker.median_px\t%s\tpx\tset=%s\n" % (found[0][COLUMNS.index("median_px")], name)
    text = "".join("\t".join(row) + "\n" for row in rows)
    (given.out / "errors.tsv").write_text(text, encoding="utf-8")
    (given.out / "figures.tsv").write_text(figures, encoding="utf-8")
    print(text, end="")
    return 0


def _doses(given: argparse.Namespace) -> int:
    tracker = _loaded(given.tracker)
    given.out.mkdir(parents=True, exist_ok=True)
    sets = [(dose, _read(data, given.keep or given.out)) for dose, data in given.sets]
    with torch.autocast("cpu", torch.bfloat16, enabled=given.bfloat16):
        rows, ratios, sheet = doses.by_dose(tracker, sets, given.turned)
    print(doses.write_table(given.out / "doses.tsv", doses.COLUMNS, rows), end="")
    print(doses.write_table(given.out / "contrast.tsv", doses.RATIO_COLUMNS, ratios), end="")
    sheet.save(given.out / "doses.png")
    return 0


def _count(least: int) -> Callable[[str], int]:
    """Returns a reader of whole numbers of at least `least` for an option."""

    def read_count(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError("%r is not a whole number of at least %d" % (text, least))
        return int(text)

    return read_count


def _rate(text: str) -> float:
    if not re.fullmatch(r"[0-9]*\.?[0-9]+(e-[0-9]+)?", text) or not 0.0 < float(text) <= 0.1:
        raise argparse.ArgumentTypeError("%r is not a number above 0 and at most 0.1" % text)
    return float(text)


def _named(text: str) -> tuple[str, Path]:
    name, is_named, path = text.partition("=")
    if not is_named or not name:
        raise argparse.ArgumentTypeError("%r is not NAME=DATA" % text)
    return name, Path(path)


def _dosed(text: str) -> tuple[float, Path]:
    dose, is_named, path = text.partition("=")
    if not is_named or not re.fullmatch(r"[0-9]+(\.[0-9]+)?", dose):
        raise argparse.ArgumentTypeError("%r is not DOSE=DATA with a dose in nGy" % text)
    return float(dose), Path(path)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python3 -m tip_tracker", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    learn = commands.add_parser("train", help="learn from a data set")
    learn.add_argument("data", type=Path, help="folder of a data set with webdataset/*.tar")
    learn.add_argument("--crop-epochs", type=_count(0), default=9, help="passes over crops of 192 pixels (9)")
    learn.add_argument("--whole-epochs", type=_count(0), default=2, help="passes over whole pictures (2)")
    learn.add_argument("--seed", type=int, default=1, help="of weights, order and changes (1)")
    learn.add_argument("--rate", type=_rate, default=2e-3, help="the largest rate of learning (0.002)")
    learn.add_argument("--from", type=Path, dest="begin_with", metavar="DIR", help="go on with this folder's tracker")
    test = commands.add_parser("judge", help="measure the error in data sets")
    dosed = commands.add_parser("doses", help="compare the errors at several doses")
    for one in (test, dosed):
        one.add_argument("tracker", type=Path, help="folder that `train` has written")
        one.add_argument("--turned", action="store_true", help="take the mean over eight ways to turn a picture")
    test.add_argument("sets", type=_named, nargs="+", metavar="NAME=DATA", help="data sets with a name for each")
    dosed.add_argument("sets", type=_dosed, nargs="+", metavar="DOSE=DATA", help="data sets with their doses in nGy")
    for one in (learn, test, dosed):
        one.add_argument("--bfloat16", action="store_true", help="short numbers: twice as fast on some processors")
        one.add_argument("--out", type=Path, required=True, help="folder for the results")
        one.add_argument("--keep", type=Path, help="folder for the arrays of data sets that were read (as --out)")
        one.add_argument("--threads", type=_count(1), default=1, help="processors (1)")
    return parser


def main(words: Sequence[str] | None = None) -> int:
    """Runs one command, and returns the exit code."""
    parser = _parser()
    given = parser.parse_args(words)
    if given.command == "train" and given.crop_epochs + given.whole_epochs == 0:
        parser.error("--crop-epochs and --whole-epochs are both 0: there is nothing to learn")
    torch.set_num_threads(given.threads)
    try:
        return {"train": _train, "judge": _judge, "doses": _doses}[given.command](given)
    except (DataError, OSError) as error:
        print("tip_tracker: %s" % error, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
