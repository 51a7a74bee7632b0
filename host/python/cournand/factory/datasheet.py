"""The data sheet of a data set: what it holds, how it was made, and what it is not good for."""

from __future__ import annotations

from typing import Any

from ..randomise import TOOL_FACTORS
from .frame import COLUMNS, KEYPOINT_MM, KEYPOINTS
from .options import DOSE_NGY, Options
from .plan import (
    APPROACH_PART,
    BREATH_PER_MIN,
    FIELD_M,
    FLOW_ML_PER_S,
    HEART_PER_MIN,
    IODINE_MG_PER_ML,
    VOLUME_ML,
)

FORMAT_TEXTS = {
    "webdataset": "`webdataset/000000.tar` and so on: for each frame `.raw.png` (16 bits, the detector), `.grey.png` "
    "(8 bits, the monitor), `.labels.png` (bits of the masks), `.centrelines.npy` and `.json`",
    "coco": "`coco/annotations.json` and `coco/images/`: masks as run lengths; for tools %d key points, %g mm apart "
    "from the tip on" % (KEYPOINTS, KEYPOINT_MM),
    "dicom": "`dicom/000000/000000-000.dcm` and so on: X-Ray Angiographic Image Storage, one file for each view, with "
    "an overlay plane for each kind of mask",
    "lerobot": "`lerobot/`: version 3 of the format, one episode for each shard, with pictures inside the table",
}


def _range(pair: tuple[float, float], unit: str = "") -> str:
    return "%g to %g%s" % (pair[0], pair[1], unit)


def _composition(options: Options, manifests: list[dict[str, Any]]) -> list[str]:
    shown = sorted({str(one["scene"]) for one in manifests})
    tools = sorted({"+".join(one["tools"]) + ("@" + one["stent"] if one["stent"] else "") for one in manifests})
    return [
        "## What it holds",
        "",
        "%d simulated X-ray pictures of %d × %d pixels in %d shards. A shard is one course of one set of tools in one "
        "anatomy, at %g pictures per second. No picture shows a person."
        % (options.frames, options.size, options.size, len(manifests), options.pulses_per_s),
        "",
        "- Anatomies: %s" % ", ".join(shown),
        "- Sets of tools, from the innermost (`@`: with a stent): %s" % ", ".join(tools),
        "",
        "Each frame has a mask of each tool, of contrast medium in vessels, of stents and of the medium in a balloon; "
        "the ordered centreline of each tool in the patient and in the picture; tips and marker bands with their "
        "visibility; the 3 × 4 projection; ticks and phases of heart, breath and contrast medium; view, dose and "
        "technique.",
        "",
        "| bit of the mask | kind |",
        "|---|---|",
        "| 1, 2, 4 | tools, from the innermost |",
        "| 8 | contrast medium in a vessel, from 1/32 mm of undiluted medium on |",
        "| 16, 32 | stents; the medium in a balloon |",
        "",
        "Visibility is 0 outside the picture; 1 where another object lies over the point, or where the tool's mask "
        "does not have its pixel; 2 where the point is clear. An X-ray picture shows objects behind others, so 1 does "
        "not mean that nothing is seen.",
        "",
        "Columns of `.centrelines.npy`: %s. Lengths are in mm in the patient frame (+x left, +y head, +z front); the "
        "centre of the first pixel is at (0.5, 0.5)." % ", ".join("`%s`" % name for name in COLUMNS),
    ]


def _making(options: Options, versions: dict[str, str], manifests: list[dict[str, Any]]) -> list[str]:
    variation = options.variation
    factors = ", ".join("%s %s" % (name.replace("_", " "), _range(getattr(variation, name))) for name in TOOL_FACTORS)
    again = sum(one["attempt"] > 0 for one in manifests)
    return [
        "## How it was made",
        "",
        "By `python -m cournand.factory` from the seed %d. Shard k is drawn from the seed and k alone; its frames do "
        "not depend on the number of workers or machines, nor on how often the run was interrupted. %d shards were "
        "planned again, because their physics had left its range, or because the core refused their scaled tools."
        % (options.seed, again),
        "",
        "| drawn | from |",
        "|---|---|",
        "| factors on tools, for each shard | %s |" % factors,
        "| insertion before the first frame | %s of the longest way through the vessels |" % _range(APPROACH_PART),
        "| heart, breath, for each shard | %s, %s per minute |" % (_range(HEART_PER_MIN), _range(BREATH_PER_MIN)),
        "| view, for each %d frames | primary %s, secondary %s degrees; field %s |"
        % (
            options.block_frames,
            _range(variation.primary_deg),
            _range(variation.secondary_deg),
            _range((FIELD_M[0] * 1e3, FIELD_M[1] * 1e3), " mm"),
        ),
        "| dose at the detector | %s, even in its logarithm |"
        % _range((DOSE_NGY * variation.dose[0], DOSE_NGY * variation.dose[1]), " nGy"),
        "| leading tip to isocentre, along each axis | at most %g of the field |" % options.offset_part,
        "| injections | %s at %s, with %s mg iodine per ml |"
        % (
            _range(VOLUME_ML, " ml"),
            _range(FLOW_ML_PER_S, " ml/s"),
            ", ".join("%g" % one for one in IODINE_MG_PER_ML),
        ),
        "",
        "Versions: %s. `plan.json` has all options." % ", ".join("%s %s" % pair for pair in sorted(versions.items())),
        "",
        "## Files",
        "",
        *("- %s" % FORMAT_TEXTS[name] for name in options.formats),
        "- `index.json`: every file of every shard with its size and SHA-256; `statistics.html`: counts and pictures",
    ]


LIMITS = """## Limits
- The pictures are computed. A model that learns from them has seen neither the texture of real tissue nor the faults of
  a real detector. It must be judged on real pictures before anyone relies on it.
- Anatomies are as varied as the named scenes; the frames of one shard are alike. Divide training and test data by shard
  and by scene, never by frame.
- Hands move at drawn speeds, not as a physician moves them. Pictures have no lag of the detector.
- Masks name what an object covers, whether or not the noise lets a person see it.
- Cournand is not a medical device, and nothing here is medical advice.

## Licence
The data come from programs and files of Cournand under the Apache License 2.0, and may be used under the same licence.
Scenes that do not come with Cournand have the licence of their authors."""


def text(options: Options, versions: dict[str, str], manifests: list[dict[str, Any]]) -> str:
    """Returns the data sheet as Markdown."""
    parts = ["# Data sheet: labelled angiograms by Cournand", ""]
    parts += [*_composition(options, manifests), "", *_making(options, versions, manifests), "", LIMITS]
    return "\n".join(parts) + "\n"
