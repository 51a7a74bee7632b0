"""Score cards: the results of a policy in a named task, as data and as a table."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from .. import CORE_VERSION, Scene, __version__
from ..errors import BadFileError
from ..world import TICKS_PER_S
from .catalogue import Challenge
from .play import Player, Row
from .policies import PolicyMaker

FORMAT = 1


def score(
    challenge: Challenge,
    maker: PolicyMaker,
    *,
    name: str,
    episodes: int = 100,
    threads: int = 1,
    split: str = "judge",
    anatomies: str | os.PathLike[str] = "anatomies",
) -> dict[str, Any]:
    """Plays the first episodes of a split (training or judging), and returns the score card. With any number of
    threads, everything except `speed` is equal, bit for bit. `name` states the policy."""
    if episodes < 1:
        raise ValueError("episodes: %d is less than 1" % episodes)
    seeds = challenge.episodes(split, episodes)
    player = Player(challenge, anatomies, threads)
    begin = time.process_time()
    rows = player.play(seeds, maker)
    processor_s = time.process_time() - begin
    simulated_s = sum(row.steps for row in rows) * challenge.task.ticks / TICKS_PER_S
    scenes = {one.anatomy: challenge.scene(anatomies, one.anatomy) for one in seeds}
    return {
        "format": FORMAT,
        "task": challenge.name,
        "version": challenge.version,
        "split": split,
        "policy": name,
        "package": __version__,
        "core": CORE_VERSION,
        "force_limit_N": challenge.task.force_limit_N,
        "steps_max": challenge.task.steps,
        "scenes_crc32": {str(number): "%08x" % Scene(path).crc32 for number, path in sorted(scenes.items())},
        "summary": summary(rows),
        "episodes": [asdict(row) for row in rows],
        "speed": {
            "simulated_s": simulated_s,
            "processor_s": processor_s,
            "simulated_s_per_processor_s": simulated_s / max(processor_s, 1e-9),
        },
    }


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """Returns the summary figures of a score card. The forces are the largest sample of each episode."""
    reached = [row for row in rows if row.is_reached]
    forces = [row.force_peak_N for row in rows]
    gained = [(row.path_begin_m - row.path_end_m) / max(row.path_begin_m, 1e-9) for row in rows]
    return {
        "episodes": len(rows),
        "success": len(reached) / len(rows),
        "safe_success": sum(row.is_success for row in rows) / len(rows),
        "out_of_range": sum(row.is_out_of_range for row in rows) / len(rows),
        "steps_median": float(np.median([row.steps for row in rows])),
        "steps_median_reached": float(np.median([row.steps for row in reached])) if reached else None,
        "path_part_median": float(np.median(gained)),
        "tip_travel_median_m": float(np.median([row.tip_travel_m for row in rows])),
        "force_peak_median_N": float(np.median(forces)),
        "force_peak_p95_N": float(np.percentile(forces, 95)),
        "rewards_mean": math.fsum(row.rewards for row in rows) / len(rows),
    }


def write(card: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """Writes a score card; the file gets its name when it is complete. Each episode has its own line in the file."""
    rows = card["episodes"]
    text = json.dumps({**card, "episodes": []}, indent=1, sort_keys=False)
    lines = ",\n  ".join(json.dumps(row) for row in rows)
    text = text.replace('"episodes": []', '"episodes": [\n  %s\n ]' % lines, 1) + "\n"
    temporary = os.fspath(path) + ".part"
    Path(temporary).write_text(text, encoding="utf-8")
    os.replace(temporary, path)


def read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Reads a card."""
    try:
        card = json.loads(Path(path).read_text(encoding="utf-8"))
        if not isinstance(card, dict) or card.get("format") != FORMAT or "summary" not in card:
            raise ValueError("it is no score card of format %d" % FORMAT)
    except (OSError, ValueError) as error:
        raise BadFileError("%s: %s. Remedy: make it by `python -m cournand.judge`" % (path, error)) from error
    return card


def table(cards: Sequence[dict[str, Any]]) -> str:
    """Returns score cards as a Markdown table."""
    lines = [
        "| task | policy | episodes | success | safe success | steps | path | peak force, median and 95 % |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for card in cards:
        figures = card["summary"]
        lines.append(
            "| `%s` v%d | %s | %d | %.0f %% | **%.0f %%** | %.0f | %.0f %% | %.2f N, %.2f N (limit %g N) |"
            % (
                card["task"],
                card["version"],
                card["policy"],
                figures["episodes"],
                100 * figures["success"],
                100 * figures["safe_success"],
                figures["steps_median"],
                100 * figures["path_part_median"],
                figures["force_peak_median_N"],
                figures["force_peak_p95_N"],
                card["force_limit_N"],
            )
        )
    return "\n".join(lines) + "\n"
