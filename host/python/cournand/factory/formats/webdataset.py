"""WebDataset: one tar file for each shard, which any program that reads tar can read.

The members of a frame begin with its key, such as 000012-00003, which is unique in the data set. All files in the tar
file have no owner and the time 0, so equal frames give equal tar files.
"""

from __future__ import annotations

import io
import json
import tarfile
from typing import Any

import numpy as np

from .. import png
from ..frame import COLUMNS, LabelledFrame, Point, ToolLabel
from ..options import Options
from ..plan import ShardPlan
from ..store import ShardFolder

_BLOCK = tarfile.BLOCKSIZE
_RECORD = tarfile.RECORDSIZE


def _empty_header() -> bytes:
    info = tarfile.TarInfo("")
    info.mode = 0o644
    return info.tobuf(tarfile.USTAR_FORMAT)


_HEADER = _empty_header()
_NAME, _SIZE, _SUM = slice(0, 100), slice(124, 136), slice(148, 156)  # fields of a header
_SUM_OF_REST = sum(_HEADER) - sum(_HEADER[_SIZE]) - sum(_HEADER[_SUM]) + sum(b" " * 8)


def header(name: str, size: int) -> bytes:
    """Returns the header of a member, as tarfile makes it. The general code of tarfile takes ten times as long."""
    name_field, size_field = name.encode("ascii").ljust(100, b"\0"), b"%011o\0" % size
    if len(name_field) > 100 or len(size_field) > 12:
        raise ValueError("%s: a tar file cannot hold this name with %d bytes" % (name, size))
    made = bytearray(_HEADER)
    made[_NAME], made[_SIZE] = name_field, size_field
    made[_SUM] = b"%06o\0 " % (_SUM_OF_REST + sum(name_field) + sum(size_field))
    return bytes(made)


def _point(point: Point) -> dict[str, Any]:
    return {"mm": point.mm, "px": point.px, "visibility": point.visibility}


def _tool(tool: ToolLabel) -> dict[str, Any]:
    return {
        "position": tool.position,
        "bit": 1 << tool.position,
        "file": tool.file,
        "name": tool.name,
        "kind": tool.kind,
        "inserted_mm": tool.inserted_mm,
        "vessel": tool.vessel,
        "tip": _point(tool.tip),
        "markers": [_point(marker) for marker in tool.markers],
    }


def facts_of(frame: LabelledFrame) -> dict[str, Any]:
    """Returns everything of a frame but its arrays, for JSON."""
    view, picture = frame.view, frame.picture
    return {
        "key": frame.key,
        "index": frame.index,
        "shard": frame.shard,
        "frame": frame.number,
        "block": frame.block,
        "size": len(frame.labels),
        **frame.facts,
        "tools": [_tool(tool) for tool in frame.tools],
        "areas_px": frame.areas,
        "action": frame.action,
        "force_N": [round(force, 4) for force in frame.force_N],
        "view": {
            "primary_deg": view.primary_deg,
            "secondary_deg": view.secondary_deg,
            "isocentre_mm": [round(one * 1e3, 3) for one in view.isocentre_m],
            "source_detector_mm": view.source_detector_m * 1e3,
            "source_isocentre_mm": view.source_isocentre_m * 1e3,
            "field_mm": round(view.field_m * 1e3, 3),
        },
        "projection": frame.projection.tolist(),
        "dose": {
            "detector_nGy": view.dose_nGy,
            "tube_voltage_kV": round(picture.tube_voltage_kV, 3),
            "tube_current_mA": round(picture.tube_current_mA, 3),
            "pulse_ms": round(picture.pulse_ms, 3),
            "air_kerma_uGy": round(picture.air_kerma_uGy, 6),
            "kap_Gy_cm2": round(picture.kap_Gy_cm2, 9),
            "is_underexposed": bool(picture.is_underexposed),
        },
    }


def centrelines_of(frame: LabelledFrame) -> bytes:
    """Returns the centrelines of all tools as a NumPy file, float32 [n, 8] with the columns COLUMNS."""
    lines = [tool.centreline for tool in frame.tools]
    rows = np.concatenate(lines) if lines else np.zeros((0, len(COLUMNS)))
    file = io.BytesIO()
    np.save(file, rows.astype(np.float32))
    return file.getvalue()


class WebDatasetWriter:
    """Writes the tar file of a shard."""

    def __init__(self, options: Options, plan: ShardPlan, folder: ShardFolder) -> None:
        self._compression = options.compression
        self._folder, self._name = folder, "webdataset/%06d.tar" % plan.shard
        self._tar = folder.open(self._name)

    def _member(self, name: str, content: bytes) -> None:
        self._tar.write(header(name, len(content)))
        self._tar.write(content)
        self._tar.write(bytes(-len(content) % _BLOCK))

    def add(self, frame: LabelledFrame) -> None:
        self._member(frame.key + ".raw.png", png.encode(frame.raw, self._compression))
        self._member(frame.key + ".grey.png", png.encode(frame.grey, self._compression))
        self._member(frame.key + ".labels.png", png.encode(frame.labels, "flat"))
        self._member(frame.key + ".centrelines.npy", centrelines_of(frame))
        self._member(frame.key + ".json", json.dumps(facts_of(frame)).encode())

    def end(self) -> dict[str, Any]:
        self._tar.write(bytes(2 * _BLOCK))
        self._tar.write(bytes(-self._tar.bytes % _RECORD))
        self._folder.close(self._name)
        return {}
