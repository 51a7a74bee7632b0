"""The page of statistics: the counts of all frames and a sheet of sample pictures, in one HTML file that needs no
network."""

from __future__ import annotations

import base64
import html
from pathlib import Path
from typing import Any

from . import png
from .options import Options
from .sample import EDGE, sheet
from .shard import SAMPLE
from .store import shard_folder
from .tally import MAP_CELLS, added

SAMPLES_MAX, SHEET_COLUMNS = 24, 3
ROW_PX, BAR_PX, NAME_PX = 17, 190, 240
CELL_PX = 14
PLACES = "place of the tip"

STYLE = """body{font:15px/1.45 system-ui,sans-serif;color:#1a1a1a;background:#fff;max-width:80rem;margin:2rem auto;
padding:0 1rem}h1{font-size:1.6rem}h2{font-size:1.1rem;margin:1.6rem 0 .4rem}figure{margin:0 0 1rem}
section{display:inline-block;vertical-align:top;margin-right:1.5rem}svg{font:12px system-ui,sans-serif}
img{max-width:100%;height:auto}table{border-collapse:collapse}td,th{padding:.15rem .8rem .15rem 0;text-align:left}
figcaption{color:#555}"""


def _order(name: str) -> tuple[int, float, str]:
    """Returns a key for sorting: names that are numbers come first, in the order of numbers, and other names follow in
    alphabetical order."""
    try:
        return (0, float(name), name)
    except ValueError:
        return (1, 0.0, name)


def _bars(counts: dict[str, int]) -> str:
    most, rows = max(counts.values()), []
    for number, name in enumerate(sorted(counts, key=_order)):
        top, value = number * ROW_PX, counts[name]
        rows.append(
            '<text x="%d" y="%d" text-anchor="end">%s</text>'
            '<rect x="%d" y="%d" width="%.1f" height="%d" fill="#3b6fb6"/>'
            '<text x="%.1f" y="%d" fill="#555">%d</text>'
            % (
                NAME_PX - 6,
                top + 13,
                html.escape(name if len(name) <= 36 else name[:35] + "…"),
                NAME_PX,
                top + 3,
                BAR_PX * value / most,
                ROW_PX - 5,
                NAME_PX + BAR_PX * value / most + 5,
                top + 13,
                value,
            )
        )
    width, height = NAME_PX + BAR_PX + 70, len(counts) * ROW_PX + 4
    return '<svg width="%d" height="%d" role="img">%s</svg>' % (width, height, "".join(rows))


def _map(counts: dict[str, int]) -> str:
    most, cells = max(counts.values()), []
    for name, value in sorted(counts.items()):
        column, row = (int(one) for one in name.split(","))
        cells.append(
            '<rect x="%d" y="%d" width="%d" height="%d" fill="#3b6fb6" fill-opacity="%.3f"><title>%d</title></rect>'
            % (column * CELL_PX, row * CELL_PX, CELL_PX, CELL_PX, 0.12 + 0.88 * value / most, value)
        )
    edge = MAP_CELLS * CELL_PX
    frame = '<rect width="%d" height="%d" fill="none" stroke="#999"/>' % (edge, edge)
    return '<svg width="%d" height="%d" role="img">%s%s</svg>' % (edge + 1, edge + 1, "".join(cells), frame)


def pictures_of(dataset: Path, manifests: list[dict[str, Any]]) -> bytes:
    """Returns a PNG file with one frame of each of up to 24 shards, which are evenly spread over the data set."""
    step = max(1, len(manifests) // SAMPLES_MAX)
    chosen = manifests[::step][:SAMPLES_MAX]
    pictures = [
        png.decode_colour((shard_folder(dataset, manifest["shard"]) / SAMPLE).read_bytes()) for manifest in chosen
    ]
    return png.encode(sheet(pictures, min(SHEET_COLUMNS, len(pictures))), "flat")


def page(options: Options, manifests: list[dict[str, Any]], pictures: bytes) -> str:
    """Returns the page."""
    total = added(manifest["tally"] for manifest in manifests)
    bytes_of = sum(file["bytes"] for manifest in manifests for file in manifest["files"].values())
    facts = (
        ("frames", "%d" % options.frames),
        ("shards", "%d" % len(manifests)),
        ("shards that needed a second plan", "%d" % sum(manifest["attempt"] > 0 for manifest in manifests)),
        ("picture", "%d × %d" % (options.size, options.size)),
        ("seed", "%d" % options.seed),
        ("formats", ", ".join(options.formats)),
        ("size", "%.1f MB, %.0f kB for each frame" % (bytes_of * 1e-6, bytes_of * 1e-3 / options.frames)),
    )
    table = "".join("<tr><th>%s</th><td>%s</td></tr>" % (name, html.escape(value)) for name, value in facts)
    parts = []
    for what, counts in total.items():
        drawn = _map(counts) if what == PLACES else _bars(counts)
        parts.append("<section><h2>%s</h2>%s</section>" % (html.escape(what[0].upper() + what[1:]), drawn))
    image = base64.b64encode(pictures).decode("ascii")
    return (
        '<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>Statistics of a data set</title>'
        "<style>%s</style>\n<h1>Labelled angiograms: statistics</h1>\n<table>%s</table>\n"
        "<p>The bars count frames; those about tools count each tool of each frame. The place of the tip is a map of "
        'the picture.</p>\n%s\n<h2>Pictures</h2>\n<figure><img alt="Frames with their labels" '
        'src="data:image/png;base64,%s"><figcaption>One frame of each of up to %d shards, and the same frame with its '
        "labels: tools green, orange and violet from the innermost, contrast medium blue, stent pink, balloon cyan, "
        "tips as red crosses. Each picture is reduced to about %d pixels.</figcaption></figure>\n</html>\n"
        % (STYLE, table, "\n".join(parts), image, SAMPLES_MAX, EDGE)
    )
