"""COCO: pictures as PNG files, and one file of annotations with masks and key points.

Each shard has a list of its images and annotations; when the data set is completed, these lists are joined in one file.
The numbers of images and annotations follow from the index of the frame, so they do not depend on the order of work.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ...xray import Label
from .. import png
from ..frame import KEYPOINT_MM, KEYPOINTS, LabelledFrame, ToolLabel
from ..options import Options
from ..plan import ShardPlan
from ..store import ShardFolder, shard_folder
from .rle import annotation_of

FOLDER, ANNOTATIONS = "coco", "annotations.json"
TOOL_KINDS = ("guidewire", "catheter", "balloon catheter")
OTHERS = ((Label.MEDIUM, "contrast medium"), (Label.STENT, "stent"), (Label.BALLOON, "balloon medium"))
PER_FRAME = 8  # annotation numbers of one frame


def categories() -> list[dict[str, Any]]:
    """Returns the categories, with the key points of tools."""
    points = ["tip"] + ["%g mm behind the tip" % (k * KEYPOINT_MM) for k in range(1, KEYPOINTS)]
    lines = [[k, k + 1] for k in range(1, KEYPOINTS)]
    made: list[dict[str, Any]] = []
    for kind in TOOL_KINDS:
        made.append(
            {"id": len(made) + 1, "name": kind, "supercategory": "tool", "keypoints": points, "skeleton": lines}
        )
    for _, name in OTHERS:
        made.append({"id": len(made) + 1, "name": name, "supercategory": "medium or implant"})
    return made


def _tool_annotation(tool: ToolLabel, frame: LabelledFrame) -> dict[str, Any] | None:
    mask = (frame.labels & np.uint8(1 << tool.position)) != 0
    seen = int(np.count_nonzero(tool.keypoints[:, 2]))
    if not mask.any():
        return None
    rounded = np.round(tool.keypoints, 2)
    return {
        **annotation_of(mask),
        "category_id": TOOL_KINDS.index(tool.kind) + 1,
        "keypoints": [number if k % 3 < 2 else int(number) for k, number in enumerate(rounded.ravel().tolist())],
        "num_keypoints": seen,
        "position": tool.position,
        "instrument": tool.file,
    }


def annotations_of(frame: LabelledFrame) -> list[dict[str, Any]]:
    """Returns the annotations of a frame, without those of empty masks."""
    found = [_tool_annotation(tool, frame) for tool in frame.tools]
    made = [one for one in found if one is not None]
    for number, (label, _) in enumerate(OTHERS):
        mask = (frame.labels & np.uint8(label)) != 0
        if mask.any():
            made.append({**annotation_of(mask), "category_id": len(TOOL_KINDS) + number + 1})
    common = {"image_id": frame.index, "iscrowd": 0}
    return [{"id": frame.index * PER_FRAME + k + 1, **common, **one} for k, one in enumerate(made)]


class CocoWriter:
    """Writes the pictures of a shard, and the list of the shard's annotations."""

    def __init__(self, options: Options, plan: ShardPlan, folder: ShardFolder) -> None:
        self._compression, self._folder, self._shard = options.compression, folder, plan.shard
        self._images: list[dict[str, Any]] = []
        self._annotations: list[dict[str, Any]] = []

    def add(self, frame: LabelledFrame) -> None:
        name = "images/%06d/%s.png" % (self._shard, frame.key)
        self._folder.put("%s/%s" % (FOLDER, name), png.encode(frame.grey, self._compression))
        size = len(frame.labels)
        self._images.append(
            {
                "id": frame.index,
                "file_name": name,
                "width": size,
                "height": size,
                "scene": frame.facts["scene"],
                "contrast_phase": frame.facts["contrast_phase"],
                "projection": frame.projection.tolist(),
            }
        )
        self._annotations += annotations_of(frame)

    def end(self) -> dict[str, Any]:
        made = {"images": self._images, "annotations": self._annotations}
        self._folder.put("%s/%s" % (FOLDER, ANNOTATIONS), json.dumps(made).encode())
        return {"images": len(self._images), "annotations": len(self._annotations)}


def merged(dataset: Path, shards: int, info: dict[str, Any]) -> Iterable[bytes]:
    """Yields the text of the file of all annotations, piece by piece. The memory holds the annotations of only one
    shard at a time."""
    yield b'{"info": %s,\n"licenses": [],\n"categories": %s' % (
        json.dumps(info).encode(),
        json.dumps(categories()).encode(),
    )
    for what in ("images", "annotations"):
        yield b',\n"%s": [' % what.encode()
        is_first = True
        for shard in range(shards):
            path = shard_folder(dataset, shard) / FOLDER / ANNOTATIONS
            rows = json.loads(path.read_text(encoding="utf-8"))[what]
            text = ",\n".join(json.dumps(row) for row in rows)
            if text:
                yield (b"\n" if is_first else b",\n") + text.encode()
                is_first = False
        yield b"]"
    yield b"}\n"
