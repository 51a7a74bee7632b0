"""The plan of a shard: all values that are drawn at random for it, from nothing but the data set's seed and the shard's
number.

If the physics of a shard leaves its valid range, or its tools are refused, the shard is planned again with the next
number of attempt. The new attempt keeps the scene and the set of tools; the course and the factors on the tools'
properties depend on the attempt's number. A shard therefore has the same content on every machine, and a set of tools
whose first attempts fail is no rarer than the other sets.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..randomise import TOOL_FACTORS
from ..scene import Tool
from .options import DOSE_NGY, Options, split_tools

ATTEMPTS = 12
AS_SHIPPED = 6  # from this attempt on, the tools have the stiffness of their files
# Streams of random numbers. Each is of its own, so that a new draw of one does not change the others.
_SCENE, _TOOLS, _RHYTHM, _COURSE, _VIEWS, _CONTRAST, _NOISE, _SAMPLE = range(8)

APPROACH_PART = (0.05, 0.75)  # of the longest way through the vessels
MOTIONS = ("advance", "advance inner", "advance outer", "withdraw", "withdraw inner", "turn", "rest")
MOTION_WEIGHTS = (0.3, 0.2, 0.15, 0.08, 0.1, 0.12, 0.05)
SPEED_M_PER_S = (0.005, 0.04)
TURN_RAD_PER_S = (-3.14, 3.14)
FIELD_M = (0.14, 0.32)
INJECTION_PART = 0.45  # of the blocks, if a tool can inject
VOLUME_ML, FLOW_ML_PER_S = (3.0, 12.0), (2.0, 8.0)
IODINE_MG_PER_ML = (140.0, 240.0, 300.0, 350.0)
HEART_PER_MIN, BREATH_PER_MIN = (50, 120), (10, 20)
BALLOON_KPA = (400.0, 1200.0)
INFLATION_PART = 0.5  # of the blocks, if a tool has a balloon


class Injection(NamedTuple):
    """An injection of contrast medium, which begins with one frame of a block."""

    frame: int
    volume_ml: float
    flow_ml_per_s: float
    iodine_mg_per_ml: float


@dataclass(frozen=True)
class Block:
    """A sequence of frames that have one view."""

    frames: int
    motion: str
    push_m_per_s: tuple[float, ...]
    turn_rad_per_s: tuple[float, ...]
    inflator_kPa: float
    primary_deg: float
    secondary_deg: float
    field_m: float
    dose_nGy: float
    offset_m: tuple[float, float, float]
    injection: Injection | None


@dataclass(frozen=True)
class ShardPlan:
    """The course of one shard."""

    shard: int
    attempt: int
    frames: int
    scene: str
    tools: tuple[str, ...]
    stent: str
    factors: tuple[dict[str, float], ...]
    """For each tool, the factors with which Tool.scaled() changes its properties."""
    heart_per_min: int
    breath_per_min: int
    approach_part: float
    blocks: tuple[Block, ...]
    sample: int
    """The number of the frame that represents the shard on the page of statistics."""


@lru_cache(maxsize=64)
def open_tool(name: str) -> Tool:
    return Tool(name)


def _stream(options: Options, shard: int, attempt: int, which: int) -> np.random.Generator:
    return np.random.default_rng([options.seed, shard, attempt, which])


def noise_seeds(options: Options, shard: int, attempt: int, frames: int) -> list[int]:
    """Returns a seed for the noise of each frame of a shard."""
    words = np.random.SeedSequence([options.seed, shard, attempt, _NOISE]).generate_state(frames, np.uint64)
    return [int(word) for word in words]


def plan_shard(options: Options, shard: int, attempt: int = 0) -> ShardPlan:
    """Draws all values of a shard's plan from streams of random numbers."""
    frames = options.frames_of(shard)
    chosen = _stream(options, shard, 0, _SCENE)
    scene = options.scenes[int(chosen.integers(len(options.scenes)))]
    names, stent = split_tools(options.tools[int(chosen.integers(len(options.tools)))])
    random = _stream(options, shard, attempt, _TOOLS)
    drawn = [options.variation.draw(random) for _ in names]
    factors = tuple(
        {name: round(one[name], 4) if attempt < AS_SHIPPED else 1.0 for name in TOOL_FACTORS} for one in drawn
    )
    rhythm = _stream(options, shard, attempt, _RHYTHM)
    course = _stream(options, shard, attempt, _COURSE)
    approach = round(float(course.uniform(*APPROACH_PART)), 4)
    has_balloon = any(open_tool(name).has_balloon for name in names)
    views = _stream(options, shard, attempt, _VIEWS)
    contrast = _stream(options, shard, attempt, _CONTRAST)
    blocks = []
    for first in range(0, options.shard_frames, options.block_frames):  # a short last shard begins as a whole one
        count = min(options.block_frames, frames - first)
        block = _draw_block(options, max(count, 1), len(names), has_balloon, course, views, contrast)
        if count > 0:
            blocks.append(block)
    return ShardPlan(
        shard,
        attempt,
        frames,
        scene,
        tuple(names),
        stent,
        factors,
        int(rhythm.integers(HEART_PER_MIN[0], HEART_PER_MIN[1] + 1)),
        int(rhythm.integers(BREATH_PER_MIN[0], BREATH_PER_MIN[1] + 1)),
        approach,
        tuple(blocks),
        int(_stream(options, shard, attempt, _SAMPLE).integers(frames)),
    )


def _draw_block(
    options: Options,
    frames: int,
    tools: int,
    has_balloon: bool,
    course: np.random.Generator,
    views: np.random.Generator,
    contrast: np.random.Generator,
) -> Block:
    motion, push, turn = _draw_motion(tools, course)
    inflation = course.uniform(size=2)
    pressure = round(BALLOON_KPA[0] + float(inflation[1]) * (BALLOON_KPA[1] - BALLOON_KPA[0]), 0)
    is_inflated = has_balloon and inflation[0] < INFLATION_PART
    if is_inflated:  # a person inflates a balloon that is at rest
        motion, push, turn = "rest", (0.0,) * tools, (0.0,) * tools
    drawn = options.variation.draw(views)
    field_m = round(float(views.uniform(*FIELD_M)), 3)
    offset = views.uniform(-options.offset_part, options.offset_part, size=3) * field_m
    return Block(
        frames,
        motion,
        push,
        turn,
        pressure if is_inflated else 0.0,
        _rounded_within(drawn["primary_deg"], options.variation.primary_deg),
        _rounded_within(drawn["secondary_deg"], options.variation.secondary_deg),
        field_m,
        round(DOSE_NGY * _even_in_log(drawn["dose"], options.variation.dose), 2),
        (round(float(offset[0]), 4), round(float(offset[1]), 4), round(float(offset[2]), 4)),
        _draw_injection(frames, options.block_frames, contrast),
    )


def _rounded_within(angle_deg: float, limits: tuple[float, float]) -> float:
    """Rounds an angle to 0.1 degrees, but not beyond its limits."""
    return min(max(round(angle_deg, 1), limits[0]), limits[1])


def _even_in_log(value: float, limits: tuple[float, float]) -> float:
    """Turns a value that is evenly distributed within limits above 0 into one whose logarithm is evenly distributed, so
    that low doses are as frequent as high ones."""
    low, high = limits
    if not 0.0 < low < high:
        return value
    return float(low * (high / low) ** ((value - low) / (high - low)))


def _draw_motion(tools: int, course: np.random.Generator) -> tuple[str, tuple[float, ...], tuple[float, ...]]:
    """Draws the kind of motion, and for each tool the speed of its push and of its turn. If there is only one tool, it
    counts as the innermost and as the outermost one."""
    motion = MOTIONS[int(course.choice(len(MOTIONS), p=MOTION_WEIGHTS))]
    speed = round(float(course.uniform(*SPEED_M_PER_S)), 4)
    turn = round(float(course.uniform(*TURN_RAD_PER_S)), 3)
    which = int(course.integers(tools))
    everyone, nobody = range(tools), range(0)
    inner, outer = range(0, 1), range(tools - 1, tools)
    pushed = {"advance": everyone, "advance inner": inner, "advance outer": outer}.get(motion, nobody)
    pulled = {"withdraw": everyone, "withdraw inner": inner}.get(motion, nobody)
    push = tuple(speed if k in pushed else -speed if k in pulled else 0.0 for k in range(tools))
    turned = [which] if motion in ("turn", "advance", "advance inner") else []
    return motion, push, tuple(turn if k in turned else 0.0 for k in range(tools))


def _draw_injection(frames: int, block_frames: int, contrast: np.random.Generator) -> Injection | None:
    drawn = contrast.uniform(size=4)
    strength = IODINE_MG_PER_ML[int(contrast.integers(len(IODINE_MG_PER_ML)))]
    if drawn[0] >= INJECTION_PART:
        return None
    frame = int(drawn[1] * block_frames * 0.5)
    volume = round(VOLUME_ML[0] + float(drawn[2]) * (VOLUME_ML[1] - VOLUME_ML[0]), 2)
    flow = round(FLOW_ML_PER_S[0] + float(drawn[3]) * (FLOW_ML_PER_S[1] - FLOW_ML_PER_S[0]), 2)
    return Injection(frame, volume, flow, strength) if frame < frames else None


def describe(plan: ShardPlan) -> dict[str, Any]:
    """Returns the main values of a plan as one row of a table for a person."""
    return {
        "shard": plan.shard,
        "frames": plan.frames,
        "scene": plan.scene,
        "tools": "+".join(plan.tools) + ("@" + plan.stent if plan.stent else ""),
        "heart_per_min": plan.heart_per_min,
        "blocks": len(plan.blocks),
        "injections": sum(block.injection is not None for block in plan.blocks),
    }
