"""Trains the deep baseline of a named task, and draws the curves of trainings.

    python -m deep_baseline train TASK --out FILE.npz       FILE.npz is for cournand.judge; FILE.tsv is the curve
    python -m deep_baseline curves FILE.tsv ... --out PNG   the curves of several trainings in one picture

Exit codes: 0 done, 1 failed, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from cournand.errors import BadFileError
from cournand.tasks import CHALLENGES, Network, challenge_of

from .curves import draw, read_curve
from .train import Course, train, write_curve


def _train(given: argparse.Namespace) -> int:
    course = Course(
        steps=given.steps,
        seed=given.seed,
        worlds=given.worlds,
        threads=given.threads,
        scenes=given.scenes,
        demonstrations=given.demonstrations,
        push=given.push,
    )
    rows: list[Sequence[float]] = []

    def after(row: Sequence[float]) -> None:
        rows.append(row)
        write_curve(given.out.with_suffix(".tsv"), rows)
        text = "%8d steps  %6.0f s  %5d episodes  rewards %6.2f  safe %3.0f %%"
        print(text % (row[0], row[1], row[2], row[3], 100 * row[4]), flush=True)

    begin_with = None if given.begin_with is None else Network.load(given.begin_with)
    network, _ = train(challenge_of(given.task), course, given.anatomies, after, begin_with)
    network.save(given.out)
    return 0


def _curves(given: argparse.Namespace) -> int:
    draw([(path.stem, read_curve(path)) for path in given.curves], given.out)
    return 0


def _count(least: int) -> Callable[[str], int]:
    """Returns a reader of whole numbers of at least `least` for an option."""

    def read_count(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError("%r is not a whole number of at least %d" % (text, least))
        return int(text)

    return read_count


def _part(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not -1.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError("%r is not a number from -1 to 1" % text)
    return value


def _with_ending(ending: str) -> Callable[[str], Path]:
    def read_path(text: str) -> Path:
        if not text.endswith(ending):
            raise argparse.ArgumentTypeError("%r does not end in %s" % (text, ending))
        return Path(text)

    return read_path


def _parser() -> argparse.ArgumentParser:
    usual = Course()
    parser = argparse.ArgumentParser(
        prog="python -m deep_baseline", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    learn = commands.add_parser("train", help="train the policy of a task")
    learn.add_argument("task", choices=list(CHALLENGES), metavar="TASK", help=", ".join(CHALLENGES))
    learn.add_argument("--steps", type=_count(1), default=usual.steps, help="of all worlds (%d)" % usual.steps)
    learn.add_argument("--seed", type=_count(0), default=usual.seed, help="of weights, episodes, exploration (1)")
    learn.add_argument("--demonstrations", type=_count(0), default=0, help="episodes of the expert to imitate (0)")
    learn.add_argument("--from", dest="begin_with", metavar="FILE.npz", help="go on with the network of this file")
    learn.add_argument("--push", type=_part, default=0.0, help="mean push at the beginning, -1 to 1 (0)")
    learn.add_argument("--worlds", type=_count(1), default=usual.worlds, help="that step together (%d)" % usual.worlds)
    learn.add_argument("--threads", type=_count(1), default=1, help="of the worlds (1)")
    learn.add_argument("--scenes", type=_count(1), default=usual.scenes, help="if anatomies are always new (8)")
    learn.add_argument("--anatomies", default="anatomies", metavar="DIR", help="drawn scenes (anatomies)")
    learn.add_argument("--out", type=_with_ending(".npz"), required=True, metavar="FILE.npz", help="the policy")
    show = commands.add_parser("curves", help="draw the curves of trainings")
    show.add_argument("curves", type=Path, nargs="+", metavar="FILE.tsv", help="curves that `train` has written")
    show.add_argument("--out", type=_with_ending(".png"), required=True, metavar="FILE.png", help="the picture")
    return parser


def main(words: Sequence[str] | None = None) -> int:
    """Runs one command, and returns the exit code."""
    given = _parser().parse_args(words)
    try:
        return _train(given) if given.command == "train" else _curves(given)
    except (BadFileError, OSError, ValueError) as error:
        print("deep_baseline: %s" % error, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
