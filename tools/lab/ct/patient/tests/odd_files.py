"""Writes small volumes as NRRD, NIfTI and MetaImage files, with any field of the header changed. Only the table of
test_odd_scans.py imports this module.
"""

import array
import gzip
import struct
import zlib

SIZE, STEP_MM, FIRST_MM = (27, 27, 44), 2.0, (-26.0, -26.0, -43.0)  # those of the base series
SECRETS = ("Quibble", "Zenobia", "ZQ-314159", "19410203", "99887766554433")
TYPES = {"short": "h", "ushort": "H", "uchar": "B", "int": "i", "float": "f", "double": "d"}


def packed(values, kind="short", big=False):
    numbers = array.array(TYPES[kind], values)
    if big:
        numbers.byteswap()
    return numbers.tobytes()


def nrrd(values, kind="short", drop=(), data=None, more="", **fields):
    """`fields` replace lines of the header (_ stands for a blank), `drop` leaves some out, `data` stands for values."""
    head = {
        "type": kind,
        "dimension": "3",
        "space": "left-posterior-superior",
        "sizes": "%d %d %d" % SIZE,
        "space directions": "(2,0,0) (0,2,0) (0,0,2)",
        "space origin": "(%g,%g,%g)" % FIRST_MM,
        "endian": "little",
        "encoding": "raw",
    }
    head.update({name.replace("_", " "): text for name, text in fields.items()})
    lines = "".join("%s: %s\n" % (name, text) for name, text in head.items() if name not in drop)
    data = packed(values, kind) if data is None else data
    if head["encoding"] == "gzip":
        data = gzip.compress(data)
    return (
        "NRRD0004\n" + lines + "patient:=%s^%s\nbirth:=%s\n" % (SECRETS[0], SECRETS[1], SECRETS[3]) + more + "\n"
    ).encode() + data


def mha(values, kind="short", drop=(), data=None, **fields):
    names = {"short": "MET_SHORT", "ushort": "MET_USHORT", "uchar": "MET_UCHAR", "float": "MET_FLOAT"}
    head = {
        "ObjectType": "Image",
        "NDims": "3",
        "Comment": "%s %s" % SECRETS[:2],
        "BinaryData": "True",
        "BinaryDataByteOrderMSB": "False",
        "CompressedData": "False",
        "TransformMatrix": "1 0 0 0 1 0 0 0 1",
        "Offset": "%g %g %g" % FIRST_MM,
        "ElementSpacing": "2 2 2",
        "DimSize": "%d %d %d" % SIZE,
        "ElementType": names[kind],
        "ElementDataFile": "LOCAL",
    }
    local = head.pop("ElementDataFile")
    head.update(fields)
    head.setdefault("ElementDataFile", local)
    data = packed(values, kind) if data is None else data
    if head["CompressedData"] == "True":
        data = zlib.compress(data)
        head = {"CompressedDataSize": str(len(data)), **head}
    lines = ["%s = %s\n" % (name, text) for name, text in head.items() if name not in drop]
    return "".join(lines).encode() + data


FORMATS = {
    "sizeof_hdr": (0, "i"),
    "dim": (40, "8h"),
    "datatype": (70, "h"),
    "bitpix": (72, "h"),
    "pixdim": (76, "8f"),
    "vox_offset": (108, "f"),
    "slope": (112, "f"),
    "inter": (116, "f"),
    "units": (123, "B"),
    "qform": (252, "h"),
    "sform": (254, "h"),
    "quatern": (256, "6f"),
    "srow": (280, "12f"),
    "magic": (344, "4s"),
}


def nifti(values, kind="short", data=None, big=False, **fields):
    codes = {"uchar": (2, 8), "short": (4, 16), "int": (8, 32), "float": (16, 32), "double": (64, 64)}
    head = {
        "sizeof_hdr": (348,),
        "dim": (3,) + SIZE + (1, 1, 1, 1),
        "datatype": (codes[kind][0],),
        "bitpix": (codes[kind][1],),
        "pixdim": (1,) + (STEP_MM,) * 3 + (0, 0, 0, 0),
        "vox_offset": (352,),
        "slope": (1,),
        "inter": (0,),
        "units": (2,),
        "qform": (0,),
        "sform": (1,),
        "quatern": (0,) * 6,
        "srow": (-2, 0, 0, 26, 0, -2, 0, 26, 0, 0, 2, FIRST_MM[2]),
        "magic": (b"n+1",),
    }
    head.update({name: value if isinstance(value, tuple) else (value,) for name, value in fields.items()})
    out = bytearray(352)
    out[148 : 148 + 24] = ("%s %s %s" % SECRETS[:3]).encode()[:24].ljust(24, b"\0")
    for name, value in head.items():
        place, form = FORMATS[name]
        struct.pack_into((">" if big else "<") + form, out, place, *value)
    return bytes(out) + (packed(values, kind, big) if data is None else data)
