"""Each block of a shard, which has one view, is written as one DICOM file: an X-Ray Angiographic Image with overlays.

The pixels are the values of the detector, which are proportional to the X-ray intensity. Each kind of mask is an
overlay plane of all frames (PS3.3, C.9.2) in group 6000 or one of the next even groups, and the overlay's label names
the kind. Private elements (group 0023) hold the projection and the tips of the tools, because this class of DICOM
images has no attribute for them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ...xray import Label
from ..frame import LabelledFrame
from ..options import Options
from ..plan import ShardPlan
from ..store import ShardFolder
from .elements import Elements, file_of, uid

XA_CLASS = "1.2.840.10008.5.1.4.1.1.12.1"
DIRECTION_MIN = 0.26  # cosine of 75 degrees: directions that are farther from an axis of the picture are not named
LETTERS = (("L", "R"), ("H", "F"), ("A", "P"))


def _letters(axis: npt.NDArray[np.float64]) -> str:
    """Returns the letters of the patient's directions, such as L for left, towards which an axis of the picture points;
    the direction with the smallest angle comes first."""
    order = sorted(range(3), key=lambda k: -abs(axis[k]))
    return "".join(LETTERS[k][0 if axis[k] > 0 else 1] for k in order if abs(axis[k]) > DIRECTION_MIN)


def orientation_of(frame: LabelledFrame) -> tuple[str, str]:
    """Returns the patient's directions towards which the picture's right edge and its lower edge lie."""
    rows = frame.projection[:, :3] / np.linalg.norm(frame.projection[2, :3])
    middle = len(frame.labels) * 0.5
    right, down = rows[0] - middle * rows[2], rows[1] - middle * rows[2]
    return _letters(right / np.linalg.norm(right)), _letters(down / np.linalg.norm(down))


class DicomWriter:
    """Writes one file for each block of a shard."""

    def __init__(self, options: Options, plan: ShardPlan, folder: ShardFolder) -> None:
        self._options, self._plan, self._folder = options, plan, folder
        self._key = ("seed %d" % options.seed, repr(sorted(options.as_json().items())), "shard %d" % plan.shard)
        self._frames: list[LabelledFrame] = []
        self._raw: list[bytes] = []
        self._labels: list[npt.NDArray[np.uint8]] = []
        self._files = 0

    def add(self, frame: LabelledFrame) -> None:
        if self._frames and self._frames[-1].block != frame.block:
            self._write()
        self._frames.append(frame)
        self._raw.append(frame.raw.astype("<u2").tobytes())
        self._labels.append(frame.labels.copy())

    def end(self) -> dict[str, Any]:
        self._write()
        return {"files": self._files}

    def _write(self) -> None:
        if not self._frames:
            return
        block, made = self._frames[0].block, Elements()
        instance = uid("image %d" % block, *self._key)
        self._put_patient_and_study(made, instance)
        self._put_picture(made)
        self._put_times(made)
        self._put_technique(made)
        self._put_labels(made)
        made.put(0x7FE00010, "OW", b"".join(self._raw))
        name = "dicom/%06d/%06d-%03d.dcm" % (self._plan.shard, self._plan.shard, block)
        self._folder.put(name, file_of(XA_CLASS, instance, made))
        self._files += 1
        self._frames, self._raw, self._labels = [], [], []

    def _put_patient_and_study(self, made: Elements, instance: str) -> None:
        made.text(0x00080005, "CS", "ISO_IR 192")
        made.text(0x00080008, "CS", "ORIGINAL", "PRIMARY", "SINGLE PLANE")
        made.text(0x00080016, "UI", XA_CLASS)
        made.text(0x00080018, "UI", instance)
        for empty, kind in ((0x00080020, "DA"), (0x00080030, "TM"), (0x00080050, "SH"), (0x00080090, "PN")):
            made.text(empty, kind, "")
        made.text(0x00080060, "CS", "XA")
        made.text(0x00080070, "LO", "Cournand")
        made.text(0x0008103E, "LO", "Simulated angiography")
        made.text(0x00081090, "LO", "Cournand factory")
        made.text(0x00100010, "PN", "Anonymous^")
        made.text(0x00100020, "LO", "ANON-%06d" % self._plan.shard)
        made.text(0x00100030, "DA", "")
        made.text(0x00100040, "CS", "")
        made.text(0x00120062, "CS", "YES")
        made.text(0x00120063, "LO", "simulated: there is no person")
        made.text(0x0020000D, "UI", uid("study", *self._key))
        made.text(0x0020000E, "UI", uid("series", *self._key))
        made.text(0x00200010, "SH", "1")
        made.wholes(0x00200011, [1])
        made.wholes(0x00200013, [self._frames[0].block + 1])
        made.text(0x00200020, "CS", *orientation_of(self._frames[0]))
        made.text(0x00200060, "CS", "")
        made.text(0x00204000, "LT", "Simulated by Cournand; not a picture of a person")
        made.text(0x00280300, "CS", "YES")
        made.text(0x00280301, "CS", "NO")
        made.text(0x00282110, "CS", "00")

    def _put_picture(self, made: Elements) -> None:
        size = self._options.size
        made.shorts(0x00280002, [1])
        made.text(0x00280004, "CS", "MONOCHROME2")
        made.shorts(0x00280010, [size])
        made.shorts(0x00280011, [size])
        made.shorts(0x00280100, [16])
        made.shorts(0x00280101, [16])
        made.shorts(0x00280102, [15])
        made.shorts(0x00280103, [0])
        made.text(0x00281040, "CS", "LIN")
        low, high = np.percentile(np.frombuffer(self._raw[0], "<u2"), (1.0, 99.0))
        made.decimals(0x00281050, [float(low + high) / 2])
        made.decimals(0x00281051, [max(float(high - low), 1.0)])
        pixel_mm = self._frames[0].view.field_m * 1e3 / size
        made.decimals(0x00181164, [pixel_mm, pixel_mm])

    def _put_times(self, made: Elements) -> None:
        count, rate = len(self._frames), self._options.pulses_per_s
        made.wholes(0x00280008, [count])
        made.shorts(0x00280009, [0x0018, 0x1063], "AT")
        made.decimals(0x00181063, [1000.0 / rate])
        made.wholes(0x00180040, [max(1, round(rate))])
        made.wholes(0x00082144, [max(1, round(rate))])

    def _put_technique(self, made: Elements) -> None:
        view, pictures = self._frames[0].view, [frame.picture for frame in self._frames]
        total_ms = sum(one.pulse_ms for one in pictures)
        mean_mA = sum(one.tube_current_mA for one in pictures) / len(pictures)
        made.decimals(0x00180060, [sum(one.tube_voltage_kV for one in pictures) / len(pictures)])
        made.wholes(0x00181150, [max(1, round(total_ms))])
        made.wholes(0x00181151, [max(1, round(mean_mA))])
        made.wholes(0x00181152, [max(1, math.ceil(total_ms * mean_mA * 1e-3))])
        made.decimals(0x00181154, [total_ms / len(pictures)])
        made.decimals(0x0018115E, [sum(one.kap_Gy_cm2 for one in pictures) * 10.0])
        made.text(0x00181155, "CS", "SC")
        made.text(0x0018115A, "CS", "PULSED")
        made.decimals(0x00181110, [view.source_detector_m * 1e3])
        made.decimals(0x00181111, [view.source_isocentre_m * 1e3])
        made.decimals(0x00181114, [view.source_detector_m / view.source_isocentre_m])
        made.text(0x00181147, "CS", "RECTANGLE")
        made.wholes(0x00181149, [round(view.field_m * 1e3)] * 2)
        made.text(0x00181500, "CS", "STATIC")
        made.decimals(0x00181510, [view.primary_deg])
        made.decimals(0x00181511, [view.secondary_deg])
        made.text(0x00181134, "CS", "STATIC")

    def _put_labels(self, made: Elements) -> None:
        labels, size, group = np.stack(self._labels), self._options.size, 0x6000
        for label in Label:
            mask = (labels & np.uint8(label)) != 0
            if not mask.any():
                continue
            tag = group << 16
            made.shorts(tag | 0x0010, [size])
            made.shorts(tag | 0x0011, [size])
            made.wholes(tag | 0x0015, [len(labels)])
            made.text(tag | 0x0022, "LO", (label.name or "").lower())
            made.text(tag | 0x0040, "CS", "G")
            made.shorts(tag | 0x0050, [1, 1], "SS")
            made.shorts(tag | 0x0051, [1])
            made.shorts(tag | 0x0100, [1])
            made.shorts(tag | 0x0102, [0])
            made.text(tag | 0x1500, "LO", label.name or "")
            made.put(tag | 0x3000, "OW", np.packbits(mask, axis=None, bitorder="little").tobytes())
            group += 2
        made.text(0x00230010, "LO", "COURNAND 1.0")
        made.wholes(0x00231001, [frame.facts["tick"] for frame in self._frames])
        made.doubles(0x00231010, self._frames[0].projection.ravel().tolist())
        made.doubles(0x00231011, [number for frame in self._frames for number in _tips(frame)])


def _tips(frame: LabelledFrame) -> list[float]:
    """Returns column, row and visibility of the tool's tip for each of the three positions; a position without a tool
    has zeros."""
    found = {tool.position: tool.tip for tool in frame.tools}
    rows = [(*found[k].px, float(found[k].visibility)) if k in found else (0.0, 0.0, 0.0) for k in range(3)]
    return [number for row in rows for number in row]
