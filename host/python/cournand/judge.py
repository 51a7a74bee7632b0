"""Judges a policy in a named task, and writes a score card (docs/tasks.md).

python -m cournand.judge shipped_arch --policy expert --episodes 10 --json card.json
python -m cournand.judge --table card.json other.json
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from .tasks import card as cards
from .tasks.catalogue import CHALLENGES, SPLITS, challenge_of
from .tasks.policies import policy_of


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m cournand.judge",
        description="Plays the fixed episodes of a task, and writes a score card.",
        epilog="Exit codes: 0 done, 1 the episodes could not be played, 2 usage.",
    )
    parser.add_argument("task", nargs="?", choices=list(CHALLENGES), metavar="TASK", help=", ".join(CHALLENGES))
    parser.add_argument(
        "--policy", default="expert", help="rest, random, push, expert, MODULE:FUNCTION, FILE.npz (default expert)"
    )
    parser.add_argument("--episodes", type=int, default=100, metavar="N", help="(default 100)")
    parser.add_argument("--split", choices=SPLITS, default="judge", help="anatomies to play in (default judge)")
    parser.add_argument(
        "--threads", type=int, default=os.cpu_count() or 1, metavar="N", help="(default all processors)"
    )
    parser.add_argument("--anatomies", default="anatomies", metavar="DIR", help="drawn scenes (default anatomies)")
    parser.add_argument("--json", metavar="FILE", help="the score card")
    parser.add_argument("--table", nargs="+", metavar="CARD", help="print cards as a table, and play nothing")
    given = parser.parse_args(words)
    if (given.task is None) == (given.table is None):
        parser.error("either TASK or --table")
    if given.episodes < 1 or given.threads < 1:
        parser.error("--episodes and --threads are at least 1")
    return given


def main(words: Sequence[str] | None = None) -> int:
    given = _arguments(words)
    try:
        if given.table is not None:
            print(cards.table([cards.read(path) for path in given.table]), end="")
            return 0
        card = cards.score(
            challenge_of(given.task),
            policy_of(given.policy),
            name=given.policy,
            episodes=given.episodes,
            threads=given.threads,
            split=given.split,
            anatomies=given.anatomies,
        )
        if given.json is not None:
            cards.write(card, given.json)
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        print("judge: %s" % error, file=sys.stderr)
        return 1
    print(cards.table([card]), end="")
    print("\n%.1f simulated seconds per processor second" % card["speed"]["simulated_s_per_processor_s"])
    return 0


if __name__ == "__main__":
    sys.exit(main())
