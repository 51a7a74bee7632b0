"""The table of damaged and odd DICOM series, for test_odd_scans.py. A case has a group, a name, an exit code, words
that the message must have, a change of the slices of a good series, a change of the folder, and whether it goes without
a label map.
"""

import os
import random

import odd_dicom as dicom
from odd_changes import (
    as_syntax,
    copied,
    cut,
    drop,
    each,
    flipped,
    linked,
    moved_away,
    nested,
    only,
    put,
    renamed,
    spaced,
    tilted,
    turned,
    valued,
    without,
    written,
)

CASES = []  # (group, name, exit code, words, change(slices) -> slices, after(folder))


def case(group, name, code, words, change=None, after=None, alone=False):
    """`alone`: without a label map, which would not fit."""
    CASES.append((group, name, code, words, change or (lambda slices: slices), after, alone))


def missing_slices():
    group = "slices missing, twice, unordered or uneven"
    for gone in ((20,), (5, 6), (10, 30)):
        case(group, "slices %s are missing" % (gone,), 1, "missing between .*export the whole", without(*gone))
    case(
        group,
        "the last slices are missing",
        1,
        "truncated: 40 of 44 images.*copy",
        without(40, 41, 42, 43, counted=True),
    )
    case(group, "the first slice is missing", 1, "truncated: 43 of 44 images.*copy", without(0, counted=True))
    case(group, "half of the body is missing", 1, "44 mm of the body.*give the whole", without(*range(22)))
    case(
        group,
        "every second slice is missing",
        0,
        "4.00 mm apart: what is between",
        without(*range(1, 44, 2)),
        alone=True,
    )
    case(group, "one slice", 1, "at least 2; give the folder", without(*range(1, 44)))
    case(group, "no slice", 1, "no DICOM image.*give the folder", lambda slices: [])
    case(group, "one slice twice", 1, "at the same place.*keep one", copied(7, lambda one: None))
    case(
        group,
        "one slice at the place of another",
        1,
        "missing between|at the same place",
        only(9, lambda one: one.move(z_mm=2)),
    )
    case(
        group,
        "the series twice",
        1,
        "at the same place.*keep one",
        lambda slices: slices + [one.copy("again_" + one.name) for one in slices],
    )
    case(group, "names in reverse", 0, "", renamed(lambda n: "%04d.dcm" % (99 - n)))
    case(group, "names in disorder", 0, "", renamed(lambda n: "%04d.dcm" % (n * 17 % 44)))
    case(group, "numbers of images in disorder", 0, "", each(lambda n, one: one.put(dicom.NUMBER, str(n * 17 % 44))))
    case(group, "numbers of images are all 1", 0, "", put(dicom.NUMBER, "1"))
    for by_mm in (0.3, -0.9):
        case(
            group,
            "one slice is %g mm off" % by_mm,
            1,
            "uneven slices.*resample",
            only(20, lambda one, v=by_mm: one.move(z_mm=v)),
        )
    case(
        group,
        "slices farther apart in one half",
        1,
        "uneven slices.*resample",
        spaced(lambda n: 2.0 * n + max(0, n - 30) * 0.5),
    )
    case(
        group,
        "slices farther and farther apart",
        1,
        "uneven slices.*resample",
        spaced(lambda n: 2.0 * n + 0.01 * n * n),
    )
    case(group, "slices 6 mm apart", 1, "6.00 mm apart.*reconstruct", spaced(lambda n: 6.0 * n))
    case(group, "slices 12 mm apart", 1, "spacing 2 x 2 x 12 mm.*mend", spaced(lambda n: 12.0 * n))


def geometry():
    group = "grid and direction"
    for degrees in (3, 12, 25):
        case(group, "gantry tilted by %d degrees" % degrees, 1, "tilted gantry.*resample", tilted(degrees))
    case(group, "a tilt is stated, but not in the slices", 0, "gantry was tilted", put(dicom.TILT, "12.5"))
    case(group, "slices drift sideways", 1, "shifted sideways.*resample", each(lambda n, one: one.move(x_mm=0.2 * n)))
    for text in ("0\\0", "-2\\-2", "1e-5\\1e-5", "300\\300", "nan\\nan", "inf\\inf", "x\\y", "2"):
        case(group, "distance of pixels is '%s'" % text, 1, "spacing.*(mend|export)", put(dicom.SPACING, text))
    case(group, "no distance of pixels", 1, "no spacing of its pixels .0028,0030.*export", drop(dicom.SPACING))
    case(
        group,
        "another distance of pixels in one slice",
        1,
        "another size, spacing.*keep one",
        only(8, lambda one: one.put(dicom.SPACING, "2.1\\2.1")),
    )
    for text in ("a\\b\\c", "nan\\0\\0", "1e9\\0\\0", "0\\0", ""):
        case(
            group,
            "position of a slice is '%s'" % text,
            1,
            "position|at the same place|sideways|missing|uneven|place",
            only(8, lambda one, v=text: one.put(dicom.PLACE, v)),
        )
    case(group, "no positions of slices", 1, "no position of its slice .0020,0032.*export", drop(dicom.PLACE))
    case(group, "all slices at one place", 1, "at the same place.*keep one", put(dicom.PLACE, "0\\0\\0"))
    for text in ("0\\0\\0\\0\\0\\0", "2\\0\\0\\0\\2\\0", "1\\0\\0\\0.5\\0.8\\0", "nan\\0\\0\\0\\1\\0", "a\\b"):
        case(group, "directions are '%s'" % text, 1, "direction|axes|right angles", put(dicom.ROWS_COLUMNS, text))
    case(group, "no directions", 1, "no directions .0020,0037.*export", drop(dicom.ROWS_COLUMNS))
    case(
        group,
        "another direction in one slice",
        1,
        "another size, spacing or direction.*keep one",
        only(8, lambda one: one.put(dicom.ROWS_COLUMNS, "-1\\0\\0\\0\\-1\\0")),
    )
    case(group, "coronal slices", 1, "not axial.*resample", turned((1, 0, 0, 0, 0, -1)))
    case(group, "sagittal slices", 1, "not axial.*resample", turned((0, 1, 0, 0, 0, -1)))
    case(
        group,
        "slices turned by 10 degrees",
        1,
        "not axial.*resample",
        turned((0.984808, 0.173648, 0, -0.173648, 0.984808, 0)),
    )
    case(
        group,
        "prone",
        0,
        "did not lie on the back",
        lambda slices: put(dicom.POSITION_OF_PATIENT, "HFP")(turned((-1, 0, 0, 0, -1, 0))(slices)),
    )
    case(group, "on the side", 0, "did not lie on the back", put(dicom.POSITION_OF_PATIENT, "HFDR"))
    case(
        group,
        "feet first",
        0,
        "",
        lambda slices: put(dicom.POSITION_OF_PATIENT, "FFS")(turned((-1, 0, 0, 0, 1, 0))(slices)),
    )
    case(group, "rows from below", 0, "", turned((1, 0, 0, 0, -1, 0)))


def kinds():
    group = "no CT slices, or not HU"
    for name in ("MR", "PT", "XA", "SR", "'; DROP TABLE"):
        case(group, "modality %s" % name, 1, "modality.*no CT.*give", put(dicom.MODALITY, name))
    case(group, "no modality", 0, "says no modality", drop(dicom.MODALITY))
    case(
        group,
        "a secondary capture",
        1,
        "secondary capture.*give the original",
        put(dicom.SOP_CLASS, "1.2.840.10008.5.1.4.1.1.7"),
    )
    case(
        group,
        "a multi-frame secondary capture",
        1,
        "secondary capture.*give the original",
        put(dicom.SOP_CLASS, "1.2.840.10008.5.1.4.1.1.7.2"),
    )
    case(group, "a localizer", 1, "localizer.*take it out", put(dicom.IMAGE_TYPE, "ORIGINAL\\PRIMARY\\LOCALIZER"))
    case(
        group,
        "a localizer in the series",
        1,
        "more.dcm: is a localizer.*take it out",
        copied(3, lambda one: one.put(dicom.IMAGE_TYPE, "ORIGINAL\\PRIMARY\\LOCALIZER").move(z_mm=300)),
    )
    case(group, "a MIP", 0, "is a projection", put(dicom.IMAGE_TYPE, "DERIVED\\SECONDARY\\AXIAL\\MIP"))
    case(group, "several frames", 1, "several frames.*one file per slice", put(dicom.FRAMES, "44"))
    case(
        group,
        "one slice of two frames",
        1,
        "several frames.*one file per slice",
        only(5, lambda one: one.put(dicom.FRAMES, "2")),
    )
    case(group, "writing burned in", 1, "burned into its picture.*give", put(dicom.BURNED_IN, "YES"))
    case(
        group,
        "writing burned into one slice",
        1,
        "0022.dcm: .*burned into",
        only(21, lambda one: one.put(dicom.BURNED_IN, "YES")),
    )
    case(group, "no writing burned in", 0, "", put(dicom.BURNED_IN, "NO"))


def scales():
    group = "grey scale and rescale"
    for colours in ("MONOCHROME1", "RGB", "PALETTE COLOR", "YBR_FULL", "?"):
        case(group, "grey scale %s" % colours, 1, "0028,0004|ends its reader", put(dicom.COLOURS, colours))
    case(group, "three colours per pixel", 1, "several values per pixel .0028,0002.*export", put(dicom.SAMPLES, 3))
    for unit in ("OD", "MGML", "PCT"):
        case(group, "values in %s" % unit, 1, "not in HU .0028,1054.*export", put(dicom.UNIT, unit))
    case(group, "values in an unknown unit", 0, "unit is unknown", put(dicom.UNIT, "US"))
    case(
        group,
        "no rescale, values with an offset",
        1,
        "no CT in Hounsfield units.*rescale",
        each(lambda n, one: one.drop(dicom.OFFSET, dicom.SLOPE, dicom.UNIT)),
    )
    case(
        group,
        "no rescale, but HU",
        0,
        "says no rescale",
        each(lambda n, one: one.put_values([v - 1024 for v in one.values()]).drop(dicom.OFFSET, dicom.SLOPE)),
    )
    case(group, "a slope of 0", 1, "slope of rescale .0028,1053.*export", put(dicom.SLOPE, "0"))
    for tag, text in ((dicom.SLOPE, "x"), (dicom.OFFSET, "x"), (dicom.SLOPE, "nan"), (dicom.SLOPE, "1e30")):
        case(group, "rescale '%s' at %08x" % (text, tag), 1, "rescale to HU.*no number|no Hounsfield", put(tag, text))
    case(group, "an offset of 0", 1, "no CT in Hounsfield units.*export", put(dicom.OFFSET, "0"))
    case(
        group,
        "a rescale of its own in every slice",
        0,
        "",
        each(
            lambda n, one: one.put_values([v - 1024 + 900 + n for v in one.values()]).put(dicom.OFFSET, str(-900 - n))
        ),
    )
    case(group, "compressed with loss", 0, "compressed with loss", put(dicom.LOSSY, "01"))
    case(
        group,
        "unsigned values",
        0,
        "",
        each(lambda n, one: one.put_values([max(0, v) for v in one.values()], "<%dH").put(dicom.SIGNED, 0)),
    )


def owners():
    group = "mixed patients, studies and series"
    case(group, "two patients", 1, "different patients.*keep", only(30, lambda one: one.put(dicom.PATIENT_ID, "other")))
    case(
        group,
        "two patients of one name",
        1,
        "different patients.*keep",
        only(30, lambda one: one.put(dicom.BIRTH_DATE, "19500101")),
    )
    case(group, "two studies", 1, "different studies.*keep", only(30, lambda one: one.put(dicom.STUDY, "2.25.1")))
    case(
        group,
        "two frames of reference",
        1,
        "different frames.*keep",
        only(30, lambda one: one.put(dicom.FRAME, "2.25.2")),
    )
    case(
        group,
        "two series",
        1,
        "2 series in one folder.*keep",
        each(lambda n, one: n > 20 and one.put(dicom.SERIES, "2.25.3")),
    )
    case(
        group,
        "a second series of one image",
        1,
        "2 series in one folder.*keep",
        copied(3, lambda one: one.put(dicom.SERIES, "2.25.3")),
    )


def contents():
    group = "content"
    case(group, "no contrast medium", 0, "no arterial contrast medium", valued(lambda hu, i, n: min(hu, 50)))
    case(
        group,
        "metal",
        0,
        "metal, or dense contrast",
        valued(lambda hu, i, n: 3000 if 360 <= i < 366 and n < 15 else hu),
    )
    case(group, "only air", 1, "no CT in Hounsfield|is empty", valued(lambda hu, i, n: -1000 + i % 7))
    case(group, "only tissue", 1, "no CT in Hounsfield", valued(lambda hu, i, n: 40 + i % 7))
    case(group, "all voxels equal", 1, "is empty", valued(lambda hu, i, n: -1000))
    case(group, "inverted", 1, "no CT in Hounsfield", valued(lambda hu, i, n: -hu))
    case(
        group,
        "a picture with a window of 8 bits",
        1,
        "no CT in Hounsfield",
        valued(lambda hu, i, n: max(0, min(255, hu // 2 + 100))),
    )
    case(
        group,
        "noise of 2000 HU",
        1,
        "no CT in Hounsfield",
        valued(lambda hu, i, n: (i * 7919 + n * 104729) % 4001 - 600),
    )
    case(group, "an MR's values", 1, "no CT in Hounsfield", valued(lambda hu, i, n: 700 if hu > -200 else i % 13))


def syntaxes():
    group = "transfer syntaxes and pixels"
    for name, syntax in (("explicit", dicom.EXPLICIT), ("big-endian", dicom.BIG), ("RLE", dicom.RLE)):
        case(group, "%s" % name, 0, "", as_syntax(syntax))
    case(group, "deflated", 1, "transfer syntax.*dcmconv", as_syntax(dicom.DEFLATED))
    for name, syntax in (("JPEG", dicom.JPEG), ("lossless JPEG", dicom.JPEG_LOSSLESS), ("JPEG 2000", dicom.JPEG_2000)):
        case(group, "damaged %s" % name, 1, "cannot be read|damaged|truncated", as_syntax(syntax))
    case(group, "damaged RLE", 1, "cannot be read|damaged|truncated", as_syntax(dicom.RLE), cut(4, lambda n: n - 900))
    for name, syntax in (("unknown", "1.2.3.4"), ("video", "1.2.840.10008.1.2.4.100"), ("empty", "")):
        case(group, "syntax is %s" % name, 1, "transfer syntax.*export", as_syntax(syntax))
    case(group, "no pixels", 1, "cannot be read|truncated|no pixels", drop(dicom.PIXELS))
    case(
        group,
        "half of the pixels",
        1,
        "truncated: .*fewer than it declares",
        each(lambda n, one: one.put(dicom.PIXELS, one.elements[dicom.PIXELS][:700])),
    )
    case(
        group,
        "no pixels in one slice",
        1,
        "0009.dcm.*(cannot be read|truncated|no pixels)",
        only(8, lambda one: one.drop(dicom.PIXELS)),
    )
    for tag in (dicom.ROWS, dicom.COLUMNS):
        for number in (0, 1, 65535, 26):
            case(group, "%d at %08x" % (number, tag), 1, "cannot be read|truncated|voxels|fit|export", put(tag, number))
        case(group, "nothing at %08x" % tag, 1, "cannot be read|truncated|voxels|fit|export", drop(tag))
    case(
        group,
        "another size in one slice",
        1,
        "another size|cannot be read",
        only(8, lambda one: one.put(dicom.ROWS, 26)),
    )
    for number in (0, 1, 8, 12, 24, 32, 64):
        case(
            group,
            "%d bits allocated" % number,
            1,
            "cannot be read|truncated|fit|damaged|export",
            put(dicom.ALLOCATED, number),
        )
    for number in (0, 17, 65535):
        case(group, "%d bits stored" % number, (0, 1), "", put(dicom.STORED, number))


def damaged_files():
    group = "damaged files"
    for share in (0, 0.03, 0.06, 0.2, 0.35, 0.5, 0.9):
        case(
            group,
            "a slice is cut at %g of its length" % share,
            1,
            "truncated|no DICOM|cannot be read|says no",
            None,
            cut(12, lambda n, s=share: int(n * s)),
        )
    case(group, "the last byte is missing", 1, "0013.dcm: is truncated.*copy", None, cut(12, lambda n: n - 1))
    case(group, "zeros", 1, "no DICOM file", None, written("0013.dcm", bytes(2490)))
    case(group, "a text", 1, "no DICOM file", None, written("0013.dcm", b"Dear colleague,\n" * 90))
    case(
        group,
        "a JPEG picture",
        1,
        "no DICOM file",
        None,
        written("0013.dcm", b"\xff\xd8\xff\xe0\0\x10JFIF" + bytes(900)),
    )
    case(
        group,
        "noise",
        1,
        "no DICOM file|cannot be read|damaged",
        None,
        written("0013.dcm", random.Random(3).randbytes(2490)),
    )
    case(
        group,
        "noise behind a preamble",
        1,
        "no DICOM file|cannot be read|damaged|says no|0008",
        None,
        written("0013.dcm", bytes(128) + b"DICM" + random.Random(4).randbytes(2350)),
    )
    case(
        group,
        "an element of 4 GB",
        1,
        "cannot be read|damaged|truncated|says no|0028|no DICOM",
        None,
        written("0013.dcm", bytes(128) + b"DICM\x02\0\0\0UL\4\0\0\0\0\0\x08\0\x08\0\xf0\xff\xff\xffCT"),
    )
    for seed in range(16):
        case(group, "flipped bits, seed %d" % seed, (0, 1), "", None, flipped(seed))


def file_systems():
    group = "files and folders"
    case(group, "links to the slices", 0, "", None, moved_away)
    case(group, "a link to nowhere", 1, "missing between", drop(dicom.COUNT), linked("nowhere.dcm"))
    case(group, "a link to itself", 1, "missing between", drop(dicom.COUNT), linked("0005.dcm"))
    case(
        group, "a link to the memory of the process", 1, "no DICOM file|cannot be read", None, linked("/proc/self/mem")
    )
    case(group, "a link to an endless file", 1, "missing between|no DICOM", drop(dicom.COUNT), linked("/dev/zero"))
    case(group, "a pipe", 0, "", None, lambda folder: os.mkfifo(os.path.join(folder, "pipe.dcm")))
    case(group, "a folder named as a slice", 0, "", None, lambda folder: os.mkdir(os.path.join(folder, "0099.dcm")))
    case(group, "the series lies one folder deeper", 1, "no DICOM image.*give the folder", None, nested)
    case(group, "a note and a picture beside it", 0, "", None, written("README.txt", b"a note"))
    case(group, "a DICOMDIR beside it", 0, "", None, written("DICOMDIR", bytes(128) + b"no directory"))
    case(group, "hidden files of a Mac", 0, "", None, written("._0001.dcm", b"\0\5\x16\7" + bytes(200)))
    case(group, "names with blanks", 0, "", renamed(lambda n: "slice %d of 44.dcm" % n))
    case(group, "names in other letters", 0, "", renamed(lambda n: "\u5c42 \u00e9\u00df %d.dcm" % n))
    case(group, "names without ending", 0, "", renamed(lambda n: "IM%05d" % n))
    case(group, "names that end with .IMA", 0, "", renamed(lambda n: "%05d.IMA" % n))
    case(group, "names of 250 letters", 0, "", renamed(lambda n: "%04d" % n + "x" * 246))
    case(
        group,
        "a damaged slice whose name moves the cursor",
        1,
        "no DICOM file",
        renamed(lambda n: "\x1b[2J%d.dcm" % n),
        written("\x1b[31mred\n.dcm", b"no slice"),
    )
    case(
        group,
        "a slice that nobody may read",
        1,
        "0005.dcm: may not be read: allow",
        None,
        lambda folder: os.chmod(os.path.join(folder, "0005.dcm"), 0),
    )


for table in (missing_slices, geometry, kinds, scales, owners, contents, syntaxes, damaged_files, file_systems):
    table()
