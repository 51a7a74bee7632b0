#!/usr/bin/env python3
"""Compares our core with two peers on a moving wire (docs/bench.md, "Peers on a moving wire").

  run_moving.py --ours build/bench/peer_moving [--environment build/peers] [--rounds 5] [--only TEXT]
                [--output out/bench_moving.tsv]

Tries every setting of moving_gate.py, and prints for each its speed (simulated seconds per second of a processor), what
the gate looks at, and the verdict. Then our core and the fastest right setting of each peer run in turn; the ratio of
their median speeds is env.over_peer. With --only, the script tries only the settings whose text contains TEXT. The exit
code is 1 if something cannot be measured, no setting of a peer is right, our own run is wrong, or a ratio is below 15.
"""

import argparse
import json
import os
import statistics
import sys

import moving_gate as gate
import moving_task as task
import run_peers
from run_peers import CannotMeasure

PEERS = {"cathsim": "CathSim's wire", "chain": "MuJoCo chain of a real wire"}
NUMBERS = ("simulated_s", "processor_s", "penetration_mm", "length_error_pct", "warnings")
ROW = "%-9s %-82s %8s %8s %8s %8s %5s  %s"


def parse(line, source):
    """Returns the figures and the places of the tip in mm of one line of a program."""
    pairs = dict(word.partition("=")[::2] for word in line.split())
    try:
        figures = {key: float(pairs[key]) for key in NUMBERS}
        tips_mm = [[float(value) for value in tip.split(",")] for tip in pairs["tips_mm"].split(";") if tip]
    except (KeyError, ValueError) as error:
        raise CannotMeasure("%s: its line lacks a figure, or one is no number: %s" % (source, error)) from error
    if not figures["processor_s"] > 0:
        raise CannotMeasure("%s: processor_s is %g" % (source, figures["processor_s"]))
    return figures, tips_mm


def measure(command):
    lines = run_peers.run(command).splitlines()
    return parse(lines[-1] if lines else "", " ".join(command[:3]))


def ours(program, slower=1, element_m=task.BODY_LENGTH_m):
    """Runs our core; `slower` divides the speed of the hand, so that the tip passes the same places more slowly."""
    values = task.of_our_core()
    values.update(element_m=element_m, duration_s=values["duration_s"] * slower)
    values.update(
        push_m_per_s=values["push_m_per_s"] / slower,
        turn_rad_per_s=values["turn_rad_per_s"] / slower,
    )
    return measure([program] + ["%s=%.12g" % item for item in values.items()])


def our_row(program):
    """Returns the row of our core. Its step is fixed, so its reference run has a quarter of the hand's speed."""
    figures, tips_mm = ours(program)
    figures["tip_mm"] = gate.tip_difference_mm(tips_mm, ours(program, gate.DIVISOR)[1])
    return {
        "peer": "cournand",
        "text": "1 ms, elements of 2 mm",
        "counts": True,
        "figures": figures,
        "tips_mm": tips_mm,
        "faults": gate.faults(figures),
    }


class Peers:
    """Runs the peers' settings, each at most once."""

    def __init__(self, python):
        self.python, self.done = python, {}

    def run(self, peer, setting, again=False):
        key = (peer, json.dumps(setting, sort_keys=True))
        if again or key not in self.done:
            script = os.path.join(run_peers.FOLDER, "peer_moving.py")
            self.done[key] = measure([self.python, script, peer, json.dumps(setting)])
        return self.done[key]

    def row(self, peer, setting, counts):
        """Tries one setting; the reference run is left out when the setting is wrong without it."""
        figures, tips_mm = self.run(peer, setting)
        figures = dict(figures)
        faults = gate.faults_alone(figures)
        if not faults:
            there, reference_mm = self.run(peer, gate.reference(setting))
            if there["simulated_s"] < figures["simulated_s"]:
                raise CannotMeasure("%s: the reference run of %s ended too early" % (peer, setting))
            figures["tip_mm"] = gate.tip_difference_mm(tips_mm, reference_mm)
            faults = gate.faults(figures)
        return {
            "peer": peer,
            "text": gate.words_of(setting),
            "setting": setting,
            "counts": counts,
            "figures": figures,
            "tips_mm": tips_mm,
            "faults": faults,
        }


def print_row(row):
    figures = row["figures"]
    cells = [
        "%.3g" % gate.speed(figures),
        "%.3f" % figures["tip_mm"] if "tip_mm" in figures else "-",
        "%.3f" % figures["penetration_mm"],
        "%.4f" % figures["length_error_pct"],
        "%d" % figures["warnings"],
    ]
    print(ROW % (row["peer"], row["text"], *cells, gate.verdict(row)), flush=True)


def try_all(program, peers, only):
    print(ROW % ("wire", "setting", "speed", "tip mm", "depth mm", "length %", "warn", "verdict"), flush=True)
    rows = [our_row(program)]
    print_row(rows[0])
    candidates = [entry for entry in gate.CANDIDATES if only in entry[0] + " " + gate.words_of(entry[1])]
    for number, (peer, setting, counts) in enumerate(candidates, 1):
        print("%d of %d: %s, %s" % (number, len(candidates), peer, gate.words_of(setting)), file=sys.stderr, flush=True)
        rows.append(peers.row(peer, setting, counts))
        print_row(rows[-1])
    return rows


def compare(program, peers, row, rounds):
    """Runs our core and a peer's setting in turn; returns the median speeds of both."""
    own, theirs = [], []
    for _ in range(rounds):
        own.append(gate.speed(ours(program)[0]))
        theirs.append(gate.speed(peers.run(row["peer"], row["setting"], again=True)[0]))
    return statistics.median(own), statistics.median(theirs)


def lines_of(row, own, theirs, apart_mm):
    """Returns the lines of the table (name, value, unit, context) for one comparison."""
    peer, step_ms = row["peer"], row["setting"]["step_s"] * 1e3
    name = "env.over_peer" if row["counts"] else "env.over_changed_peer"
    return [
        (name, own / theirs, "1", "peer=%s task=moving" % peer),
        ("env.moving_s_per_s", theirs, "1", "peer=%s counts=%d step_ms=%g" % (peer, row["counts"], step_ms)),
        ("env.moving_s_per_s", own, "1", "by=ours beside=%s counts=%d" % (peer, row["counts"])),
        ("env.moving_apart_mm", apart_mm, "mm", "peer=%s counts=%d" % (peer, row["counts"])),
    ]


def judge_peer(program, peers, rows, row, rounds):
    """Compares one setting with our core; returns its lines of the table, and what is wrong."""
    own, theirs = compare(program, peers, row, rounds)
    apart_mm = gate.tip_difference_mm(rows[0]["tips_mm"], row["tips_mm"])
    bar = "bar %g" % gate.BAR if row["counts"] else "changed physics: no bar"
    name = PEERS[row["peer"]]
    print("%s: %.4g, ours %.4g, ratio %.1f (%s)" % (name, theirs, own, own / theirs, bar))
    print("  at %s; largest distance of its tip from ours: %.2f mm" % (row["text"], apart_mm))
    low = row["counts"] and own / theirs < gate.BAR
    findings = ["%s: ratio %.1f, below the bar of %g" % (name, own / theirs, gate.BAR)] if low else []
    return lines_of(row, own, theirs, apart_mm), findings


def judge(program, peers, rows, rounds):
    """Returns the lines of the table, and what is wrong."""
    lines, findings = [], []
    if rows[0]["faults"]:
        findings.append("our own run is wrong: " + ", ".join(rows[0]["faults"]))
    for peer, counts in ((peer, counts) for peer in PEERS for counts in (True, False)):
        row = gate.fastest_right(rows, peer, counts)
        if row is not None:
            more, wrong = judge_peer(program, peers, rows, row, rounds)
            lines, findings = lines + more, findings + wrong
        elif counts:
            findings.append("%s: no setting that was tried is right" % PEERS[peer])
    fine = gate.speed(ours(program, element_m=task.BODY_LENGTH_m / 2)[0])
    print("ours with elements of 1 mm: %.3g" % fine)
    return lines + [("env.moving_s_per_s", fine, "1", "by=ours element_mm=1")], findings


def write(lines, path):
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        for name, value, unit, context in lines:
            file.write("%s\t%.6g\t%s\t%s\n" % (name, value, unit, context))


def main():
    parser = argparse.ArgumentParser(description="Compare our core with two peers on a moving wire.")
    parser.add_argument("--ours", required=True, help="our program: build/bench/peer_moving")
    parser.add_argument("--environment", default=os.path.join("build", "peers"), help="virtual environment of MuJoCo")
    parser.add_argument("--rounds", type=int, default=5, help="runs in turn of us and each peer (default 5)")
    parser.add_argument("--only", default="", help="try only the settings whose text contains this")
    parser.add_argument("--output", default=os.path.join("out", "bench_moving.tsv"), help="table of the figures")
    options = parser.parse_args()
    if options.rounds < 1:
        parser.error("--rounds is at least 1")

    def work():
        peers = Peers(run_peers.prepare(options.environment))
        rows = try_all(options.ours, peers, options.only)
        lines, findings = judge(options.ours, peers, rows, options.rounds)
        write(lines, options.output)
        print("written to %s" % options.output)
        for finding in findings:
            print("run_moving: %s" % finding, file=sys.stderr)
        return 1 if findings else 0

    return run_peers.status_of("run_moving", work)


if __name__ == "__main__":
    sys.exit(main())
