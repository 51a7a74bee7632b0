"""The options from which a data set is made, which stand in its file plan.json."""

from __future__ import annotations

import json
import os
import platform
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

import numpy as np

from .. import CORE_VERSION, __version__
from ..data import is_name, shipped_scenes, shipped_stents, shipped_tools
from ..randomise import Randomise

FORMATS = ("webdataset", "coco", "dicom", "lerobot")
COMPRESSIONS = ("stored", "fast")
SEED_MAX = 2**63 - 1
FRAMES_MAX = 1_000_000_000
PLAN = "plan.json"
FACTORY_VERSION = "2"
"""The version of the encoders and of the choice of scenes, views and motions: it changes when equal options give other
bytes."""

# Sets of tools, from the innermost to the outermost. "@" is followed by a stent on the balloon of the set.
TOOL_SETS = (
    "j_wire",
    "rosen",
    "terumo_stiff_angled",
    "coronary_014",
    "beacon_5f",
    "pigtail_5f",
    "simmons_2_5f",
    "terumo_4f",
    "j_wire+beacon_5f",
    "bentson+pigtail_5f",
    "terumo_stiff_angled+terumo_5f",
    "coronary_014+guide_jr4_6f",
    "rosen+balloon_6x20",
    "rosen+balloon_6x20@renal_6_0x18",
    "coronary_014+balloon_3x20+guide_jl4_6f",
)

VARIATION = Randomise(
    bend_stiffness=(0.7, 1.4),
    twist_stiffness=(0.7, 1.4),
    mass=(0.9, 1.1),
    friction=(0.5, 2.0),
    rest_curvature=(0.7, 1.3),
    primary_deg=(-50.0, 50.0),
    secondary_deg=(-30.0, 30.0),
    dose=(0.25, 4.0),
)


DOSE_NGY = 40.0  # the dose at the detector by which `variation.dose` is multiplied
LIMITS = {"--dose": (1.0, 10000.0), "--primary": (-120.0, 120.0), "--secondary": (-50.0, 50.0)}  # of cournand.View
OFFSET_MAX = 0.45  # of the field, along each axis; from about 0.28 on, the tip can leave the picture


class UsageError(Exception):
    """An option has a value that the factory cannot use; the message names the option and the remedy."""


@dataclass(frozen=True)
class Options:
    """All values that determine the bytes of a data set, except the versions of the programs."""

    frames: int
    seed: int = 0
    size: int = 512
    shard_frames: int = 240
    """The number of frames of a shard; a shard is one simulated course with one set of tools. The last shard has the
    frames that are left."""
    block_frames: int = 24
    """The number of frames of a block; a block has one view, one dose and one motion of the hands."""
    pulses_per_s: float = 15.0
    scenes: tuple[str, ...] = ("aorta",)
    """Shipped names or paths."""
    tools: tuple[str, ...] = TOOL_SETS
    formats: tuple[str, ...] = ("webdataset",)
    compression: str = "stored"
    """The compression of the pictures: "stored" is the fastest, "fast" makes the files smaller by a third. Masks are
    always compressed."""
    variation: Randomise = field(default=VARIATION)
    offset_part: float = 0.24
    """The largest distance from the leading tip to the isocentre along each axis, as a part of the field: 0 shows the
    tip in the middle of the picture."""

    def __post_init__(self) -> None:
        _within("--frames", self.frames, 1, FRAMES_MAX)
        _within("--seed", self.seed, 0, SEED_MAX)
        _within("--shard-frames", self.shard_frames, 1, 100_000)
        _within("--block-frames", self.block_frames, 1, 100_000)
        _within("--pulses", self.pulses_per_s, 0.5, 60.0)
        if not 64 <= self.size <= 2048 or self.size % 16:
            raise UsageError("--size: %r is not a multiple of 16 within 64 and 2048" % (self.size,))
        _within("--offset", self.offset_part, 0.0, OFFSET_MAX)
        low, high = self.variation.dose
        _range("--dose", (DOSE_NGY * low, DOSE_NGY * high))
        _range("--primary", self.variation.primary_deg)
        _range("--secondary", self.variation.secondary_deg)
        _known("--formats", self.formats, FORMATS)
        _known("--compression", (self.compression,), COMPRESSIONS)
        if not self.scenes or not self.tools:
            raise UsageError("--scenes and --tools need at least one name")
        for tools in self.tools:
            check_tools(tools)
        for scene in self.scenes:
            _check_scene(scene)

    @property
    def shards(self) -> int:
        return -(-self.frames // self.shard_frames)

    def frames_of(self, shard: int) -> int:
        """Returns the number of frames of a shard."""
        return min(self.shard_frames, self.frames - shard * self.shard_frames)

    def as_json(self) -> dict[str, Any]:
        return json.loads(json.dumps(asdict(self)))  # type: ignore[no-any-return]


def _within(name: str, value: float, least: float, most: float) -> None:
    if not least <= value <= most:
        raise UsageError("%s: %r is not within %r and %r" % (name, value, least, most))


def _range(name: str, pair: tuple[float, float]) -> None:
    least, most = LIMITS[name]
    if not least <= pair[0] <= pair[1] <= most:
        raise UsageError("%s: %g %g is not a range LOW HIGH within %g and %g" % (name, *pair, least, most))


def varied(dose_nGy: Sequence[float], primary_deg: Sequence[float], secondary_deg: Sequence[float]) -> Randomise:
    """Returns the variation of the factory with other ranges (low, high): of the dose at the detector in nGy, and of
    the two angles of the view in degrees. Raises UsageError if a range is empty."""
    pairs = {"--dose": dose_nGy, "--primary": primary_deg, "--secondary": secondary_deg}
    for name, pair in pairs.items():
        _range(name, (pair[0], pair[1]))
    return replace(
        VARIATION,
        dose=(dose_nGy[0] / DOSE_NGY, dose_nGy[1] / DOSE_NGY),
        primary_deg=(primary_deg[0], primary_deg[1]),
        secondary_deg=(secondary_deg[0], secondary_deg[1]),
    )


def _known(name: str, given: tuple[str, ...], known: tuple[str, ...]) -> None:
    if not given:
        raise UsageError("%s: name at least one of %s" % (name, ", ".join(known)))
    for one in given:
        if one not in known:
            raise UsageError("%s: %r is not one of %s" % (name, one, ", ".join(known)))


def split_tools(text: str) -> tuple[list[str], str]:
    """Returns the tools of a set, and the name of its stent, or "" for a set without a stent."""
    tools, _, stent = text.partition("@")
    return tools.split("+"), stent


def check_tools(text: str) -> None:
    tools, stent = split_tools(text)
    if not 1 <= len(tools) <= 3:
        raise UsageError("--tools: %r has %d tools; a set has one to three" % (text, len(tools)))
    for name in tools:
        bare = name.partition(":")[0]
        if is_name(bare) and bare in shipped_tools() or not is_name(bare) and os.path.exists(bare):
            continue
        raise UsageError(
            "--tools: there is no instrument %r. Name files, or shipped ones: %s" % (name, ", ".join(shipped_tools()))
        )
    if stent and stent not in shipped_stents() and not os.path.exists(stent):
        raise UsageError("--tools: there is no stent %r. There are: %s" % (stent, ", ".join(shipped_stents())))


def _check_scene(scene: str) -> None:
    if scene in shipped_scenes() or not is_name(scene) and os.path.exists(scene):
        return
    raise UsageError(
        "--scenes: there is no scene %r. Name a file, or one of: %s" % (scene, ", ".join(shipped_scenes()))
    )


def versions(options: Options) -> dict[str, str]:
    """Returns the versions of all programs and libraries that can change the bytes of a data set."""
    found = {
        "cournand": __version__,
        "factory": FACTORY_VERSION,
        "core": str(CORE_VERSION),
        "numpy": np.__version__,
        "python": platform.python_version(),
        "zlib": zlib.ZLIB_RUNTIME_VERSION,
    }
    if "lerobot" in options.formats:
        import pyarrow  # type: ignore[import-not-found, import-untyped, unused-ignore]

        found["pyarrow"] = pyarrow.__version__
    return found


def read_options(text: str) -> tuple[Options, dict[str, str]]:
    """Returns the options and the versions of programs that a file plan.json holds."""
    try:
        plan = json.loads(text)
        given = dict(plan["options"])
        given["variation"] = Randomise(**{name: tuple(pair) for name, pair in given["variation"].items()})
        known = {one.name for one in fields(Options)}
        if set(given) != known:
            text = "%s: its options are of another version of the factory. Remedy: begin in an empty folder"
            raise UsageError(text % PLAN)
        lists = {name: tuple(value) for name, value in given.items() if isinstance(value, list)}
        return Options(**{**given, **lists}), dict(plan["versions"])
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UsageError("%s is damaged (%s). Remedy: begin in an empty folder" % (PLAN, error)) from error


def write_options(options: Options) -> str:
    """Returns the text of the file plan.json."""
    plan = {"format": 1, "options": options.as_json(), "versions": versions(options)}
    return json.dumps(plan, indent=1, sort_keys=True) + "\n"
