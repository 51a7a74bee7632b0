#!/usr/bin/env python3
"""Gives `ct patient` damaged and odd scans, label maps, tables and command lines. Each is refused, or accepted with a
warning, by a message that names the cause, the place and the remedy. None ends the program by a signal or takes a
minute, none leaves a file where it was refused, and no message or file has a name, number or date of the patient.
Prints TAP, one line per group.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, "..", "..", "..", "..", "check"), HERE]
import odd_dicom as dicom  # noqa: E402
import odd_files  # noqa: E402
import odd_series  # noqa: E402
import odd_volumes  # noqa: E402
import tree  # noqa: E402

CT = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"), "bin", "ct")
LIMIT_S = 60
REMEDY = re.compile(
    r"\b(give|export|keep|copy|mend|resample|reconstruct|segment|take|write|convert|cut|make|dcmconv|allow)\b", re.I
)
NOBODY = 65534  # root may read every file, so a process of root reads as nobody
# The base scan: a vessel of 7 mm radius along the body, in a block of tissue, by the virtual scanner.
SCANNER = [
    "--fluid-HU",
    "350",
    "--gel-HU",
    "40",
    "--silicone-HU",
    "40",
    "--wall-mm",
    "1",
    "--pixel-mm",
    "2",
    "--slice-mm",
    "2",
    "--blur-mm",
    "0.8",
    "--views",
    "60",
    "--box",
    "-24",
    "-44",
    "-24",
    "24",
    "44",
    "24",
]
# These are also made into scenes, whose files are searched for the patient's data.
SCENES = ("names in disorder", "prone", "metal", "no contrast medium", "links to the slices", "packed")


class Kit:
    """The good scan in all forms, and a folder for the files of one case."""

    def __init__(self, work):
        self.work, self.folder = work, ""
        mesh, series = os.path.join(work, "tube.obj"), os.path.join(work, "base")
        with open(mesh, "w", encoding="utf-8") as file:
            file.write(tube())
        subprocess.run([CT, "scan", mesh, "-o", series] + SCANNER, check=True, stdout=subprocess.DEVNULL)
        name, first, number, birth, study = odd_files.SECRETS
        self.slices = dicom.read_series(series)
        for one in self.slices:
            one.put(dicom.PATIENT_NAME, name + "^" + first).put(dicom.PATIENT_ID, number).put(dicom.BIRTH_DATE, birth)
            one.put(dicom.STUDY, "2.25." + study).put(dicom.SERIES, "2.25.%s.1" % study).put(
                0x00104000, "about " + name
            )
        self.hu = [v - 1024 for one in self.slices for v in one.values()]
        self.map = [
            52 if (i % 27 * 2 - 26) ** 2 + (i // 27 % 27 * 2 - 26) ** 2 < 49 else 0 for i in range(len(self.hu))
        ]

    def begin(self, number):
        self.folder = os.path.join(self.work, "case_%d" % number)
        os.mkdir(self.folder)
        os.chmod(self.folder, 0o755)

    def file(self, name, data):
        path = os.path.join(self.folder, name)
        with open(path, "wb") as file:
            file.write(data)
        return path

    def scan(self):
        return self.file("good.nrrd", odd_files.nrrd(self.hu))

    def names(self):
        return self.file("good.csv", b"id,structure\n51,heart\n52,aorta\n")

    def labels(self, names=None):
        return [
            "--labels",
            self.file("good_map.nrrd", odd_files.nrrd(self.map, kind="uchar")),
            "--names",
            names or self.names(),
        ]

    def slice(self):
        return self.file("0001.dcm", self.slices[0].bytes())

    def made_folder(self, name):
        os.mkdir(os.path.join(self.folder, name))
        return os.path.join(self.folder, name)

    def made_pipe(self, name):
        os.mkfifo(os.path.join(self.folder, name))
        return os.path.join(self.folder, name)

    def series(self, change, after, alone):
        folder = os.path.join(self.folder, "series")
        dicom.write_series(change([one.copy() for one in self.slices]), folder)
        if after:
            after(folder)
        return [folder] + ([] if alone else self.labels())


def tube(sides=24, radius_mm=7.0, end_mm=60.0):
    """A closed cylinder along the body, in the scene's axes, as an OBJ file."""
    import math

    lines, faces, top = [], [], sides + 1
    for y_mm in (-end_mm, end_mm):
        for i in range(sides):
            angle = 2 * math.pi * i / sides
            lines.append("v %.6f %.6f %.6f" % (radius_mm * math.sin(angle), y_mm, radius_mm * math.cos(angle)))
        lines.append("v 0 %g 0" % y_mm)
    for i in range(sides):
        j = (i + 1) % sides
        faces += [(i, j, top + i), (j, top + j, top + i), (j, i, sides), (top + i, top + j, top + sides)]
    return "\n".join(lines + ["f %d %d %d" % tuple(1 + v for v in face) for face in faces]) + "\n"


def secrets_in(data):
    return [word for word in odd_files.SECRETS if word.encode() in data]


def outputs(folder):
    return [os.path.join(at, name) for at, _, names in os.walk(folder) for name in names]


def run(arguments, is_unreadable):
    user = {"user": NOBODY} if is_unreadable and os.geteuid() == 0 else {}
    begin = time.monotonic()
    try:
        done = subprocess.run(
            [CT, "patient"] + arguments,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            stdin=subprocess.DEVNULL,
            timeout=LIMIT_S,
            check=False,
            **user,
        )
    except subprocess.TimeoutExpired:
        return None, b"", time.monotonic() - begin
    return done.returncode, done.stdout + done.stderr, time.monotonic() - begin


def findings_of(kit, case, number):
    """Runs one case. An accepted scan is only checked, unless its name is in SCENES."""
    group, name, codes, words, make = case
    kit.begin(number)
    output = os.path.join(kit.folder, "out")
    arguments = make(kit)
    is_scene = codes == 0 and name in SCENES
    is_quick = not is_scene and (codes in (0, (0, 1)) or "nobody may read" in name)
    arguments += ["--check"] if is_quick else ["-o", output]
    code, said, seconds = run(arguments, "nobody may read" in name)
    text = said.decode("utf-8", "replace")
    wrong = []
    if code is None:
        wrong.append("ran for %d s" % LIMIT_S)
    elif code not in (codes if isinstance(codes, tuple) else (codes,)):
        wrong.append("exit code %s" % code)
    if words and not re.search(words, text, re.S):
        wrong.append("does not say '%s'" % words)
    if code == 1 and not (REMEDY.search(text) and text.startswith("ct: ")):
        wrong.append("names no remedy")
    if re.search("[^\n\x20-\x7e\u00a0-\uffff]", text):
        wrong.append("prints control characters")
    wrong += ["tells '%s'" % word for word in secrets_in(said)]
    files = outputs(output)
    if code != 0 and files:
        wrong.append("leaves %s" % files)
    if is_scene and not os.path.exists(os.path.join(output, "patient.scene")):
        wrong.append("makes no scene")
    for file in files:
        with open(file, "rb") as data:
            wrong += ["%s has '%s'" % (file, word) for word in secrets_in(data.read())]
    if os.environ.get("SAY"):
        print(
            "# %s: %s [%s, %.1f s]: %s"
            % (group, name, code, seconds, text.strip()[: int(os.environ["SAY"])].replace("\n", " | "))
        )
    shutil.rmtree(kit.folder, ignore_errors=True)
    shutil.rmtree(os.path.join(kit.folder, "series_away"), ignore_errors=True)
    return ["%s: %s\n%s" % (name, ", ".join(wrong), text[:600])] if wrong else [], code


def all_cases():
    cases = [
        (group, name, code, words, lambda kit, c=change, a=after, x=alone: kit.series(c, a, x))
        for group, name, code, words, change, after, alone in odd_series.CASES
    ]
    return cases + odd_volumes.CASES


def main():
    report = tree.Report()
    wanted = re.compile(os.environ.get("ONLY", ""))
    groups, counts = {}, {}
    work = tempfile.mkdtemp()
    os.chmod(work, 0o755)
    try:
        kit = Kit(work)
        for number, case in enumerate(all_cases()):
            if not wanted.search(case[0] + ": " + case[1]):
                continue
            findings, code = findings_of(kit, case, number)
            groups.setdefault(case[0], []).extend(findings)
            counts.setdefault(case[0], []).append(code)
    finally:
        shutil.rmtree(work)
    for group, findings in groups.items():
        codes = counts[group]
        report.check(
            "%s: %d inputs, %d accepted, %d refused" % (group, len(codes), codes.count(0), len(codes) - codes.count(0)),
            findings,
        )
    print(
        "# %d inputs, %d refused" % (sum(map(len, counts.values())), sum(len(c) - c.count(0) for c in counts.values()))
    )
    report.end()


if __name__ == "__main__":
    main()
