"""Reads a DICOM file of the program `ct` into its elements, and writes changed slices: in every transfer syntax that a
few lines can produce, without elements, or with wrong ones. Only test_odd_scans.py and its table import this module.
"""

import copy
import os
import struct
import zlib

IMPLICIT, EXPLICIT = "1.2.840.10008.1.2", "1.2.840.10008.1.2.1"
DEFLATED, BIG = "1.2.840.10008.1.2.1.99", "1.2.840.10008.1.2.2"
RLE, JPEG, JPEG_LOSSLESS, JPEG_2000 = ("1.2.840.10008.1.2." + kind for kind in ("5", "4.50", "4.70", "4.90"))
SYNTAX, SOP_CLASS, SOP_UID, IMAGE_TYPE, MODALITY = 0x00020010, 0x00080016, 0x00080018, 0x00080008, 0x00080060
PATIENT_NAME, PATIENT_ID, BIRTH_DATE, SEX = 0x00100010, 0x00100020, 0x00100030, 0x00100040
THICKNESS, TILT, POSITION_OF_PATIENT = 0x00180050, 0x00181120, 0x00185100
STUDY, SERIES, NUMBER, PLACE, ROWS_COLUMNS = 0x0020000D, 0x0020000E, 0x00200013, 0x00200032, 0x00200037
FRAME, COUNT = 0x00200052, 0x00201002
SAMPLES, COLOURS, FRAMES, ROWS, COLUMNS, SPACING = (
    0x00280002,
    0x00280004,
    0x00280008,
    0x00280010,
    0x00280011,
    0x00280030,
)
ALLOCATED, STORED, HIGH, SIGNED = 0x00280100, 0x00280101, 0x00280102, 0x00280103
BURNED_IN, OFFSET, SLOPE, UNIT, LOSSY = 0x00280301, 0x00281052, 0x00281053, 0x00281054, 0x00282110
PIXELS = 0x7FE00010
NUMBERS = (SAMPLES, ROWS, COLUMNS, ALLOCATED, STORED, HIGH, SIGNED)
KINDS = {
    PIXELS: b"OW",
    SOP_CLASS: b"UI",
    SOP_UID: b"UI",
    STUDY: b"UI",
    SERIES: b"UI",
    FRAME: b"UI",
    PLACE: b"DS",
    ROWS_COLUMNS: b"DS",
    SPACING: b"DS",
    OFFSET: b"DS",
    SLOPE: b"DS",
    THICKNESS: b"DS",
    TILT: b"DS",
    NUMBER: b"IS",
    COUNT: b"IS",
    FRAMES: b"IS",
    PATIENT_NAME: b"PN",
    PATIENT_ID: b"LO",
    BIRTH_DATE: b"DA",
}


class Slice:
    """The elements of one file. A text or a number stands for its bytes; `syntax` is that of the file to be written."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        self.name, self.syntax, self.elements = os.path.basename(path), IMPLICIT, {}
        at = 144 + struct.unpack_from("<I", data, 140)[0]
        while at < len(data):
            group, element, length = struct.unpack_from("<HHI", data, at)
            self.elements[group << 16 | element] = data[at + 8 : at + 8 + length]
            at += 8 + length

    def put(self, tag, value):
        if isinstance(value, int):
            value = struct.pack("<H", value)
        self.elements[tag] = value if isinstance(value, bytes) else value.encode()
        return self

    def drop(self, *tags):
        for tag in tags:
            self.elements.pop(tag, None)
        return self

    def text(self, tag):
        return self.elements[tag].decode().strip("\0 ")

    def place(self):
        return [float(v) for v in self.text(PLACE).split("\\")]

    def move(self, x_mm=0.0, y_mm=0.0, z_mm=0.0):
        return self.put(PLACE, "\\".join("%.4f" % (v + by) for v, by in zip(self.place(), (x_mm, y_mm, z_mm))))

    def values(self):
        """Returns the stored numbers, which are HU - offset."""
        stored = self.elements[PIXELS]
        return list(struct.unpack("<%dh" % (len(stored) // 2), stored))

    def put_values(self, values, style="<%dh"):
        return self.put(PIXELS, struct.pack(style % len(values), *values))

    def copy(self, name=None):
        other = copy.deepcopy(self)
        other.name = name or self.name
        return other

    def bytes(self):
        body = b"".join(self.element(tag, self.elements[tag]) for tag in sorted(self.elements))
        if self.syntax == DEFLATED:
            packer = zlib.compressobj(wbits=-15)
            body = packer.compress(body) + packer.flush()
        head = b"".join(
            struct.pack("<HH2sH", 2, element, b"UI", len(value)) + value
            for element, value in (
                (2, even(self.elements.get(SOP_CLASS, b"1.2"), b"\0")),
                (3, b"1.2\0"),
                (0x10, even(self.syntax.encode(), b"\0")),
            )
        )
        return bytes(128) + b"DICM" + struct.pack("<HH2sHI", 2, 0, b"UL", 4, len(head)) + head + body

    def element(self, tag, value):
        order = ">" if self.syntax == BIG else "<"
        kind = KINDS.get(tag, b"US" if tag in NUMBERS else b"LO")
        if self.syntax == BIG and kind in (b"US", b"OW"):
            value = b"".join(value[i + 1 : i + 2] + value[i : i + 1] for i in range(0, len(value), 2))
        value = even(value, b"\0" if kind in (b"UI", b"OW") else b" ")
        where = struct.pack(order + "HH", tag >> 16, tag & 0xFFFF)
        if self.syntax == IMPLICIT:
            return where + struct.pack("<I", len(value)) + value
        if kind == b"OW" and self.syntax in (RLE, JPEG, JPEG_LOSSLESS, JPEG_2000):
            return where + b"OB\0\0" + packed_pixels(rle(value) if self.syntax == RLE else value)
        if kind == b"OW":
            return where + b"OW\0\0" + struct.pack(order + "I", len(value)) + value
        return where + kind + struct.pack(order + "H", len(value)) + value


def even(value, filler):
    return value + filler * (len(value) % 2)


def packed_pixels(fragment):
    """One fragment behind an empty table of offsets."""
    item, end = struct.pack("<HHI", 0xFFFE, 0xE000, 0), struct.pack("<HHI", 0xFFFE, 0xE0DD, 0)
    return b"\xff\xff\xff\xff" + item + item[:4] + struct.pack("<I", len(fragment)) + fragment + end


def rle(pixels):
    """The high and the low bytes in literal runs of at most 128 bytes (DICOM PS3.5, annex G)."""
    planes = []
    for plane in (pixels[1::2], pixels[0::2]):
        runs = b"".join(
            bytes((len(part) - 1,)) + part for part in (plane[i : i + 128] for i in range(0, len(plane), 128))
        )
        planes.append(even(runs, b"\0"))
    head = struct.pack("<16I", 2, 64, 64 + len(planes[0]), *[0] * 13)
    return head + planes[0] + planes[1]


def read_series(folder):
    return [Slice(os.path.join(folder, name)) for name in sorted(os.listdir(folder))]


def write_series(slices, folder):
    os.makedirs(folder, exist_ok=True)
    for one in slices:
        with open(os.path.join(folder, one.name), "wb") as file:
            file.write(one.bytes())
