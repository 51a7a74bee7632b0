"""The part of DICOM's explicit little-endian encoding of data elements (PS3.5, 7.1) that the factory's files need."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Sequence

_LONG = ("OB", "OW", "SQ", "UN")  # have a length of 32 bits
_PAD = {"UI": b"\0", "OB": b"\0"}
EXPLICIT_LITTLE_ENDIAN = "1.2.840.10008.1.2.1"


def decimal(value: float) -> str:
    """Returns a number as a decimal string of at most 16 letters."""
    for digits in range(12, 0, -1):
        text = "%.*g" % (digits, value)
        if len(text) <= 16:
            return text
    raise ValueError("%r is no decimal string" % value)


def uid(*parts: str) -> str:
    """Returns a DICOM identifier (UID) that is computed from texts, so that the same texts give the same identifier
    (PS3.5, B.2)."""
    return "2.25.%d" % int.from_bytes(hashlib.sha256("\n".join(parts).encode()).digest()[:16], "big")


class Elements:
    """A list of data elements, which are written in ascending order of their tags."""

    def __init__(self) -> None:
        self._made: dict[int, bytes] = {}

    def put(self, tag: int, kind: str, value: bytes) -> None:
        """Adds an element by its tag, such as 0x00280010, and its value representation."""
        padded = value + _PAD.get(kind, b" ") * (len(value) % 2)
        head = struct.pack("<HH2s", tag >> 16, tag & 0xFFFF, kind.encode())
        size = struct.pack("<HI", 0, len(padded)) if kind in _LONG else struct.pack("<H", len(padded))
        self._made[tag] = head + size + padded

    def text(self, tag: int, kind: str, *values: str) -> None:
        self.put(tag, kind, "\\".join(values).encode())

    def decimals(self, tag: int, values: Sequence[float]) -> None:
        self.text(tag, "DS", *(decimal(value) for value in values))

    def wholes(self, tag: int, values: Sequence[int]) -> None:
        self.text(tag, "IS", *(str(int(value)) for value in values))

    def shorts(self, tag: int, values: Sequence[int], kind: str = "US") -> None:
        self.put(tag, kind, struct.pack("<%d%s" % (len(values), "h" if kind == "SS" else "H"), *values))

    def doubles(self, tag: int, values: Sequence[float]) -> None:
        self.put(tag, "FD", struct.pack("<%dd" % len(values), *values))

    def encoded(self) -> bytes:
        return b"".join(self._made[tag] for tag in sorted(self._made))


def file_of(sop_class: str, instance: str, elements: Elements) -> bytes:
    """Returns the bytes of a DICOM file (PS3.10), which consists of a preamble, the file meta information and the data
    set."""
    meta = Elements()
    meta.put(0x00020001, "OB", b"\0\1")
    meta.text(0x00020002, "UI", sop_class)
    meta.text(0x00020003, "UI", instance)
    meta.text(0x00020010, "UI", EXPLICIT_LITTLE_ENDIAN)
    meta.text(0x00020012, "UI", uid("cournand factory"))
    meta.text(0x00020013, "SH", "COURNAND")
    body = meta.encoded()
    group = Elements()
    group.put(0x00020000, "UL", struct.pack("<I", len(body)))
    return bytes(128) + b"DICM" + group.encoded() + body + elements.encoded()
