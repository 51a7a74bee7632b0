"""Writes the page of `make table51`: Table 5.1 beside our values, the recovery of the true values, identifiability,
convergence and pictures.

From equal results, the program always writes a page that is equal byte for byte. The program table51.py imports this
module.
"""

import html
import math
import os

import table51_data
from table51_data import FIGURES, FITS, averages

COLOURS = {"shape": "#3465a4", "force": "#cc5500", "corde": "#783c96"}
RECOVERY_BAR = 0.10  # aims of the issue: alpha from shape alone, EI of the shaft with the force trace
FORCE_MISSED = 0.3  # relative; beyond it the force is not fitted and its EI is meaningless
DEPTH3_BAR_MM, AVERAGE_BAR_MM = 0.5, 0.6
STYLE = """<style>
body { font: 15px/1.45 sans-serif; margin: 24px auto; max-width: 1240px; padding: 0 16px; color: #1e1e28; }
h1 { font-size: 24px; } h2 { font-size: 19px; margin-top: 34px; } h3 { font-size: 16px; }
table { border-collapse: collapse; font-size: 13.5px; display: block; overflow-x: auto; }
th, td { padding: 3px 9px; text-align: right; border-bottom: 1px solid #dee0e6; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
th.group { text-align: center; border-left: 1px solid #b8bcc6; } td.first { border-left: 1px solid #b8bcc6; }
tr.average td { font-weight: bold; border-top: 2px solid #6e737d; }
.good { color: #146c2e; } .bad { color: #b3261e; } .thesis, .quiet { color: #6e737d; }
.bar { display: inline-block; height: 9px; background: #3465a4; vertical-align: middle; }
.rest { display: inline-block; height: 9px; background: #e6e8ee; vertical-align: middle; }
img { max-width: 100%; } svg text { font: 11px sans-serif; fill: #1e1e28; }
</style>"""


def number(value, digits=3):
    return "-" if value is None else "%.*g" % (digits, value)


def millimetres(value):
    return "-" if value is None else "%.2f" % value


def text(words):
    return html.escape(str(words), quote=True)


def cell(content, kind=""):
    return "<td%s>%s</td>" % (' class="%s"' % kind if kind else "", content)


def judged(words, is_good):
    return '<span class="%s">%s</span>' % ("good" if is_good else "bad", words)


def table(head_rows, body_rows):
    """`rows` is a list of the table's rows; each row is a list of cells in HTML, or a pair (class, cells)."""
    out = ["<table>"]
    out += ["<tr>%s</tr>" % "".join(cells) for cells in head_rows]
    for row in body_rows:
        kind, cells = row if isinstance(row, tuple) else ("", row)
        out.append("<tr%s>%s</tr>" % (' class="%s"' % kind if kind else "", "".join(cells)))
    return "\n".join(out + ["</table>"])


def group(words, columns):
    return '<th class="group" colspan="%d">%s</th>' % (columns, words)


# --- Table 5.1 ---
def figure_cells(key, sets, bar):
    """Formats three table cells for one kind of error: our value, CoRdE's value, and the thesis' value."""
    ours, corde, thesis = sets
    words = millimetres(ours.get(key))
    if key in ours and bar is not None:
        words = judged(words, ours[key] <= bar)
    return [cell(words, "first"), cell(millimetres(corde.get(key))), cell(millimetres(thesis.get(key)), "thesis")]


def average_name(rows):
    """If some rows lack a fit, the name of the average states how many rows the average covers."""
    counts = [(words, averages(rows, kind)[1]) for kind, words in (("shape", "ours"), ("corde", "CoRdE"))]
    partial = ["%s of %d" % (words, count) for words, count in counts if 0 < count < len(rows)]
    return "Average" + (" (%s)" % ", ".join(partial) if partial else "")


def table_5_1(rows):
    bars = {"depth3_rms_mm": DEPTH3_BAR_MM, "average_rms_mm": AVERAGE_BAR_MM}
    head = [
        ["<th></th>"] + [group(title + ", mm", 3) for _, title, _ in FIGURES],
        ["<th>instrument</th>"] + ["<th>ours</th><th>CoRdE</th><th>thesis</th>" for _ in FIGURES],
    ]
    body = []
    for row in rows:
        sets = [row["fits"].get(kind, {}).get("figures", {}) for kind in ("shape", "corde")] + [row["thesis"]]
        body.append(
            [cell(text(row["name"]))] + [c for key, _, _ in FIGURES for c in figure_cells(key, sets, bars.get(key))]
        )
    sets = [averages(rows, kind)[0] for kind in ("shape", "corde", "thesis")]
    body.append(
        (
            "average",
            [cell(average_name(rows))] + [c for key, _, _ in FIGURES for c in figure_cells(key, sets, bars.get(key))],
        )
    )
    return table(head, body)


def fitted_cell(parameters, name):
    p = parameters.get(name)
    if p is None:
        return cell("-")
    return cell(number(p["fitted"], 4), "" if p["determined"] else "quiet")


def parameter_table(rows):
    """Shows the fitted numbers, in grey if the data leave a number undetermined, and the numbers that the thesis
    prints."""
    corde_names = list(
        dict.fromkeys(
            p["name"]
            for row in rows
            for p in row["fits"].get("corde", {"result": {"parameters": []}})["result"]["parameters"]
        )
    )
    ours = (
        ("bend_shaft", "EI, N m&sup2;"),
        ("alpha", "&alpha;"),
        ("radius", "radius, mm"),
        ("density", "density, kg/m&sup3;"),
    )
    corde = [(name, text(name)) for name in corde_names] or [("", "not run")]
    head = [
        [
            "<th></th>",
            group("ours, shape alone", len(ours)),
            group("CoRdE", len(corde)),
            group("thesis, as printed", 4),
            group("thesis", 1),
        ],
        ["<th>instrument</th>"]
        + ["<th>%s</th>" % words for _, words in (*ours, *corde)]
        + ["<th>Eb (1e7)</th><th>radius (1e3)</th><th>density (1e5)</th><th>Kp (1e3)</th><th>EI, N m&sup2;</th>"],
    ]
    body = []
    for row in rows:
        cells = [cell(text(row["name"]))]
        for kind, columns in (("shape", ours), ("corde", corde)):
            parameters = {
                p["name"]: p for p in row["fits"].get(kind, {"result": {"parameters": []}})["result"]["parameters"]
            }
            cells += [fitted_cell(parameters, name) for name, _ in columns]
        cells += [cell(number(row["thesis"]["parameters"][name]), "thesis") for name in table51_data.THESIS_PARAMETERS]
        body.append(cells + [cell(number(table51_data.thesis_bend_N_m2(row["thesis"])), "thesis")])
    return table(head, body)


# --- recovery ---
def recovery_cell(fit, name, kind=""):
    found = fit.get("recovery", {}).get(name)
    if found is None:
        return cell("-", kind)
    ratio = found["fitted_over_true"]
    if not found["determined"]:
        return cell('<span class="quiet">undetermined (%.2f)</span>' % ratio, kind)
    return cell(judged("%.3f" % ratio, abs(ratio - 1.0) <= RECOVERY_BAR), kind)


def force_cell(fit):
    if not fit:
        return cell("-")
    error = fit["result"]["kept"]["force_error"]
    return cell(number(error, 2) if error <= FORCE_MISSED else judged(number(error, 2), False))


def recovery_table(rows):
    head = [
        [
            "<th></th>",
            group("truth", 2),
            group("EI of the shaft, fitted / true", 3),
            group("&alpha;, fitted / true", 3),
            group("with force", 2),
        ],
        [
            "<th>instrument</th><th>EI, N m&sup2;</th><th>&alpha;</th>",
            "<th>file</th><th>shape alone</th><th>with force</th>" * 2,
            "<th>RMS at depth 3</th><th>force, relative</th>",
        ],
    ]
    body = []
    for row in rows:
        shape, force = row["fits"].get("shape", {}), row["fits"].get("force", {})
        cells = [cell(text(row["name"]))]
        cells += [
            cell(number(row["truth"].get(name)), kind)
            for name, kind in ((table51_data.TRUE_NAMES["bend_shaft"], "first"), (table51_data.TRUE_NAMES["alpha"], ""))
        ]
        for name in ("bend_shaft", "alpha"):
            known = (force or shape).get("recovery", {}).get(name, {})
            cells += [
                cell(number(known.get("nominal_over_true")), "first"),
                recovery_cell(shape, name),
                recovery_cell(force, name),
            ]
        cells += [cell(millimetres(force.get("figures", {}).get("depth3_rms_mm")), "first"), force_cell(force)]
        body.append(cells)
    return table(head, body)


# --- identifiability ---
def share_cell(parameter):
    if parameter is None:
        return cell("-", "first")
    share = min(1.0, max(0.0, parameter["range_share"]))
    filled = max(1, round(80 * share))
    words = '<span class="bar" style="width:%dpx"></span><span class="rest" style="width:%dpx"></span> %d %%' % (
        filled,
        80 - filled,
        round(100 * share),
    )
    if not parameter["determined"]:
        words += ' <span class="bad" title="%s">open</span>' % text(parameter.get("why", ""))
    return cell(words, "first")


def identifiability_table(rows, kind):
    fits = [(row, row["fits"][kind]["result"]["parameters"]) for row in rows if kind in row["fits"]]
    if not fits:
        return "<p>Not run.</p>"
    names = list(dict.fromkeys(p["name"] for _, parameters in fits for p in parameters))
    head = [["<th>instrument</th>"] + ["<th>%s</th>" % text(name) for name in names]]
    body = [
        [cell(text(row["name"]))] + [share_cell({p["name"]: p for p in parameters}.get(name)) for name in names]
        for row, parameters in fits
    ]
    return table(head, body)


# --- convergence ---
def curve_points(curve, most, low, high, box):
    left, top, right, bottom = box
    span = math.log10(high / low)
    points = []
    for point in curve:
        share = math.log10(min(high, max(low, point["objective"])) / low) / span
        points.append(
            "%.1f,%.1f" % (left + (right - left) * point["evaluations"] / most, bottom - (bottom - top) * share)
        )
    return " ".join(points)


def convergence_chart(row):
    """Draws one curve for every search of a table row: the best objective over the number of simulated insertions, on a
    logarithmic scale."""
    searches = [
        (kind, search) for kind in FITS if kind in row["fits"] for search in row["fits"][kind]["result"]["searches"]
    ]
    if not searches:
        return ""
    most = max(point["evaluations"] for _, search in searches for point in search["curve"])
    values = [
        point["objective"] for _, search in searches for point in search["curve"] if point["objective"] < 100.0
    ] or [1.0]
    low, high = 10.0 ** math.floor(math.log10(min(values))), 10.0 ** math.ceil(math.log10(max(values) * 1.001))
    width, height, box = 390, 210, (46, 26, 380, 182)
    out = [
        '<svg width="%d" height="%d" role="img" aria-label="convergence of %s">' % (width, height, text(row["name"])),
        '<text x="46" y="16" style="font-weight:bold">%s</text>' % text(row["name"]),
    ]
    for decade in range(round(math.log10(low)), round(math.log10(high)) + 1):
        y = box[3] - (box[3] - box[1]) * (decade - math.log10(low)) / math.log10(high / low)
        out.append(
            '<line x1="%d" x2="%d" y1="%.1f" y2="%.1f" stroke="#dee0e6"/>'
            '<text x="40" y="%.1f" text-anchor="end">%g</text>' % (box[0], box[2], y, y, y + 4, 10.0**decade)
        )
    for share in (0.0, 0.5, 1.0):
        out.append(
            '<text x="%.1f" y="198" text-anchor="middle">%d</text>'
            % (box[0] + (box[2] - box[0]) * share, round(most * share))
        )
    dashes = {"cmaes": "", "genetic": ' stroke-dasharray="5 3"', "differential": ' stroke-dasharray="1 3"'}
    for kind, search in searches:
        out.append(
            '<polyline fill="none" stroke="%s" stroke-width="1.8"%s points="%s"/>'
            % (COLOURS[kind], dashes.get(search["method"], ""), curve_points(search["curve"], most, low, high, box))
        )
    return "\n".join(out + ["</svg>"])


def legend():
    return " ".join(
        '<span style="color:%s">&#9632; %s</span>' % (COLOURS[kind], text(what)) for kind, what in FITS.items()
    )


# --- pictures, and the whole page ---
def pictures(row, output):
    out = ["<h3>%s</h3>" % text(row["name"])]
    for kind in ("shape", "corde"):
        place = "%s/%s" % (row["stem"], kind)
        if kind not in row["fits"]:
            out.append('<p class="quiet">%s: %s</p>' % (text(FITS[kind]), text(row["notes"][kind])))
        elif os.path.exists(os.path.join(output, place, "shapes.png")):
            instrument = os.path.exists(os.path.join(output, place, "instrument.toml"))
            out.append(
                '<p>%s: <a href="%s/index.html">its page</a>%s<br>'
                '<a href="%s/shapes.png"><img src="%s/shapes.png" '
                'alt="%s, %s: phantom, reference red, simulated green" loading="lazy"></a></p>'
                % (
                    text(FITS[kind]),
                    place,
                    ', <a href="%s/instrument.toml">instrument</a>' % place if instrument else "",
                    place,
                    place,
                    text(row["name"]),
                    text(FITS[kind]),
                )
            )
    return "\n".join(out)


def other_builds(settings):
    old = settings["by_other_builds"]
    return (
        '<p class="bad">Made by programs that have been built anew since: %s. '
        "Remove their folders to make them again.</p>" % text(", ".join(old))
        if old
        else ""
    )


def notes(rows):
    lines = [
        "<li>%s, %s: %s</li>" % (text(row["name"]), text(FITS[kind]), text(why))
        for row in rows
        for kind, why in row["notes"].items()
        if why != "not run"
    ]
    return '<h2>What failed</h2>\n<ul class="bad">%s</ul>' % "\n".join(lines) if lines else ""


def segmentation(rows, output):
    """Quotes the text that the command `ct check` printed for the scans of each case."""
    parts = []
    for row in rows:
        said = table51_data.said(os.path.join(output, row["stem"], "check.log"))
        if said:
            parts.append("<h3>%s</h3>\n<pre>%s</pre>" % (text(row["name"]), text("\n".join(said.splitlines()[1:]))))
    return "<h2>Segmentation against the truth</h2>\n" + "\n".join(parts) if parts else ""


def searches(rows):
    """Quotes the methods and settings that the results of the fits state."""
    found = [fit["result"] for row in rows for fit in row["fits"].values()]
    kinds = sorted(
        {
            (
                search["method"],
                search.get("population", result.get("population", 0)),
                search.get("generations", result.get("generations", 0)),
            )
            for result in found
            for search in result["searches"]
        }
    )
    return (
        "; ".join(
            "%s, %d generations of %d" % (text(method), generations, population)
            for method, population, generations in kinds
        )
        or "none yet"
    )


def introduction(rows, settings):
    where = (
        "virtual CT scans of it, 0.53 &times; 0.53 &times; 1 mm, segmented by <code>ct</code>"
        if settings["scans"]
        else "its centrelines with %g mm of noise (no scans in this preset)" % settings["shape_noise_mm"]
    )
    fitted = ", ".join("%s (%g mm)" % (text(depth["name"]), depth["inserted_mm"]) for depth in settings["depths"])
    made = {kind: averages(rows, kind)[1] for kind in FITS}
    return (
        "<p>Written by <code>make table51</code> (preset %s). Nobody has published scans of a real instrument, so the "
        "reference is an independent model (<code>docs/reference_rod.md</code>) with stiffness that differs from the "
        "instrument file's, seen through %s. The thesis' values show the level that real scans in another phantom "
        "reached; they are not the same measurement. Method and limits: <code>docs/table51.md</code>.</p>\n"
        "<p>Depths: %s; the last is not fitted. Searches: %s. Available fits: %s.</p>\n"
        % (
            text(settings["preset"]),
            where,
            fitted,
            searches(rows),
            ", ".join("%s %d of %d" % (text(FITS[kind]), count, len(rows)) for kind, count in made.items()),
        )
    )


def page(rows, settings, output):
    """Returns the whole page of results; the pictures on the page are files in the folders of the fits."""
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        "<title>Table 5.1</title>",
        STYLE,
        "</head><body>",
        "<h1>Table 5.1: simulated instruments against their references</h1>",
        introduction(rows, settings),
        other_builds(settings),
        notes(rows),
        "<h2>Table 5.1</h2>",
        table_5_1(rows),
        "<p>Ours and CoRdE by shape alone, as in the thesis. Averages are over the three depths. Green: RMS at depth 3 "
        "at most %g mm, average at most %g mm. Distances are those of the simulated nodes from the nearest point of "
        "the reference (equation 19).</p>" % (DEPTH3_BAR_MM, AVERAGE_BAR_MM),
        "<h2>Fitted parameters</h2>",
        parameter_table(rows),
        "<p>Grey: undetermined, the number is one of many that fit equally well. A rigid lumen shows ratios of EI "
        "only, so EI from shape alone is always undetermined.</p>",
        "<h2>Recovery of the truth</h2>",
        recovery_table(rows),
        '<p>"File": the instrument file\'s number over the true one, as a fit that changed nothing would give it. '
        "Green: within %d %% of the truth. Where the force itself is missed by more than %g (relative, red), EI shows "
        "a failure of the search or of the model; it is not a measurement.</p>"
        % (round(100 * RECOVERY_BAR), FORCE_MISSED),
        "<h2>How well each number is determined</h2>",
        "<p>The range over which a number can vary while the objective rises by less than the noise, as a share of the "
        "range between its bounds (logarithmic): a small share means well determined. "
        '"Open": the fit reports the number as undetermined.</p>',
    ]
    for kind, what in FITS.items():
        parts += [
            "<h3>%s</h3>" % text(what),
            "<p>Left out by this preset.</p>" if kind in settings["rangeless"] else identifiability_table(rows, kind),
        ]
    parts += [
        "<h2>Convergence</h2>",
        "<p>Best objective in mm by insertions. %s</p>" % legend(),
        *[convergence_chart(row) for row in rows],
        "<h2>As Figure 5.5: reference red, simulated green</h2>",
        *[pictures(row, output) for row in rows],
        segmentation(rows, output),
        '<p>Data: <a href="table51.csv">table51.csv</a>, <a href="table51.json">table51.json</a>.</p>',
        "</body></html>",
    ]
    return "\n".join(part for part in parts if part) + "\n"
