#!/usr/bin/env python3
"""These tests check the following. NOTICE names all parts of the programs that come from outside this repository. The
SBOM (software bill of materials) is a complete SPDX 2.3 document that lists the parts from outside this repository. The
test compares the results with ldd's output for the built programs, with dpkg, and with the rules of the SPDX
specification that are listed here. The test also shows that the checks find errors in programs and tables that are
wrong on purpose. Prints TAP."""

import collections
import json
import os
import re
import subprocess
import sys
import tempfile

sys.path[:0] = [
    os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "check"),
    os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."),
]
import packages  # noqa: E402
import supply  # noqa: E402
import tree  # noqa: E402

BUILD = os.environ.get("BUILD", "build")
ID = re.compile(r"^SPDXRef-[A-Za-z0-9.-]+$")
# Identifiers of the SPDX licence list that are used here, and operators between them.
LICENCE_IDS = set(
    """Apache-2.0 BSD-2-Clause BSD-3-Clause BSL-1.0 GPL-2.0-only GPL-3.0-only GPL-3.0-or-later ICU LGPL-2.1-or-later
    LGPL-3.0-or-later FTL GPL-2.0-or-later MIT MPL-2.0 Zlib bzip2-1.0.6 libpng-2.0 LicenseRef-public-domain
    GCC-exception-3.1 OR AND WITH""".split()
)


def programs():
    listed = (
        subprocess.run(
            ["make", "-s", "--no-print-directory", "PACKAGES=skip", "BUILD=" + BUILD, "programs-list"],
            cwd=tree.ROOT,
            check=True,
            stdout=subprocess.PIPE,
        )
        .stdout.decode()
        .split()
    )
    return [os.path.basename(p) for p in listed]


def loaded_files(program):
    text = subprocess.run(["ldd", program], check=True, stdout=subprocess.PIPE).stdout.decode()
    return re.findall(r"=> (/\S+)", text)


def structure_faults(body):
    """Checks that a document fulfils the requirements of SPDX 2.3 (clauses 6, 7, 8 and 11)."""
    for key in (
        "spdxVersion",
        "dataLicense",
        "SPDXID",
        "name",
        "documentNamespace",
        "creationInfo",
        "packages",
        "files",
        "relationships",
    ):
        if not body.get(key):
            yield "the document has no %s" % key
    if (
        body.get("spdxVersion") != "SPDX-2.3"
        or body.get("dataLicense") != "CC0-1.0"
        or body.get("SPDXID") != "SPDXRef-DOCUMENT"
    ):
        yield "version, data licence or identifier of the document"
    if not re.match(r"^https://[^#\s]+$", body.get("documentNamespace", "")):
        yield "the name space is no URI without #"
    made = body.get("creationInfo", {})
    if not re.match(r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$", made.get("created", "")):
        yield "created is no time in UTC: %s" % made.get("created")
    if not all(re.match(r"^(Tool|Organization|Person): \S", one) for one in made.get("creators", [""])):
        yield "creators"
    yield from element_faults(body)


def element_faults(body):
    elements = body.get("packages", []) + body.get("files", [])
    known = collections.Counter(e.get("SPDXID") for e in elements)
    known["SPDXRef-DOCUMENT"] += 1
    for name, count in known.items():
        if count != 1 or not ID.match(name or ""):
            yield "identifier %s, %d times" % (name, count)
    for one in body.get("packages", []):
        for key in (
            "name",
            "versionInfo",
            "downloadLocation",
            "licenseConcluded",
            "licenseDeclared",
            "copyrightText",
            "supplier",
        ):
            if not one.get(key):
                yield "package %s has no %s" % (one.get("name"), key)
        for word in re.findall(r"[^\s()]+", one.get("licenseDeclared", "")):
            if word not in LICENCE_IDS:
                yield "package %s: %s is no identifier of the SPDX list" % (one.get("name"), word)
        for reference in one.get("externalRefs", []):
            if not re.match(r"^pkg:deb/debian/[a-z0-9.+-]+@\S+\?arch=[a-z0-9]+", reference.get("referenceLocator", "")):
                yield "package %s: %s is no package URL" % (one.get("name"), reference.get("referenceLocator"))
    for one in body.get("files", []):
        sums = {c["algorithm"]: c["checksumValue"] for c in one.get("checksums", [])}
        if not re.match(r"^[0-9a-f]{40}$", sums.get("SHA1", "")) or not re.match(
            r"^[0-9a-f]{64}$", sums.get("SHA256", "")
        ):
            yield "file %s has not the checksums SHA1 and SHA256" % one.get("fileName")
    for one in body.get("relationships", []):
        for end in ("spdxElementId", "relatedSpdxElement"):
            if one.get(end) not in known:
                yield "a relation names %s, which is not there" % one.get(end)
    described = [
        r
        for r in body.get("relationships", [])
        if r["relationshipType"] == "DESCRIBES" and r["spdxElementId"] == "SPDXRef-DOCUMENT"
    ]
    if len(described) != 1:
        yield "the document describes %d elements" % len(described)


def missing_in_document(body, names):
    held = {one["name"] for one in body["packages"]}
    for name in names:
        for path in loaded_files(os.path.join(tree.ROOT, BUILD, "bin", name)):
            if packages.of_file(path) not in held:
                yield "%s is loaded with %s, but package %s is not in the SBOM" % (path, name, packages.of_file(path))


def run(*arguments):
    done = subprocess.run(
        [os.path.join(tree.ROOT, "tools/supply/supply.py"), *arguments],
        cwd=tree.ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    return done.returncode, done.stdout.decode("utf-8", "replace")


def check_notice(report, found, licences):
    with open(os.path.join(tree.ROOT, "NOTICE"), encoding="utf-8") as file:
        text = file.read()
    report.check(
        "every library that a program is made of stands in NOTICE, and no other (make notice renews it)",
        list(supply.notice_faults(found, licences, text)),
    )
    names = [
        name
        for name in ("pagmo", "ITK", "Boost (Iostreams, Serialization)", "Open MPI")
        if "\n    %s " % name not in text
    ]
    report.check("NOTICE names pagmo, ITK, Boost.Serialization and Open MPI", ["%s is missing" % n for n in names])
    report.check(
        "the words of every licence stand in the copyright file of its Debian package",
        list(supply.check_licences(found, licences)),
    )
    report.check(
        "no line of licences.tsv is for what nothing uses",
        ["%s: remove its line" % s for s in licences if s not in found.packages],
    )
    without = text.replace("\n    pagmo ", "\n    pegmo ", 1)
    faults = list(supply.notice_faults(found, licences, without))
    report.check(
        "a library that NOTICE does not name is found",
        [] if any("missing: pagmo" in f for f in faults) else ["it is not: %s" % faults],
    )
    fewer = {source: row for source, row in licences.items() if source != "zlib"}
    faults = list(supply.check_licences(found, fewer))
    report.check(
        "a library without a line in licences.tsv is found, with the programs that use it",
        [] if any(f.startswith("zlib (zlib1g), used by ") for f in faults) else ["it is not: %s" % faults],
    )
    wrong = dict(licences, zlib=licences["zlib"]._replace(words="License: Proprietary"))
    faults = list(supply.check_licences(found, wrong))
    report.check(
        "a licence that the copyright file does not hold is found",
        [] if any("Proprietary" in f for f in faults) else ["it is not: %s" % faults],
    )


def check_sbom(report, names):
    folder = tempfile.mkdtemp()
    files = [os.path.join(folder, "one.json"), os.path.join(folder, "two.json")]
    for path in files:
        code, said = run("sbom", "--build", BUILD, "--programs", " ".join(names), "-o", path)
        if code != 0:
            report.check("the SBOM is written", [said])
            return
    with open(files[0], encoding="utf-8") as one, open(files[1], encoding="utf-8") as two:
        text = one.read()
        report.check("the SBOM has the same bytes twice", [] if text == two.read() else ["they differ"])
    body = json.loads(text)
    report.check("it has what SPDX 2.3 asks for", list(structure_faults(body)))
    report.check(
        "it names the package of every library that any program is loaded with", list(missing_in_document(body, names))
    )
    report.check(
        "it names every program", [n for n in names if "./bin/" + n not in [f["fileName"] for f in body["files"]]]
    )
    broken = json.loads(text)
    broken["relationships"][0]["relatedSpdxElement"] = "SPDXRef-nothing"
    broken["packages"][1]["licenseDeclared"] = "BSD-ish"
    report.check("faults in a document are found", [] if len(list(structure_faults(broken))) >= 2 else ["they are not"])
    for path in files:
        os.unlink(path)
    os.rmdir(folder)


def main():
    report = tree.Report()
    names = programs()
    missing = [n for n in names if not os.path.isfile(os.path.join(tree.ROOT, BUILD, "bin", n))]
    report.check("the programs are built", ["%s is missing: run make" % n for n in missing])
    if not missing:
        try:
            licences = packages.licences()
            found = supply.Supply(os.path.join(tree.ROOT, BUILD), names)
            check_notice(report, found, licences)
            check_sbom(report, names)
        except (packages.Unknown, KeyError) as error:
            report.check("everything that is linked is known", [repr(error)])
    code, said = run("notice", "--build", "no-such-build")
    report.check("without a build it says what to do", [] if code == 1 and "make" in said else [said])
    report.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
