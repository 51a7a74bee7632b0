#!/usr/bin/env python3
"""Fits the nine instruments of the thesis' Table 5.1 and writes one page of results (docs/table51.md).

  table51.py -o out/table51 [--preset full|quick|fast] [--instruments NAME ...] [--page-only]

For each instrument, the reference rod makes the true shapes, with a stiffness that differs from the stiffness in the
instrument file. The true shapes are either scanned virtually and segmented, or converted directly to centrelines with
noise. The script fits our rod without and with the force trace, and fits the CoRdE baseline without the force trace.
Every finished step leaves a file NAME.done with its command; a step with an unchanged command is not repeated. A
stopped fit continues from its last generation. If a step fails for an instrument, the page names the instrument, and
the work continues with the other instruments. The page is written again after every instrument. The exit code is 0 when
every result was made, 1 when a step failed or was stopped, and 2 for a usage error.
"""

import argparse
import functools
import hashlib
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys

import table51_data
import table51_page

# A preset states the amount of work. `population` and `generations` are None for calibrate's own values, which make
# 2,500 trials. `short_cuts` are options of the insertions in addition to calibrate's own (docs/calibrate.md).
# `rangeless` lists fits that do not determine how well each number is known.
PRESETS = {
    "full": {
        "scans": True,
        "population": None,
        "generations": None,
        "instruments": None,
        "short_cuts": [],
        "rangeless": (),
        "truth": [],
    },
    "quick": {
        "scans": False,
        "population": 16,
        "generations": 20,
        "instruments": None,
        "short_cuts": [],
        "rangeless": (),
        "truth": [],
    },
    "fast": {
        "scans": False,
        "population": 8,
        "generations": 8,
        "instruments": ["amplatz_super_stiff"],
        "short_cuts": ["--speed-mm-s", "100", "--approach-mm", "3", "--element-factor", "1.5"],
        "rangeless": tuple(table51_data.FITS),
        "truth": ["--edge-tip-mm", "0.5", "--edge-shaft-mm", "2", "--feed-step-mm", "1"],
    },
}
SHAPE_NOISE_MM = 0.02  # the error of a segmented scan: docs/ct.md
# Population and generations of the CoRdE baseline, whose insertions take seven times as long; None leaves it out.
CORDE = {"full": (None, None), "quick": (12, 8), "fast": None}


class Failed(Exception):
    """Raised when a command fails; the message names the command and quotes its last lines of output."""


class Stopped(Exception):
    """The run was stopped by Ctrl-C."""


def run(command, log):
    """Runs one program and writes its standard output to the file `log`; the program's progress goes to the terminal if
    there is one."""
    quiet = not sys.stderr.isatty()
    with open(log, "a", encoding="utf-8") as out:
        out.write("$ %s\n" % shlex.join(command))
        out.flush()
        with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=out if quiet else None) as child:
            try:
                code = child.wait()
            except KeyboardInterrupt:
                child.wait()  # it received the signal too, and keeps what it has finished
                raise Stopped() from None
    if code != 0:
        with open(log, encoding="utf-8", errors="replace") as out:
            last = [line for line in out.read().splitlines() if line.strip()][-1]
        raise Failed(
            "%s ended with %d%s" % (command[0], code, ": " + last if not last.startswith("$") else ", see above")
        )


def remove(path):
    if os.path.exists(path):
        os.remove(path)


def text_of(path):
    """Returns the text of a file, or None if there is no such file."""
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as file:
        return file.read()


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


@functools.cache
def digest(program):
    """Returns a digest that identifies the build of a program; the digest is empty if the program does not exist."""
    if not os.path.exists(program):
        return ""
    with open(program, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest() + "\n"


def step(row_folder, name, command, announce, unheard=()):
    """Announces and runs `command`, unless the same command has been run before; returns True if the command ran.

    A failure leaves NAME.failed. `unheard` holds further arguments of the command that do not change the command's
    result.
    """
    log, done, failed = (os.path.join(row_folder, name + ending) for ending in (".log", ".done", ".failed"))
    wanted = shlex.join(command) + "\n"
    if text_of(done) == wanted:
        return False
    for path in (log, done, failed):
        remove(path)
    announce()
    try:
        run([*command, *unheard], log)
    except Failed as failure:
        write(failed, "%s\n" % failure)
        raise
    write(done, wanted)
    write(os.path.join(row_folder, name + ".program"), digest(command[0]))
    return True


class Chain:
    """Runs all steps for every instrument (row of the table) with one set of options."""

    def __init__(self, options, depths):
        self.options, self.depths = options, depths
        self.preset = dict(PRESETS[options.preset])
        if options.scans is not None:
            self.preset["scans"] = options.scans
        self.has_corde = (
            "--rod"
            in subprocess.run(
                [self.program("calibrate"), "--help"], stdout=subprocess.PIPE, text=True, check=False
            ).stdout
        )

    def program(self, name):
        return os.path.join(self.options.build, "bin", name)

    def case_steps(self, row, case):
        """Returns the name, announcement and command of each step that makes the true shapes, or the data that the
        program `calibrate` may read."""
        depths = [
            word
            for (inserted, name), turn in zip(self.depths, row["turns_deg"])
            for word in ("--depth", "%s:%g:%g" % (name, inserted, turn))
        ]
        truth = [
            self.program("reference_rod"),
            "--instrument",
            "shared/examples/instruments/%s.toml" % row["stem"],
            "--name",
            row["name"],
            "--scene",
            self.options.scene,
            "--surface",
            self.options.surface,
            *depths,
            "--shaft-factor",
            "%g" % row["shaft_factor"],
            "--tip-factor",
            "%g" % row["tip_factor"],
            *self.preset["truth"],
            "-o",
            case,
        ]
        if not self.preset["scans"]:
            return [
                ("truth", "truth, and its centrelines with noise", truth + ["--shape-noise-mm", "%g" % SHAPE_NOISE_MM])
            ]
        return [
            ("truth", "truth", truth),
            ("scans", "virtual scans", [self.program("ct"), "simulate", case]),
            ("segmentation", "segmentation", [self.program("ct"), "segment", case]),
        ]

    def kinds(self):
        """Returns the fits to make. An older version of the program `calibrate` cannot fit the CoRdE baseline."""
        return [
            kind for kind in self.options.fits if kind != "corde" or (self.has_corde and CORDE[self.options.preset])
        ]

    def fit_command(self, row_folder, kind):
        command = [
            self.program("calibrate"),
            os.path.join(row_folder, "case"),
            "-o",
            os.path.join(row_folder, kind),
            "--resume",
            "--method",
            *self.options.methods,
        ]
        sizes = {name: self.preset[name] for name in ("population", "generations")}
        if kind == "corde":
            sizes = dict(zip(sizes, CORDE[self.options.preset]))
            command += ["--rod", "corde"]
        else:
            command += self.preset["short_cuts"]
        for name in sizes:
            count = getattr(self.options, name) or sizes[name]
            command += ["--" + name, "%d" % count] if count else []
        if kind in self.preset["rangeless"]:
            command += ["--no-ranges"]
        if kind != "force":
            command += ["--force-weight-mm", "0"]
        return command

    def check_scans(self, row_folder):
        """Measures how far the segmentation deviates from the true shapes. If the deviation exceeds a limit, the
        remaining steps still run."""
        log = os.path.join(row_folder, "check.log")
        remove(log)
        try:
            run([self.program("ct"), "check", os.path.join(row_folder, "case")], log)
        except Failed:
            pass
        for name in os.listdir(os.path.join(row_folder, "case")) if not self.options.keep_scans else ():
            if name.startswith("scan_") and os.path.isfile(os.path.join(row_folder, "case", name)):
                os.remove(os.path.join(row_folder, "case", name))

    def make_case(self, row, row_folder, say):
        is_new = False
        for name, what, command in self.case_steps(row, os.path.join(row_folder, "case")):
            if is_new:
                remove(os.path.join(row_folder, name + ".done"))
            is_new = step(row_folder, name, command, lambda what=what: say(what)) or is_new
        if not is_new:
            return
        for kind in table51_data.FITS:  # these fits belong to another case
            remove(os.path.join(row_folder, kind + ".begun"))
        if self.preset["scans"]:
            self.check_scans(row_folder)

    def make_fit(self, row_folder, kind, say):
        """If only the number of generations of a search has changed, the search continues from its last state."""
        command = self.fit_command(row_folder, kind)
        begun = os.path.join(row_folder, kind + ".begun")
        search = shlex.join([word for before, word in zip([""] + command, command) if before != "--generations"]) + "\n"
        if text_of(begun) != search:
            remove(os.path.join(row_folder, kind + ".done"))
            shutil.rmtree(os.path.join(row_folder, kind), ignore_errors=True)
        write(begun, search)
        step(
            row_folder,
            kind,
            command,
            lambda: say("fit: " + table51_data.FITS[kind]),
            ["--threads", "%d" % self.options.threads] if self.options.threads else [],
        )

    def make_row(self, row, say):
        """Runs all possible steps for one instrument; returns True if no step failed."""
        row_folder = os.path.join(self.options.output, row["stem"])
        os.makedirs(row_folder, exist_ok=True)
        try:
            self.make_case(row, row_folder, say)
        except Failed as failure:
            say("failed: %s" % failure)
            return False
        good = True
        for kind in self.kinds():
            try:
                self.make_fit(row_folder, kind, say)
            except Failed as failure:
                say("failed: %s" % failure)
                good = False
        return good

    def by_other_builds(self, rows):
        """Lists the results that are older than the program that makes them; an entry of the list is, for example,
        "Rosen: shape"."""
        programs = {
            "truth": "reference_rod",
            "scans": "ct",
            "segmentation": "ct",
            **dict.fromkeys(table51_data.FITS, "calibrate"),
        }
        return [
            "%s: %s" % (row["name"], name)
            for row in rows
            for name, program in programs.items()
            if text_of(os.path.join(self.options.output, row["stem"], name + ".program"))
            not in (None, digest(self.program(program)))
        ]

    def settings(self, rows):
        return {
            "by_other_builds": self.by_other_builds(rows),
            "preset": self.options.preset,
            "scans": self.preset["scans"],
            "rangeless": list(self.preset["rangeless"]),
            "shape_noise_mm": None if self.preset["scans"] else SHAPE_NOISE_MM,
            "depths": [{"inserted_mm": inserted, "name": name} for inserted, name in self.depths],
        }


def write_page(chain, rows):
    output = chain.options.output
    collected = table51_data.collect(rows, output)
    with open(os.path.join(output, "table51.json"), "w", encoding="utf-8") as file:
        json.dump(table51_data.to_json(collected, chain.settings(rows)), file, indent=1)
        file.write("\n")
    table51_data.write_csv(collected, os.path.join(output, "table51.csv"))
    with open(os.path.join(output, "index.html"), "w", encoding="utf-8") as file:
        file.write(table51_page.page(collected, chain.settings(rows), output))


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", required=True, help="folder for the page, with a folder per instrument in it")
    parser.add_argument("--preset", choices=PRESETS, default="full", help="how much is done (default: full)")
    parser.add_argument("--instruments", nargs="+", metavar="NAME", help="only these files of table51.txt")
    parser.add_argument("--scene", default="out/access.scene", help="the phantom, baked (default: %(default)s)")
    parser.add_argument("--surface", default="out/access.ply", help="its mesh (default: %(default)s)")
    parser.add_argument("--table", default=table51_data.TABLE, help="rows and depths (default: %(default)s)")
    parser.add_argument("--build", default="build", help="folder of the programs (default: %(default)s)")
    parser.add_argument("--population", type=int, help="trials per generation, instead of the preset's")
    parser.add_argument("--generations", type=int, help="instead of the preset's")
    parser.add_argument(
        "--fits",
        nargs="+",
        choices=table51_data.FITS,
        default=list(table51_data.FITS),
        help="our rod by shape alone, with the force trace, and CoRdE (default: all)",
    )
    parser.add_argument("--methods", nargs="+", default=["cmaes"], help="of calibrate: cmaes, genetic, differential")
    parser.add_argument(
        "--scans",
        action=argparse.BooleanOptionalAction,
        help="virtual scans and their segmentation, or the "
        "truth's centrelines with noise, instead of what the preset does",
    )
    parser.add_argument("--keep-scans", action="store_true", help="keep the volumes (30 MB for each depth)")
    parser.add_argument("--threads", type=int, help="of calibrate (default: one per core)")
    parser.add_argument("--page-only", action="store_true", help="make nothing, write the page of what is there")
    return parser, parser.parse_args(arguments)


def chosen(parser, rows, wanted):
    known = [row["stem"] for row in rows]
    for name in wanted or ():
        if name not in known:
            parser.error("'%s' is not in the table: %s" % (name, ", ".join(known)))
    return [row for row in rows if not wanted or row["stem"] in wanted]


def main(arguments):
    parser, options = parse(arguments)
    try:
        depths, rows = table51_data.read_table(options.table)
    except (OSError, table51_data.BadTable) as problem:
        parser.error(str(problem))
    wanted = chosen(parser, rows, options.instruments or PRESETS[options.preset]["instruments"])
    os.makedirs(options.output, exist_ok=True)
    # Instruments that were made before stay on the page.
    shown = [row for row in rows if row in wanted or os.path.isdir(os.path.join(options.output, row["stem"]))]
    chain = Chain(options, depths)
    failed = []
    try:
        for index, row in enumerate([] if options.page_only else wanted, 1):

            def say(what, index=index, row=row):
                print("[%d/%d] %s: %s" % (index, len(wanted), row["name"], what), flush=True)

            if not chain.make_row(row, say):
                failed.append(row["name"])
            write_page(chain, shown)
    except Stopped:
        write_page(chain, shown)
        print("table51: stopped; what was finished is kept, the same command goes on there", file=sys.stderr)
        return 1
    write_page(chain, shown)
    print("Written: %s, table51.csv and table51.json beside it" % os.path.join(options.output, "index.html"))
    if failed:
        print("table51: failed: %s; the page says where" % ", ".join(failed), file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # the caller may ignore the signal
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(1)
