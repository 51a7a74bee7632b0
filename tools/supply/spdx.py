"""Writes the external parts that supply.py finds as an SPDX 2.3 document in JSON; SPDX 2.3 is the successor of ISO/IEC
5962. From the same source tree, the script writes the same bytes whenever it runs on the same machine. The time in the
document is that of the commit, and its documentNamespace contains a hash of the document."""

import datetime
import hashlib
import json
import os
import re
import subprocess

import packages

# Licences that have no SPDX name, with their text.
EXTRACTED = {"LicenseRef-public-domain": "The authors have put this work into the public domain."}


def spdx_id(kind, name):
    return "SPDXRef-%s-%s" % (kind, re.sub(r"[^A-Za-z0-9.-]", "-", name))


def ask_git(root, *arguments):
    done = subprocess.run(["git", *arguments], cwd=root, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
    return done.stdout.decode().strip() if done.returncode == 0 else ""


def created(root):
    seconds = int(os.environ.get("SOURCE_DATE_EPOCH") or ask_git(root, "log", "-1", "--format=%ct") or 0)
    return datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


def hash_of(path, name):
    with open(path, "rb") as file:
        return hashlib.new(name, file.read()).hexdigest()


def own_package(root):
    return {
        "SPDXID": "SPDXRef-Package-cournand",
        "name": "cournand",
        "versionInfo": ask_git(root, "describe", "--always", "--dirty") or "unknown",
        "supplier": "Organization: the Cournand authors",
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": "Apache-2.0",
        "licenseDeclared": "Apache-2.0",
        "copyrightText": "Copyright 2026 the Cournand authors",
    }


def debian_package(package, row):
    version, architecture = packages.version_of(package)
    return {
        "SPDXID": spdx_id("Package", package),
        "name": package,
        "versionInfo": version,
        "supplier": "Organization: Debian",
        "originator": "Organization: " + row.holder,
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": row.licence,
        "licenseDeclared": row.licence,
        "copyrightText": "NOASSERTION",
        "comment": "Debian source package %s; its copyright file is /usr/share/doc/%s/copyright"
        % (packages.source_of(package), package),
        "externalRefs": [
            {
                "referenceCategory": "PACKAGE-MANAGER",
                "referenceType": "purl",
                "referenceLocator": "pkg:deb/debian/%s@%s?arch=%s&distro=debian-12"
                % (package, version.replace(":", "%3A").replace("+", "%2B"), architecture),
            }
        ],
    }


def program_file(path):
    return {
        "SPDXID": spdx_id("File", os.path.basename(path)),
        "fileName": "./bin/" + os.path.basename(path),
        "fileTypes": ["BINARY"],
        "checksums": [{"algorithm": name, "checksumValue": hash_of(path, name.lower())} for name in ("SHA1", "SHA256")],
        "licenseConcluded": "Apache-2.0",
        "licenseInfoInFiles": ["NOASSERTION"],
        "copyrightText": "Copyright 2026 the Cournand authors",
    }


def relation(one, kind, other):
    return {"spdxElementId": one, "relationshipType": kind, "relatedSpdxElement": other}


def relations(supply):
    own = "SPDXRef-Package-cournand"
    found = [relation("SPDXRef-DOCUMENT", "DESCRIBES", own)]
    kinds = {
        "linked": "DYNAMIC_LINK",
        "headers": "CONTAINS",
        "static": "STATIC_LINK",
        "opened": "OPTIONAL_DEPENDENCY_OF",
        "loaded": "DEPENDS_ON",
    }
    for path in supply.programs:
        found.append(relation(own, "GENERATES", spdx_id("File", os.path.basename(path))))
    for group, kind in kinds.items():
        for source in sorted(supply.groups[group]):
            for package in sorted(supply.packages[source]):
                other = spdx_id("Package", package)
                found.append(relation(other, kind, own) if kind.endswith("_OF") else relation(own, kind, other))
    return found


def document(supply, licences, root):
    named = sorted(package for found in supply.packages.values() for package in found)
    body = {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": "cournand",
        "documentNamespace": "",
        "creationInfo": {"created": created(root), "creators": ["Tool: tools/supply/supply.py"]},
        "hasExtractedLicensingInfos": [{"licenseId": name, "extractedText": text} for name, text in EXTRACTED.items()],
        "packages": [own_package(root)] + [debian_package(p, licences[packages.source_of(p)]) for p in named],
        "files": [program_file(path) for path in supply.programs],
        "relationships": relations(supply),
    }
    whole = hashlib.sha256(json.dumps(body, sort_keys=True).encode()).hexdigest()
    body["documentNamespace"] = "https://spdx.org/spdxdocs/cournand-" + whole
    return body


def write(path, body):
    """Writes the SPDX document completely or not at all."""
    os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    pending = "%s.part%d" % (path, os.getpid())
    with open(pending, "x", encoding="utf-8") as file:
        json.dump(body, file, indent=1, ensure_ascii=False)
        file.write("\n")
    os.replace(pending, path)
