"""The factory of labelled angiograms: data sets of simulated X-ray pictures with masks, centrelines and geometry.

    python -m cournand.factory --frames 1000 --seed 1 --out DIR

The page docs/factory.md is the guide. Files of this package, in the order of the work: options (what is asked for),
plan (what is drawn for a shard), course (a world that moves as planned), frame (one picture with its labels), formats
(how it is written), shard (the unit of work), store (files that appear whole), executors (who makes the shards),
dataset (what describes all shards), cli (the command line).
"""

from .course import Course
from .frame import LabelledFrame, ToolLabel
from .options import FORMATS, TOOL_SETS, Options, UsageError
from .plan import ShardPlan, plan_shard
from .shard import make_shard
from .store import StoreError

__all__ = [
    "FORMATS",
    "TOOL_SETS",
    "Course",
    "LabelledFrame",
    "Options",
    "ShardPlan",
    "StoreError",
    "ToolLabel",
    "UsageError",
    "make_shard",
    "plan_shard",
]
