"""Writes PNG files of grey and colour pictures quickly, and reads PNG files that this module has written."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core

_HEAD = b"\x89PNG\r\n\x1a\n"
_GREY, _COLOUR = 0, 2
_NONE, _SUB = 0, 1  # filters of a row


def _chunk(kind: bytes, body: bytes) -> bytes:
    return b"".join((struct.pack(">I", len(body)), kind, body, struct.pack(">I", zlib.crc32(body, zlib.crc32(kind)))))


def _packed(rows: bytes, strategy: int) -> bytes:
    maker = zlib.compressobj(1, zlib.DEFLATED, 15, 9, strategy)
    return maker.compress(rows) + maker.flush()


def encode(pixels: npt.NDArray[Any], compression: str = "fast") -> bytes:
    """Returns the PNG of an image, uint8 or uint16 [h, w], or uint8 [h, w, 3].

    `compression` is "stored" for no compression, "fast" for noisy pictures, or "flat" for images of few values such as
    masks. The bytes of "stored" images, and of "flat" images of type uint8 [h, w], depend on no library.
    """
    if compression == "stored":
        whole = np.ascontiguousarray(pixels)
        return _core.stored_png(whole) if pixels.ndim == 2 else _core.stored_colour_png(whole)
    if compression == "flat" and pixels.ndim == 2 and pixels.dtype == np.uint8:
        return _core.mask_png(np.ascontiguousarray(pixels))
    height, width = pixels.shape[:2]
    is_wide = pixels.dtype == np.uint16
    is_colour = pixels.ndim == 3
    step = (3 if is_colour else 1) * (2 if is_wide else 1)  # bytes of a pixel
    bytes_of = pixels.byteswap().view(np.uint8) if is_wide else pixels
    body = bytes_of.reshape(height, width * step)
    rows = np.empty((height, width * step + 1), dtype=np.uint8)
    if compression == "fast":
        rows[:, 0] = _SUB
        rows[:, 1 : 1 + step] = body[:, :step]
        np.subtract(body[:, step:], body[:, :-step], out=rows[:, 1 + step :])
    else:
        rows[:, 0] = _NONE
        rows[:, 1:] = body
    data = _packed(rows.tobytes(), zlib.Z_RLE if compression == "fast" else zlib.Z_DEFAULT_STRATEGY)
    head = struct.pack(">IIBBBBB", width, height, 16 if is_wide else 8, _COLOUR if is_colour else _GREY, 0, 0, 0)
    return b"".join((_HEAD, _chunk(b"IHDR", head), _chunk(b"IDAT", data), _chunk(b"IEND", b"")))


def decode_colour(png: bytes) -> npt.NDArray[np.uint8]:
    """Returns the image, as uint8 [h, w, 3], of a colour PNG file that encode() has made with "flat"."""
    width, height = struct.unpack(">II", png[16:24])
    (count,) = struct.unpack(">I", png[33:37])
    rows = np.frombuffer(zlib.decompress(png[41 : 41 + count]), dtype=np.uint8)
    return rows.reshape(height, width * 3 + 1)[:, 1:].reshape(height, width, 3)
