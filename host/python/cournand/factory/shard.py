"""Makes one shard, which is the unit of work that an executor gives to a worker."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ..errors import RefusedError
from .course import Course, OutOfRange
from .formats import writers
from .options import Options
from .plan import ATTEMPTS, ShardPlan, plan_shard
from .sample import sample_of
from .store import ShardFolder, StoreError, is_made
from .tally import Tally

SAMPLE = "sample.png"


def make_shard(options: Options, dataset: Path, shard: int, parent: int | None = None) -> int:
    """Makes a shard, unless it is made already, and returns its number of frames. The bytes of a shard depend only on
    the options and the shard's number.

    `parent` is the process that started this worker; if that process ends, the worker ends too.
    """
    if is_made(dataset, shard):
        return options.frames_of(shard)
    refusals = []
    for attempt in range(ATTEMPTS):
        plan = plan_shard(options, shard, attempt)
        try:
            with ShardFolder(dataset, shard) as folder:
                facts = _fill(options, plan, folder, parent)
                folder.publish(facts)
            return plan.frames
        except (OutOfRange, RefusedError) as error:
            refusals.append("attempt %d with %s: %s" % (attempt, "+".join(plan.tools), error))
    raise StoreError("shard %d could not be made. %s. Remedy: other --tools or --scenes" % (shard, "; ".join(refusals)))


def _fill(options: Options, plan: ShardPlan, folder: ShardFolder, parent: int | None) -> dict[str, Any]:
    """Writes all files of a shard, and returns the content of its manifest."""
    made, tally, frames = writers(options, plan, folder), Tally(), 0
    for frame in Course(options, plan).frames():
        if parent is not None and os.getppid() != parent:
            os._exit(1)  # the run was killed, and its next one makes this shard again
        for writer in made.values():
            writer.add(frame)
        tally.add(frame)
        if frame.number == plan.sample:
            folder.put(SAMPLE, sample_of(frame))
        frames += 1
    return {
        "shard": plan.shard,
        "frames": frames,
        "first_index": plan.shard * options.shard_frames,
        "attempt": plan.attempt,
        "scene": plan.scene,
        "tools": list(plan.tools),
        "stent": plan.stent,
        "formats": {name: writer.end() for name, writer in made.items()},
        "tally": tally.as_json(),
    }
