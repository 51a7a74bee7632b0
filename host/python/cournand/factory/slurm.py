"""Makes a Slurm script: a job array whose tasks divide the shards, and a final job that completes the data set."""

from __future__ import annotations

import shlex
from pathlib import Path

TEMPLATE = """#!/bin/sh
# Makes the data set {dataset} by an array of {tasks} tasks, and completes it when all have ended.
# Save this text as factory.sh, and begin with: sh factory.sh submit
# A task that is stopped and queued again continues: it makes only the shards that have no manifest.
#SBATCH --job-name=cournand-factory
#SBATCH --array=0-{last}
#SBATCH --cpus-per-task={cpus}
#SBATCH --mem-per-cpu=1500M
#SBATCH --time={time}
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=factory-%A-%a.log
set -eu
if [ "${{1:-}}" = submit ]; then
    array=$(sbatch --parsable "$0")
    exec sbatch --dependency=afterok:"$array" --array=0 --job-name=cournand-factory-end "$0" end
fi
export OMP_NUM_THREADS=1
if [ "${{1:-}}" = end ]; then
    exec {python} -m cournand.factory resume {dataset} --workers {cpus}
fi
exec {python} -m cournand.factory resume {dataset} --workers {cpus} --shards "$SLURM_ARRAY_TASK_ID/{tasks}"
"""


def script(dataset: Path, tasks: int, cpus: int, time: str, python: str) -> str:
    return TEMPLATE.format(
        dataset=shlex.quote(str(dataset)),
        tasks=tasks,
        last=tasks - 1,
        cpus=cpus,
        time=time,
        python=shlex.quote(python),
    )
