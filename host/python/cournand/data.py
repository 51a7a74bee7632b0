"""Finds the scenes, instruments and stents that come with the package by their names."""

from __future__ import annotations

import difflib
import os
from pathlib import Path

from .errors import BadFileError

_DATA = Path(__file__).resolve().parent / "data"


def _names(folder: str, ending: str) -> dict[str, Path]:
    return {path.stem: path for path in sorted((_DATA / folder).glob("*" + ending))}


def shipped_scenes() -> list[str]:
    """Names of the scenes that come with the package."""
    return list(_names("scenes", ".scene"))


def shipped_tools() -> list[str]:
    """Names of the instruments that come with the package."""
    return list(_names("instruments", ".toml"))


def shipped_stents() -> list[str]:
    """Names of the stents that come with the package."""
    return list(_names("stents", ".toml"))


def is_name(text: str) -> bool:
    """Returns True for the name of a shipped file, such as "j_wire", and False for a path, such as
    "mine/j_wire.toml"."""
    return os.sep not in text and not os.path.splitext(text)[1] and text != ""


def find(folder: str, ending: str, given: str | os.PathLike[str]) -> str:
    """Returns the path of the shipped file with this name, or the given path itself. "NAME:PRESET" keeps its preset."""
    text = os.fspath(given)
    if not isinstance(text, str):
        raise TypeError("a path or a name is text, not %s" % type(text).__name__)
    name, colon, preset = text.partition(":")
    if not is_name(name):
        return text
    known = _names(folder, ending)
    if name not in known:
        close = difflib.get_close_matches(name, known, n=1)
        hint = "did you mean '%s'?" % close[0] if close else "there are: " + ", ".join(known)
        raise BadFileError("no %s named '%s' comes with the package: %s" % (folder[:-1], name, hint))
    return str(known[name]) + colon + preset
