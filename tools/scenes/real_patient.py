#!/usr/bin/env python3
"""Takes the open data of a real patient and bakes the patient's scene (`make real-patient`, docs/anatomy.md).

  real_patient.py fetch PATIENT --mirror ../shared/anatomy --into build/real_data
  real_patient.py bake SCENE.toml --bake build/bin/bake --data build/real_data --shipped build/anatomy/aorta \\
      -o out/real.scene
  real_patient.py credits PATIENT

PATIENT is male or female; tools/scenes/real_data.toml lists the files of each. `fetch` first looks into the mirror and
downloads only what is missing there. Every file must have the SHA-256 of the list. A file that is complete is not
taken again, and an interrupted download goes on where it stopped. `bake` measures its time and adds it to
out/real_patient.tsv. The exit code is 1 when a file cannot be had or the scene cannot be baked, and 2 for a wrong
command line.
"""

import argparse
import hashlib
import http.client
import os
import shutil
import subprocess
import sys
import time
import tomllib
import urllib.parse
import urllib.request

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LIST = os.path.join(ROOT, "tools", "scenes", "real_data.toml")
PATIENTS = ("male", "female")
SILENCE_S = 60  # a server that sends nothing for so long is given up
TABLE = os.path.join("out", "real_patient.tsv")


class Fault(Exception):
    """Raised when a file cannot be had; the text says what, where, and what to do."""


def sources_of(patient, path=LIST):
    with open(path, "rb") as file:
        return [source for source in tomllib.load(file)["source"] if patient in source["patients"]]


def hash_of(path):
    """Returns the SHA-256 of a file, or None if it cannot be read."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            while block := file.read(1 << 20):
                digest.update(block)
    except OSError:
        return None
    return digest.hexdigest()


def address_of(source, entry):
    return source["address"] + urllib.parse.quote(entry.get("remote", entry["name"]))


def download(address, entry, part):
    """Downloads into the file `part`, after the bytes that it already holds."""
    have = os.path.getsize(part) if os.path.exists(part) else 0
    if have >= entry["bytes"]:
        have = 0
    request = urllib.request.Request(address, headers={"Range": "bytes=%d-" % have} if have else {})
    with urllib.request.urlopen(request, timeout=SILENCE_S) as answer:
        goes_on = have > 0 and getattr(answer, "status", 200) == 206
        with open(part, "ab" if goes_on else "wb") as file:
            count = have if goes_on else 0
            while block := answer.read(1 << 16):
                count += len(block)
                if count > entry["bytes"]:
                    raise Fault("%s: sends more than the %d bytes of the list" % (address, entry["bytes"]))
                file.write(block)


def take(source, entry, mirror, into):
    """Puts one file into the folder `into`. Returns where it came from, or raises Fault."""
    path = os.path.join(source["folder"], entry["name"])
    goal, copy = os.path.join(into, path), os.path.join(mirror, path)
    if hash_of(goal) == entry["sha256"]:
        return "here"
    os.makedirs(os.path.dirname(goal), exist_ok=True)
    part = goal + ".part"
    in_mirror = hash_of(copy)
    if in_mirror == entry["sha256"]:
        shutil.copyfile(copy, part + ".copy")
        os.replace(part + ".copy", goal)
        return "mirror"
    why = "is not there" if in_mirror is None else "has another SHA-256 (%s...)" % in_mirror[:12]
    address = address_of(source, entry)
    remedy = "put the file there, name another folder by DATA=FOLDER, or connect to the network and repeat the command"
    try:
        download(address, entry, part)
    except (OSError, http.client.HTTPException, ValueError) as problem:
        raise Fault("%s %s, and %s cannot be loaded: %s: %s" % (copy, why, address, problem, remedy)) from problem
    found = hash_of(part)
    if found != entry["sha256"]:
        os.remove(part)
        raise Fault(
            "%s: its SHA-256 is %s, not %s of %s: the file has changed at its source; %s"
            % (address, found, entry["sha256"], os.path.relpath(LIST, ROOT), remedy)
        )
    os.replace(part, goal)
    return "network"


def fetch(patient, mirror, into):
    """Takes every file of a patient, and returns the number of files that could not be had."""
    came = {"here": 0, "mirror": 0, "network": 0}
    faults = []
    for source in sources_of(patient):
        for entry in source["file"]:
            try:
                came[take(source, entry, mirror, into)] += 1
            except (Fault, OSError) as fault:
                faults.append(fault)
    for fault in faults:
        print("real-patient: %s" % fault, file=sys.stderr)
    print(
        "Data: %d files were in %s, %d came from %s, %d from the network, %d are missing"
        % (came["here"], into, came["mirror"], mirror, came["network"], len(faults))
    )
    return len(faults)


def credits_of(patient):
    seen = []
    for source in sources_of(patient):
        line = "%s (%s)" % (source["credit"], source["licence"])
        if line not in seen:
            seen.append(line)
    return seen


def record(scene, minutes):
    """Keeps one line per scene in the table, as tools/bars/bars.py reads it."""
    lines = {}
    if os.path.exists(TABLE):
        with open(TABLE, encoding="utf-8") as file:
            for line in file:
                fields = line.rstrip("\n").split("\t")
                if len(fields) == 4:
                    lines[fields[3]] = line
    context = "scene=%s" % os.path.splitext(os.path.basename(scene))[0]
    lines[context] = "patient.real_bake_min\t%.2f\tmin\t%s\n" % (minutes, context)
    os.makedirs(os.path.dirname(TABLE), exist_ok=True)
    with open(TABLE, "w", encoding="utf-8") as file:
        file.writelines(lines[key] for key in sorted(lines))


def bake(options):
    began = time.monotonic()
    done = subprocess.run(
        [options.bake, options.scene, "--data", options.data, "--shipped", options.shipped, "-o", options.output],
        check=False,
    )
    if done.returncode != 0:
        return 1
    minutes = (time.monotonic() - began) / 60
    print("Baked in %.1f minutes on %d processors" % (minutes, len(os.sched_getaffinity(0))))
    record(options.output, minutes)
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    parts = {name: commands.add_parser(name) for name in ("fetch", "bake", "credits")}
    for name in ("fetch", "credits"):
        parts[name].add_argument("patient", choices=PATIENTS)
    parts["fetch"].add_argument("--mirror", required=True, help="folder that may hold the files")
    parts["fetch"].add_argument("--into", required=True, help="folder to put the files in")
    parts["bake"].add_argument("scene")
    for name in ("--bake", "--data", "--shipped"):
        parts["bake"].add_argument(name, required=True)
    parts["bake"].add_argument("-o", "--output", required=True)
    options = parser.parse_args()
    if options.command == "fetch":
        return 1 if fetch(options.patient, options.mirror, options.into) else 0
    if options.command == "bake":
        return bake(options)
    print("Credits, to be shown with pictures of this patient:")
    for line in credits_of(options.patient):
        print("  " + line)
    return 0


if __name__ == "__main__":
    sys.exit(main())
