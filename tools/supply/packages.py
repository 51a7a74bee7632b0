"""Finds the Debian package to which a file belongs, and the package's source package, version and copyright file. The
script supply.py and its tests use this module."""

import collections
import functools
import os
import re
import subprocess

LICENCES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "licences.tsv")
Licence = collections.namedtuple("Licence", "name holder licence words")


class Unknown(Exception):
    """Raised when this machine lacks the data about a file or package; the message gives the remedy."""


def ask(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
    return done.stdout.decode("utf-8", "replace") if done.returncode == 0 else ""


def names_of(path):
    """Returns the names under which a package may list a file. The folder /lib is a link to /usr/lib, so a package may
    use either name. The name of a library is usually a link to its file."""
    real = os.path.realpath(path)
    return (path, real, re.sub("^/usr", "", real), "/usr" + path)


OWNERS = {}  # file -> package


def learn(paths):
    """Calls dpkg-query once for many files, because each call reads the whole list of packages."""
    names = sorted({name for path in paths for name in names_of(path)} - set(OWNERS))
    done = (
        subprocess.run(["dpkg-query", "-S", *names], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
        if names
        else None
    )
    for line in done.stdout.decode("utf-8", "replace").splitlines() if done else []:
        owners, _, path = line.rpartition(": ")
        if owners and not owners.startswith("diversion "):
            OWNERS[path] = owners.split(",")[0].split(":")[0]


def of_file(path):
    """Returns the Debian package from which a file was installed."""
    if not any(name in OWNERS for name in names_of(path)):
        learn([path])
    for name in names_of(path):
        if name in OWNERS:
            return OWNERS[name]
    raise Unknown(
        "%s comes from no Debian package: name its licence by hand in NOTICE, or link Debian's library" % path
    )


@functools.lru_cache(maxsize=None)
def source_of(package):
    source = ask("dpkg-query", "-W", "-f=${source:Package}\n", package).split("\n")[0]
    if not source:
        raise Unknown("the package %s is not installed" % package)
    return source


def is_installed(package):
    return "ok installed" in ask("dpkg-query", "-W", "-f=${Status}\n", package)


def version_of(package):
    """Returns version and architecture."""
    return tuple(ask("dpkg-query", "-W", "-f=${Version} ${Architecture}\n", package).split("\n")[0].split(" "))


@functools.lru_cache(maxsize=None)
def copyright_of(package):
    try:
        with open("/usr/share/doc/%s/copyright" % package, encoding="utf-8", errors="replace") as file:
            return re.sub(r"\s+", " ", file.read())
    except OSError:
        return ""


def copyright_holds(package, words):
    return words in copyright_of(package)


def licences(path=LICENCES):
    rows = {}
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            if line.startswith("#") or not line.strip():
                continue
            fields = line.rstrip("\n").split("\t")
            if len(fields) != 5 or not all(fields) or fields[0] in rows:
                raise Unknown("%s:%d: wants five different fields between tabs" % (path, number))
            rows[fields[0]] = Licence(*fields[1:])
    return rows
