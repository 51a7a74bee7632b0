"""The course of a shard: a world whose tools move as planned, and its frames with their labels."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from ..errors import RefusedError
from ..scene import Scene, Tool
from ..world import TICKS_PER_S, Order, World
from ..xray import View, XRay
from .frame import Axis, LabelledFrame, ToolLabel, areas_of, projection_of, trace
from .options import Options
from .plan import Block, Injection, ShardPlan, noise_seeds, open_tool

APPROACH_M_PER_S = 0.1
RATE, BREATH = 1, 5  # actions of the order RHYTHM
SCENES_KEPT = 2


class OutOfRange(Exception):
    """The physics of a shard's world left the range in which it is valid."""


@lru_cache(maxsize=SCENES_KEPT)
def _opened(scene: str, size: int) -> tuple[Scene, XRay, float]:
    """Returns a scene, its renderer, and the length of the longest way through the scene's vessels in m."""
    opened = Scene(scene)
    ways: list[float] = []
    for vessel in opened.vessels:  # parents have lower numbers
        ways.append(vessel.length_m + (ways[vessel.parent] if vessel.parent >= 0 else 0.0))
    return opened, XRay(opened, size), max(ways, default=0.2)


def _kind(tool: Tool) -> str:
    return "balloon catheter" if tool.has_balloon else "catheter" if tool.is_catheter else "guidewire"


class Course:
    """The simulated world of one shard, and the shard's frames in order."""

    def __init__(self, options: Options, plan: ShardPlan) -> None:
        self._options, self._plan = options, plan
        self._scene, self._xray, longest_m = _opened(plan.scene, options.size)
        self._tools = [open_tool(name).scaled(**factors) for name, factors in zip(plan.tools, plan.factors)]
        self._kinds = [_kind(tool) for tool in self._tools]
        self._can_inject = any(tool.is_catheter for tool in self._tools)
        has_stent = plan.stent != ""
        self._world = World(
            self._scene, self._tools, patient=self._can_inject, stents=[plan.stent] if has_stent else []
        )
        self._world.order(Order.RHYTHM, RATE, plan.heart_per_min)
        self._world.order(Order.RHYTHM, BREATH, plan.breath_per_min)
        if has_stent and self._world.patient is not None:
            self._world.patient.load_stent()
        self._seeds = noise_seeds(options, plan.shard, plan.attempt, plan.frames)
        self._refusal = ""
        ticks = round(plan.approach_part * longest_m / APPROACH_M_PER_S * TICKS_PER_S)
        self._world.move([APPROACH_M_PER_S] * len(self._tools), ticks=ticks)
        self._first_tick = self._world.tick

    def frames(self) -> Iterator[LabelledFrame]:
        """Yields the frames of the shard. The arrays of a frame's pictures are overwritten when the next frame is
        made."""
        number = 0
        for count, block in enumerate(self._plan.blocks):
            view = self._view(block)
            projection = projection_of(view, self._options.size)
            for frame in range(block.frames):
                if block.injection is not None and block.injection.frame == frame:
                    self._inject(block.injection)
                self._move(block, number)
                yield self._frame(number, count, block, view, projection)
                number += 1

    def _view(self, block: Block) -> View:
        """Returns a view whose middle is the tip of the leading tool, moved by the offset that the plan drew for this
        block."""
        tip = self._world.pose().positions_m[0]
        x, y, z = (round(float(np.clip(tip[k] + block.offset_m[k], -1.9, 1.9)), 4) for k in range(3))
        return View(
            primary_deg=block.primary_deg,
            secondary_deg=block.secondary_deg,
            isocentre_m=(x, y, z),
            field_m=block.field_m,
            dose_nGy=block.dose_nGy,
        )

    def _move(self, block: Block, number: int) -> None:
        ticks = TICKS_PER_S / self._options.pulses_per_s
        count = round((number + 1) * ticks) - round(number * ticks)
        self._world.move(block.push_m_per_s, block.turn_rad_per_s, ticks=count, inflator_kPa=block.inflator_kPa)
        if self._world.read().out_of_range_tick is not None:
            raise OutOfRange("tick %d" % self._world.tick)

    def _inject(self, injection: Injection) -> None:
        """Injects contrast medium if the tools leave room for it: a wire in a catheter may leave too little space."""
        patient = self._world.patient
        if patient is None:
            return
        try:
            patient.inject(
                injection.volume_ml, ml_per_s=injection.flow_ml_per_s, iodine_mg_per_ml=injection.iodine_mg_per_ml
            )
        except RefusedError as refusal:
            self._refusal = str(refusal)

    def _frame(self, number: int, count: int, block: Block, view: View, projection: Any) -> LabelledFrame:
        picture = self._xray.render(self._world, view, labels=True, seed=self._seeds[number], copy=False)
        assert picture.labels is not None
        areas = areas_of(picture.labels)
        shard = self._plan.shard
        return LabelledFrame(
            key="%06d-%05d" % (shard, number),
            index=shard * self._options.shard_frames + number,
            shard=shard,
            number=number,
            block=count,
            picture=picture,
            view=view,
            projection=projection,
            tools=self._label_tools(projection, picture.labels),
            action=(*block.push_m_per_s, *block.turn_rad_per_s, block.inflator_kPa),
            force_N=self._world.read().force_N,
            areas=areas,
            facts=self._facts(block, areas),
        )

    def _label_tools(self, projection: Any, labels: Any) -> tuple[ToolLabel, ...]:
        axis = Axis(self._world.pose())
        inserted = self._world.read().inserted_m
        made = []
        for position, tool in enumerate(self._tools):
            if not axis.is_inside(position):
                continue
            found = trace(axis, position, [arc * 1e3 for arc in tool.markers_m], projection, labels)
            made.append(
                ToolLabel(
                    position=position,
                    file=self._plan.tools[position],
                    name=tool.name,
                    kind=self._kinds[position],
                    inserted_mm=round(inserted[position] * 1e3, 3),
                    vessel=self._world.tip(position).name,
                    tip=found.tip,
                    markers=found.markers,
                    centreline=found.centreline,
                    keypoints=found.keypoints,
                )
            )
        return tuple(made)

    def _facts(self, block: Block, areas: dict[str, int]) -> dict[str, Any]:
        reading = self._world.read()
        facts: dict[str, Any] = {
            "scene": self._plan.scene,
            "motion": block.motion,
            "tick": reading.tick,
            "time_s": round((reading.tick - self._first_tick) / TICKS_PER_S, 3),
            "heart_phase": round(reading.heart_phase, 6),
            "breath_phase": round(reading.breath_phase, 6),
            "heart_per_min": self._plan.heart_per_min,
            "breath_per_min": self._plan.breath_per_min,
            "fault_bits": reading.fault_bits,
            "contrast_phase": "none",
        }
        if self._world.patient is not None:
            patient = self._world.patient.read()
            is_flowing = patient.injection_flow_ml_per_s > 0.0
            is_seen = areas["MEDIUM"] > 0
            if is_flowing:
                facts["contrast_phase"] = "injection"
            elif patient.injected_ml > 0.0:
                facts["contrast_phase"] = "washout" if is_seen else "gone"
            facts["injected_ml"] = round(patient.injected_ml, 4)
            facts["injection_ml_per_s"] = round(patient.injection_flow_ml_per_s, 4)
            facts["stent"] = patient.stent_stage
            if self._refusal:
                facts["injection_refused"] = self._refusal
            if "balloon catheter" in self._kinds:
                facts["balloon_kPa"] = round(reading.balloon_kPa, 3)
                facts["balloon_diameter_mm"] = round(reading.balloon_diameter_max_m * 1e3, 4)
        return facts
