"""The formats of a data set. Each format has a class that writes the files of one shard."""

from __future__ import annotations

from typing import Any, Protocol

from ..frame import LabelledFrame
from ..options import Options
from ..plan import ShardPlan
from ..store import ShardFolder


class Writer(Protocol):
    """Writes one shard in one format."""

    def add(self, frame: LabelledFrame) -> None:
        """Writes a frame. The caller overwrites the frame's pictures after the call."""

    def end(self) -> dict[str, Any]:
        """Ends the shard, and returns what its manifest must keep for the completion of the data set."""


def writers(options: Options, plan: ShardPlan, folder: ShardFolder) -> dict[str, Writer]:
    """Returns the writers of a shard by the names of their formats."""
    made: dict[str, Writer] = {}
    for name in options.formats:
        if name == "webdataset":
            from .webdataset import WebDatasetWriter

            made[name] = WebDatasetWriter(options, plan, folder)
        elif name == "coco":
            from .coco import CocoWriter

            made[name] = CocoWriter(options, plan, folder)
        elif name == "dicom":
            from .dicom import DicomWriter

            made[name] = DicomWriter(options, plan, folder)
        else:
            from .lerobot import LeRobotWriter

            made[name] = LeRobotWriter(options, plan, folder)
    return made
