"""Provides the data of `make table51`: the rows of table51.txt, and the results of the fits in the folder of each row.

table51.py and table51_page.py import it.
"""

import csv
import json
import math
import os

FOLDER = os.path.dirname(os.path.abspath(__file__))
TABLE = os.path.join(FOLDER, "table51.txt")
# The figures of Table 5.1 in its order: key, heading, and the key of their mean in result.json.
FIGURES = (
    ("depth3_rms_mm", "RMS at depth 3", None),
    ("average_rms_mm", "average RMS", "rms_mm"),
    ("mean_mm", "mean distance", "mean_mm"),
    ("deviation_mm", "standard deviation", "deviation_mm"),
    ("max_mm", "maximum", "max_mm"),
)
THESIS_PARAMETERS = ("young_1e7", "radius_1e3", "density_1e5", "kp_1e3")
# The fits of a row, each in a folder, with the heading of its column.
FITS = {"shape": "our rod, shape alone", "force": "our rod, with the force trace", "corde": "CoRdE, shape alone"}
# The steps before the fits.
CASE_STEPS = ("truth", "scans", "segmentation")
# The parameter of a fit, and the key of its true value in truth/parameters.toml.
TRUE_NAMES = {"bend_shaft": "shaft_bend_stiffness_N_m2", "alpha": "tip_over_shaft"}


class BadTable(Exception):
    """Raised for an error in table51.txt; the message gives the file and the line of the error."""


def _row(cells):
    stem, truth, turns, thesis, name = cells
    truth, turns, thesis = ([float(number) for number in text.split()] for text in (truth, turns, thesis))
    if len(truth) != 2 or len(thesis) != len(FIGURES) + len(THESIS_PARAMETERS):
        raise ValueError("wants 2 factors of the truth and 9 figures of the thesis")
    figures = dict(zip([key for key, _, _ in FIGURES], thesis))
    figures["parameters"] = dict(zip(THESIS_PARAMETERS, thesis[len(FIGURES) :]))
    return {
        "stem": stem,
        "name": name,
        "shaft_factor": truth[0],
        "tip_factor": truth[1],
        "turns_deg": turns,
        "thesis": figures,
    }


def read_table(path=TABLE):
    """Returns the depths, each as (inserted_mm, name), and the rows of table51.txt. Raises BadTable, which names the
    file and the line.
    """
    depths, rows = [], []
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            line = line.partition("#")[0].strip()
            try:
                if line.startswith("depth "):
                    _, inserted, name = line.split(None, 2)
                    depths.append((float(inserted), name))
                elif line:
                    rows.append(_row([cell.strip() for cell in line.split("|")]))
                    if len(rows[-1]["turns_deg"]) != len(depths):
                        raise ValueError("wants one turn for each of the %d depths above it" % len(depths))
            except ValueError as error:
                raise BadTable("%s:%d: %s" % (path, number, error)) from error
    return depths, rows


def read_truth(case):
    """Reads the numbers of CASE/truth/parameters.toml, which no fit ever reads; returns {} if there is no such file."""
    truth = {}
    try:
        with open(os.path.join(case, "truth", "parameters.toml"), encoding="utf-8") as file:
            for line in file:
                name, equals, value = line.partition("#")[0].partition("=")
                if equals:
                    truth[name.strip()] = float(value)
    except FileNotFoundError:
        pass
    return truth


def read_fit(folder):
    """Reads the result.json of a fit; returns None if the fit is not finished."""
    try:
        with open(os.path.join(folder, "result.json"), encoding="utf-8") as file:
            return json.load(file)
    except FileNotFoundError:
        return None


def figures_of(result):
    """Reads the five values of a row of Table 5.1 from a result.json."""
    figures = {key: result["average"][name] for key, _, name in FIGURES if name}
    figures["depth3_rms_mm"] = result["depths"][-1]["rms_mm"]
    return {key: figures[key] for key, _, _ in FIGURES}


def recovery_of(result, truth):
    """Returns for each parameter the ratio of the fitted to the true value, and whether the fit reports that the data
    determine it."""
    found = {}
    for parameter in result["parameters"]:
        true = truth.get(TRUE_NAMES.get(parameter["name"]))
        if true:
            found[parameter["name"]] = {
                "true": true,
                "fitted": parameter["fitted"],
                "fitted_over_true": parameter["fitted"] / true,
                "nominal_over_true": parameter["nominal"] / true,
                "determined": parameter["determined"],
            }
    return found


def said(path):
    """Returns the text of a file without the last end of line, or None if there is no file."""
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as file:
        return file.read().strip()


def collect(rows, output):
    """Adds the results of the fits to each row of the table.

    The added fields are "fits" (for each kind: result.json, figures and recovery), "truth", "folder" and "notes" (for
    each kind: the reason for a missing fit).
    """
    collected = []
    for row in rows:
        folder = os.path.join(output, row["stem"])
        truth = read_truth(os.path.join(folder, "case"))
        fits, notes = {}, {}
        for kind in FITS:
            result = read_fit(os.path.join(folder, kind))
            if result is not None:
                fits[kind] = {"result": result, "figures": figures_of(result), "recovery": recovery_of(result, truth)}
                continue
            notes[kind] = said(os.path.join(folder, kind + ".failed")) or "not run"
        for name in CASE_STEPS:
            why = said(os.path.join(folder, name + ".failed"))
            if why:
                fits, notes = {}, {kind: "%s: %s" % (name, why) for kind in FITS}
        collected.append(dict(row, folder=folder, truth=truth, fits=fits, notes=notes))
    return collected


def averages(rows, kind):
    """Returns the means of the five values over the rows that have them, and the number of these rows. `kind`: a fit,
    or "thesis".
    """
    sets = [
        row["thesis"] if kind == "thesis" else row["fits"][kind]["figures"]
        for row in rows
        if kind == "thesis" or kind in row["fits"]
    ]
    if not sets:
        return {}, 0
    return {key: math.fsum(figures[key] for figures in sets) / len(sets) for key, _, _ in FIGURES}, len(sets)


def thesis_bend_N_m2(thesis):
    """Computes EI from a row of Table 5.1. According to docs/thesis.md, the table's units are E x 1e7 Pa and radius x
    1e-4 m."""
    numbers = thesis["parameters"]
    return numbers["young_1e7"] * 1e7 * math.pi / 4.0 * (numbers["radius_1e3"] * 1e-4) ** 4


def to_json(rows, settings):
    """Returns the whole table as one object, which contains all numbers of the page of results."""
    out = {"settings": settings, "rows": [], "averages": {}}
    for row in rows:
        entry = {
            "instrument": row["stem"],
            "name": row["name"],
            "truth_factors": {"bend_shaft": row["shaft_factor"], "alpha": row["tip_factor"]},
            "thesis": row["thesis"],
            "missing": row["notes"],
        }
        for kind, fit in row["fits"].items():
            keys = ("name", "unit", "fitted", "nominal", "bounds", "range", "range_share", "determined")
            entry[kind] = dict(
                fit["figures"],
                recovery=fit["recovery"],
                evaluations=fit["result"]["evaluations"],
                parameters=[{key: p[key] for key in keys} for p in fit["result"]["parameters"]],
            )
        out["rows"].append(entry)
    for kind in (*FITS, "thesis"):
        figures, count = averages(rows, kind)
        out["averages"][kind] = dict(figures, instruments=count)
    return out


def write_csv(rows, path):
    """Writes one line per instrument and one line of averages; cells of a missing fit are empty."""
    kinds = (*FITS, "thesis")
    names = {
        kind: ("young", "alpha", "radius", "density", "kp")
        if kind == "corde"
        else ("bend_shaft", "alpha", "radius", "density")
        for kind in FITS
    }
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(
            ["instrument"]
            + [kind + "_" + key for kind in kinds for key, _, _ in FIGURES]
            + [kind + "_" + name for kind in FITS for name in names[kind]]
            + ["thesis_" + name for name in THESIS_PARAMETERS]
        )
        for row in rows:
            cells = [row["name"]]
            for kind in kinds:
                figures = row["thesis"] if kind == "thesis" else row["fits"].get(kind, {}).get("figures", {})
                cells += [_cell(figures.get(key)) for key, _, _ in FIGURES]
            for kind in FITS:
                result = row["fits"].get(kind, {}).get("result", {"parameters": []})
                fitted = {p["name"]: p["fitted"] for p in result["parameters"]}
                cells += [_cell(fitted.get(name)) for name in names[kind]]
            writer.writerow(cells + [row["thesis"]["parameters"][name] for name in THESIS_PARAMETERS])
        means = [averages(rows, kind)[0] for kind in kinds]
        writer.writerow(["Average"] + [_cell(figures.get(key)) for figures in means for key, _, _ in FIGURES])


def _cell(value):
    return "" if value is None else "%.5g" % value
