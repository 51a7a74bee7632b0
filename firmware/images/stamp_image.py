#!/usr/bin/env python3
"""Writes the CRC-32 of boot header, start-up, code and data into an image for the i.MX RT1062, where the device's
self-test expects it (firmware/port/imxrt1062/self_test.c). usage: stamp_image.py IMAGE.elf"""

import struct
import sys
import zlib

CHECKED = (".boot", ".text", ".data")
CHECK = ".image_check"


def sections(image):
    """Returns {name: (offset, size)} of a 32-bit ELF file, least significant byte first."""
    if image[:6] != b"\x7fELF\x01\x01":
        raise ValueError("no 32-bit ELF file")
    (table,) = struct.unpack_from("<I", image, 32)
    entry_bytes, count, names = struct.unpack_from("<HHH", image, 46)
    headers = [struct.unpack_from("<10I", image, table + i * entry_bytes) for i in range(count)]
    begin = headers[names][4]
    found = {}
    for header in headers:
        at = begin + header[0]
        found[image[at : image.index(b"\0", at)].decode("ascii")] = (header[4], header[5])
    return found


def crc_of(image):
    found = sections(image)
    crc = 0
    for name in CHECKED:
        offset, size = found[name]
        crc = zlib.crc32(image[offset : offset + size], crc)
    return crc


def main():
    path = sys.argv[1]
    with open(path, "rb") as file:
        image = bytearray(file.read())
    try:
        offset, size = sections(image)[CHECK]
        struct.pack_into("<I", image, offset, crc_of(image))
    except (KeyError, ValueError, struct.error) as problem:
        sys.exit("%s: cannot write the CRC: %s. Remedy: link with firmware/port/imxrt1062/image.ld" % (path, problem))
    if size != 4:
        sys.exit("%s: the section %s has %d bytes, not 4" % (path, CHECK, size))
    with open(path, "wb") as file:
        file.write(image)


if __name__ == "__main__":
    main()
