"""Determines the version of the packages, and converts docs/CHANGELOG.md to Debian's format. The script
make_packages.py uses this module."""

import email.utils
import os
import re
import subprocess
import textwrap
import time

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
WIDTH = 78


class Fault(Exception):
    """Reports that packages cannot be made; the exception's text states what is wrong, where, and the remedy."""


def read(*parts):
    with open(os.path.join(ROOT, *parts), encoding="utf-8") as file:
        return file.read()


def ask_git(*words):
    """Returns the output of a git command, or an empty text if there is no git or no repository."""
    try:
        done = subprocess.run(
            ["git", "-C", ROOT, *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False
        )
    except OSError:
        return ""
    return done.stdout.decode().strip() if done.returncode == 0 else ""


def seconds():
    """Returns the time stamp of all files in the packages: SOURCE_DATE_EPOCH, or the time of the commit."""
    given = os.environ.get("SOURCE_DATE_EPOCH") or ask_git("log", "-1", "--format=%ct")
    if not given:
        raise Fault(
            "this folder has no git history, so the packages have no date. Remedy: set SOURCE_DATE_EPOCH=SECONDS"
        )
    if not re.fullmatch("[0-9]{1,11}", given):
        raise Fault("SOURCE_DATE_EPOCH is '%s'. Remedy: set the seconds since 1970 as digits" % given)
    return int(given)


def version(release, date):
    """Returns the version of the packages. For the tagged commit of a release, the version is the number of the
    release. For all other commits, the version contains the number of the release, the date and the commit, counts as
    older than the release, and states whether files have changed."""
    if ask_git("tag", "--points-at", "HEAD", "v" + release) and not ask_git("status", "--porcelain"):
        return release
    commit = ask_git("rev-parse", "--short=8", "HEAD")
    day = time.strftime("%Y%m%d", time.gmtime(date))
    changed = ".changed" if commit and ask_git("status", "--porcelain") else ""
    return "%s~%s%s%s" % (release, day, ".g" + commit if commit else "", changed)


def entries(text, release):
    """Returns the changelog's entries for a release, as plain text without Markdown."""
    section = re.search(r"^## %s\n(.*?)(?=^## |\Z)" % re.escape(release), text, re.M | re.S)
    if not section:
        raise Fault("docs/CHANGELOG.md has no section '## %s'. Remedy: add it, or correct shared/version.h" % release)
    items = re.findall(r"^- (.*?)(?=^- |^\n|\Z)", section.group(1), re.M | re.S)
    if not items:
        raise Fault("the section '## %s' of docs/CHANGELOG.md has no items. Remedy: add what has changed" % release)
    return [plain(" ".join(item.split())) for item in items]


def plain(text):
    """Returns a text without its Markdown marks. A link to a page is replaced by the name of the page."""
    text = re.sub(r"\s*\(\[[^]]*\]\(([^)]*)\)(?:, \[[^]]*\]\([^)]*\))*\)", "", text)
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text)
    return text.replace("**", "").replace("`", "")


def debian_changelog(text, release, number, maintainer, date):
    """Returns the file debian/changelog."""
    lines = ["cournand (%s) unstable; urgency=medium" % number, ""]
    for item in entries(text, release):
        lines += textwrap.wrap(
            item, WIDTH, initial_indent="  * ", subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
        )
    return "\n".join(lines + ["", " -- %s  %s" % (maintainer, email.utils.formatdate(date)), ""])
