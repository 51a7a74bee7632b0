"""The executors, which decide where the shards are made: in this process, in several processes of this machine, or with
Ray on many machines."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from .options import Options, UsageError
from .shard import make_shard
from .store import StoreError, is_made

EXECUTORS = ("processes", "ray")
LOSSES_MAX = 3  # one after the other without a shard that was made
RAY_RETRIES = 5
RAY_WAITING = 2  # shards that wait for each processor, so that a long list does not fill the memory of Ray's server

Report = Callable[[int, int], None]
"""A function that is called when a shard is made, with the shard's number and its number of frames."""


def run(options: Options, dataset: Path, shards: Sequence[int], workers: int, executor: str, report: Report) -> None:
    """Makes these shards. Shards that are already made stay as they are."""
    if executor == "ray":
        _run_on_ray(options, dataset, shards, workers, report)
    elif workers == 1 or len(shards) <= 1:
        for shard in shards:
            report(shard, make_shard(options, dataset, shard))
    else:
        _run_in_processes(options, dataset, shards, workers, report)


def _run_in_processes(options: Options, dataset: Path, shards: Sequence[int], workers: int, report: Report) -> None:
    """When the system kills one worker process, Python ends the whole pool of workers. The next pool makes the shards
    that are still missing."""
    losses, reported = 0, set()
    context = multiprocessing.get_context("spawn")
    while True:
        waiting = [shard for shard in shards if shard not in reported]
        if not waiting:
            return
        pool = ProcessPoolExecutor(min(workers, len(waiting)), mp_context=context)
        try:
            pending = {pool.submit(make_shard, options, dataset, shard, os.getpid()): shard for shard in waiting}
            for done in as_completed(pending):
                report(pending[done], done.result())
                reported.add(pending[done])
        except BrokenProcessPool:
            losses += 1
            for shard in waiting:
                if shard not in reported and is_made(dataset, shard):
                    report(shard, options.frames_of(shard))
                    reported.add(shard)
            if len(reported) > len(shards) - len(waiting):
                losses = 1
            if losses > LOSSES_MAX:
                raise StoreError(
                    "workers were killed %d times; is there enough memory? Remedy: fewer --workers, then resume"
                    % losses
                ) from None
            print("a worker was killed; its shards are made again", file=sys.stderr)
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _run_on_ray(options: Options, dataset: Path, shards: Sequence[int], workers: int, report: Report) -> None:
    try:
        import ray  # type: ignore[import-not-found, unused-ignore]
    except ImportError as error:
        raise UsageError("--executor ray: Ray is not installed. Remedy: pip install ray") from error
    if not ray.is_initialized():
        address = os.environ.get("RAY_ADDRESS")
        more: dict[str, Any] = {"address": address} if address else {"num_cpus": workers, "include_dashboard": False}
        ray.init(log_to_driver=False, logging_level="ERROR", **more)
    remote = ray.remote(num_cpus=1, max_retries=RAY_RETRIES)(make_shard)
    limit = max(1, int(ray.cluster_resources().get("CPU", workers))) * RAY_WAITING
    waiting, running = list(reversed(shards)), dict[Any, int]()
    try:
        while waiting or running:
            while waiting and len(running) < limit:
                shard = waiting.pop()
                running[remote.remote(options, dataset.resolve(), shard)] = shard
            done, _ = ray.wait(list(running), num_returns=1)
            for one in done:
                report(running.pop(one), ray.get(one))
    finally:
        ray.shutdown()
