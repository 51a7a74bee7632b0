#!/usr/bin/env python3
"""Builds the documentation website from docs/ and mkdocs.yml into the folder out/site.

  site.py                 install mkdocs-material into build/site/venv if it is not there, and build; broken links fail
  site.py --build BUILD   another build folder
  site.py --check         only look for pages that load something from another host

tools/docs/requirements.txt fixes the versions of the Python packages for the website. The first run downloads about 12
MB from PyPI; later runs need no network.
"""

import argparse
import os
import re
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import pinned_environment  # noqa: E402

REQUIREMENTS = "tools/docs/requirements.txt"
SITE = "out/site"
# Addresses that a browser fetches by itself; a link to click is not one of them.
LOADED = re.compile(
    r"""<(?:script|img|iframe|source)\b[^>]*?\bsrc\s*=\s*["']?((?:https?:)?//[^"'\s>]+)"""
    r"""|<link\b(?=[^>]*\brel\s*=\s*["']?(?:stylesheet|preconnect|preload|icon))"""
    r"""[^>]*?\bhref\s*=\s*["']?((?:https?:)?//[^"'\s>]+)"""
    r"""|(?:url\(|@import\s+)["']?((?:https?:)?//[^"')\s]+)""",
    re.IGNORECASE,
)


class SiteError(Exception):
    """An error with its remedy."""


def install(folder):
    """Makes a Python virtual environment with the packages of requirements.txt, unless this environment exists
    already."""
    place = os.path.relpath(folder, ROOT)
    try:
        pinned_environment.make(
            folder,
            os.path.join(ROOT, REQUIREMENTS),
            lambda: print("Installing mkdocs-material from PyPI into %s (pinned by %s)" % (place, REQUIREMENTS)),
        )
    except pinned_environment.EnvironmentFault as fault:
        raise SiteError(str(fault)) from fault
    except pinned_environment.PackagesFault as fault:
        raise SiteError(
            "%s\nPyPI could not be reached, or a version is gone. Remedy: run this once with a network. Or run"
            " `pip download -r %s -d wheels` on a machine that has one, bring the folder here, and run PIP_NO_INDEX=1"
            " PIP_FIND_LINKS=wheels tools/docs/site.py. Without the site, docs/ is readable as it is."
            % (fault, REQUIREMENTS)
        ) from fault


def build(folder):
    environment = dict(os.environ, NO_MKDOCS_2_WARNING="1", PYTHONDONTWRITEBYTECODE="1")
    words = [pinned_environment.python_of(folder), "-m", "mkdocs", "build", "--strict", "--quiet", "--clean"]
    if subprocess.run(words, cwd=ROOT, env=environment, check=False).returncode != 0:
        raise SiteError(
            "a page or a link is wrong, see above; what is right: every page of docs/ is in mkdocs.yml once"
        )


def from_other_hosts(text):
    """Returns the addresses on other servers from which a browser would fetch data to show the page."""
    return [next(filter(None, found)) for found in LOADED.findall(text)]


def check(site):
    found = []
    for folder, _, names in os.walk(site):
        for name in sorted(names):
            if name.endswith((".html", ".css")):
                path = os.path.join(folder, name)
                with open(path, encoding="utf-8") as file:
                    text = file.read()
                found += ["%s loads %s" % (os.path.relpath(path, site), address) for address in from_other_hosts(text)]
                if 'class="mermaid"' in text:  # mkdocs-material fetches the program that draws these
                    found.append(
                        "%s has a mermaid diagram, whose program comes from another host" % os.path.relpath(path, site)
                    )
    if found:
        raise SiteError("pages load from other hosts:\n" + "\n".join(found))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.environ.get("BUILD", "build"), help="build folder (default: build)")
    parser.add_argument("--check", action="store_true", help="only check out/site")
    options = parser.parse_args()
    site = os.path.join(ROOT, SITE)
    try:
        if not options.check:
            folder = os.path.join(ROOT, options.build, "site", "venv")
            install(folder)
            build(folder)
        elif not os.path.isdir(site):
            raise SiteError("no %s yet. Remedy: make docs" % SITE)
        check(site)
    except SiteError as error:
        print("site: %s" % error, file=sys.stderr)
        return 1
    print("Written: %s/index.html; with search: python3 -m http.server -d %s" % (SITE, SITE))
    return 0


if __name__ == "__main__":
    sys.exit(main())
