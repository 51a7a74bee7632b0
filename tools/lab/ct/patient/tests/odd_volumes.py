"""The table of damaged and odd volume files, label maps, tables of names and command lines, for test_odd_scans.py. A
case has a group, a name, an exit code, words that the message must have, and a function from the test's kit to the
command line of `ct patient` without its name.
"""

import gzip

from odd_files import FIRST_MM, SIZE, mha, nifti, nrrd

CASES = []  # (group, name, exit code, words, arguments(kit))


def case(group, name, code, words, arguments):
    CASES.append((group, name, code, words, arguments))


def scan(group, name, code, words, ending, data_of):
    """data_of(values in HU) are the bytes of a scan."""
    case(group, name, code, words, lambda kit: [kit.file("scan" + ending, data_of(kit.hu))] + kit.labels())


def with_labels(name, code, words, data_of, ending=".nrrd"):
    case(
        "label maps",
        name,
        code,
        words,
        lambda kit: [kit.scan(), "--labels", kit.file("map" + ending, data_of(kit.map)), "--names", kit.names()],
    )


def with_names(name, code, words, text):
    data = text if isinstance(text, bytes) else text.encode()
    case("tables of names", name, code, words, lambda kit: [kit.scan()] + kit.labels(kit.file("names.csv", data)))


def nrrd_files():
    group = "NRRD"
    table = (
        ("a good one", 0, "", {}),
        ("packed", 0, "", {"encoding": "gzip"}),
        ("float", 0, "", {"kind": "float"}),
        ("32 bits", 0, "", {"kind": "int"}),
        ("axes to the right and the back", 0, "", {"space": "right-anterior-superior"}),
        (
            "a third axis that runs down",
            0,
            "left-handed",
            {"space_directions": "(2,0,0) (0,2,0) (0,0,-2)", "space_origin": "(-26,-26,43)"},
        ),
        ("no sizes", 1, "no 'sizes'.*export", {"drop": ("sizes",)}),
        ("no type", 1, "no 'type'.*export", {"drop": ("type",)}),
        ("no encoding", 1, "no 'encoding'.*export", {"drop": ("encoding",)}),
        ("no directions", 1, "no 'spacings'.*export", {"drop": ("space directions",)}),
        ("sizes below 0", 1, "sizes.*whole numbers", {"sizes": "-27 27 44"}),
        ("size 0", 1, "sizes.*whole numbers", {"sizes": "0 27 44"}),
        ("sizes of 1e6", 1, "truncated.*copy", {"sizes": "1000000 1000000 1000000"}),
        ("2048 x 2048 x 2048", 1, "million voxels|truncated", {"sizes": "2048 2048 2048"}),
        ("two sizes", 1, "3 numbers", {"sizes": "27 27"}),
        ("four axes", 1, "dimension", {"dimension": "4", "sizes": "27 27 44 2"}),
        ("too many slices", 1, "truncated.*copy", {"sizes": "27 27 50"}),
        ("a type of blocks", 1, "no type of NRRD", {"kind_name": "block"}),
        ("the other order of bytes", 1, "Hounsfield|byte order", {"endian": "big"}),
        ("directions of none", 1, "'none' gives no scale|vector", {"space_directions": "none none none"}),
        ("directions of 0", 1, "spacings above 0", {"space_directions": "(0,0,0) (0,2,0) (0,0,2)"}),
        ("directions of nan", 1, "finite numbers", {"space_directions": "(nan,0,0) (0,2,0) (0,0,2)"}),
        ("skew directions", 1, "right angles.*resample", {"space_directions": "(2,0,0) (1,2,0) (0,0,2)"}),
        (
            "directions in metres",
            1,
            "spacing .*export it again in mm",
            {"space_directions": "(.002,0,0) (0,.002,0) (0,0,.002)"},
        ),
        ("an origin of 1e9", 1, "origin is no place", {"space_origin": "(1e9,0,0)"}),
        ("an unknown encoding", 1, "cannot be read|encoding", {"encoding": "zip"}),
        ("a missing data file", 1, "cannot be read: keep both", {"data_file": "values.raw"}),
        ("an endless data file", 1, "cannot be read: keep both", {"data_file": "/dev/zero"}),
        ("a key twice", 1, "given twice", {"more": "sizes: 27 27 44\n"}),
        ("a line of nonsense", 1, "no line of a NRRD header", {"more": "what is this\n"}),
    )
    for name, code, words, fields in table:
        fields = dict(fields)
        if "kind_name" in fields:
            fields["type"] = fields.pop("kind_name")
        scan(group, name, code, words, ".nrrd", lambda hu, f=fields: nrrd(hu, **f))


def damaged_nrrd_files():
    group = "NRRD"
    scan(group, "no magic", 1, "no NRRD file", ".nrrd", lambda hu: b"NRRX" + nrrd(hu)[4:])
    scan(group, "cut", 1, "truncated.*copy", ".nrrd", lambda hu: nrrd(hu)[:-5000])
    scan(group, "cut and packed", 1, "truncated or damaged.*copy", ".nrrd", lambda hu: nrrd(hu, encoding="gzip")[:-900])
    scan(group, "cut in the header", 1, "no 'dimension'|no 'sizes'|truncated", ".nrrd", lambda hu: nrrd(hu)[:60])
    scan(
        group,
        "packed, with a wrong byte",
        1,
        "truncated or damaged.*copy",
        ".nrrd",
        lambda hu: bytearray(nrrd(hu, encoding="gzip")[:-6]) + b"abcdef",
    )
    scan(group, "empty", 1, "scan.nrrd: (is empty|does not begin)", ".nrrd", lambda hu: b"")
    for value, text in ((float("nan"), "no numbers"), (float("inf"), "no numbers"), (1e9, "no Hounsfield")):
        scan(
            group,
            "a voxel of %g" % value,
            1,
            text + ".*(export|byte order)",
            ".nrrd",
            lambda hu, v=value: nrrd(hu[:-1] + [v], kind="float"),
        )


def meta_files():
    group = "MetaImage"
    table = (
        ("a good one", 0, "", {}),
        ("packed", 0, "", {"CompressedData": "True"}),
        ("two axes", 1, "NDims", {"NDims": "2"}),
        ("DimSize of 2 numbers", 1, "3 numbers", {"DimSize": "27 27"}),
        ("too many slices", 1, "truncated.*copy", {"DimSize": "27 27 60"}),
        ("a size of 0", 1, "whole numbers", {"DimSize": "27 0 44"}),
        ("no spacing", 1, "no 'ElementSpacing'", {"drop": ("ElementSpacing",)}),
        ("a spacing below 0", 1, "spacings above 0", {"ElementSpacing": "2 -2 2"}),
        ("floats that are not there", 1, "truncated.*copy", {"ElementType": "MET_FLOAT"}),
        ("an unknown type", 1, "no type that holds", {"ElementType": "MET_STRING"}),
        ("the other order of bytes", 1, "Hounsfield|byte order", {"BinaryDataByteOrderMSB": "True"}),
        ("axes of 0", 1, "axes|right angles|directions", {"TransformMatrix": "0 0 0 0 0 0 0 0 0"}),
        ("three values per voxel", 1, "one value per voxel", {"ElementNumberOfChannels": "3"}),
        ("a missing data file", 1, "cannot be read: keep both", {"ElementDataFile": "scan.raw"}),
        ("inches", 1, "mm is needed", {"DistanceUnits": "in"}),
    )
    for name, code, words, fields in table:
        scan(group, name, code, words, ".mha", lambda hu, f=dict(fields): mha(hu, **f))
    scan(group, "a NRRD file of this name", 1, "scan.mha", ".mha", lambda hu: nrrd(hu))


def nifti_files():
    group = "NIfTI"
    sheared = (2, 0.5, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0)
    table = (
        ("a good one", 0, "", {}),
        ("an offset and a slope", 0, "", {"slope": 1.0, "inter": 0.0, "kind": "float"}),
        ("big-endian", 0, "", {"big": True}),
        (
            "a header of the other order",
            1,
            "cannot|no header|axes|agree|truncated|Hounsfield|byte order",
            {"sizeof_hdr": 1543569408},
        ),
        ("a wrong magic", 1, "no NIfTI-1", {"magic": b"ni1"}),
        ("0 axes", 1, "0 axes", {"dim": (0,) + SIZE + (1,) * 4}),
        ("a size below 0", 1, "-27 voxels", {"dim": (3, -27, 27, 44, 1, 1, 1, 1)}),
        ("two volumes", 1, "2 volumes in one file", {"dim": (4,) + SIZE + (2, 1, 1, 1)}),
        ("complex numbers", 1, "hold no Hounsfield", {"datatype": 32, "bitpix": 64}),
        ("RGB", 1, "hold no Hounsfield", {"datatype": 128, "bitpix": 24}),
        ("wrong bits", 1, "hold no Hounsfield", {"bitpix": 8}),
        ("a distance of 0", 1, "a spacing of 0", {"pixdim": (1, 0, 2, 2, 0, 0, 0, 0)}),
        ("a distance of nan", 1, "a spacing of nan", {"pixdim": (1, float("nan"), 2, 2, 0, 0, 0, 0)}),
        ("values before the header ends", 1, "values at byte", {"vox_offset": 10}),
        ("too many slices", 1, "truncated.*copy", {"dim": (3, 27, 27, 60, 1, 1, 1, 1)}),
        ("metres", 1, "spacing .*in mm", {"units": 1}),
        ("a sheared grid", 1, "right angles|spacing|export", {"srow": sheared}),
        ("a slope of nan", (0, 1), "", {"slope": float("nan")}),
        ("a slope of 0", 0, "", {"slope": 0}),
    )
    for name, code, words, fields in table:
        scan(group, name, code, words, ".nii", lambda hu, f=dict(fields): nifti(hu, **f))
    case(
        group,
        "no place at all",
        0,
        "neither position nor direction",
        lambda kit: [kit.file("scan.nii", nifti(kit.hu, sform=0, qform=0))],
    )
    scan(group, "packed", 0, "", ".nii.gz", lambda hu: gzip.compress(nifti(hu)))
    scan(group, "packed, but named .nii", 1, "scan.nii", ".nii", lambda hu: gzip.compress(nifti(hu)))
    scan(group, "named .nii.gz, but not packed", 1, "scan.nii.gz: .*(truncated|damaged).*copy", ".nii.gz", nifti)
    scan(
        group, "packed and cut", 1, "truncated or damaged.*copy", ".nii.gz", lambda hu: gzip.compress(nifti(hu))[:-700]
    )
    scan(
        group,
        "packed, with a wrong checksum",
        1,
        "truncated or damaged.*copy",
        ".nii.gz",
        lambda hu: gzip.compress(nifti(hu))[:-8] + bytes(8),
    )
    scan(group, "cut", 1, "truncated.*copy", ".nii", lambda hu: nifti(hu)[:-4000])
    scan(group, "cut in the header", 1, "truncated", ".nii", lambda hu: nifti(hu)[:200])


def label_maps():
    half = (SIZE[0], SIZE[1], SIZE[2] // 2)
    plane = SIZE[0] * SIZE[1]
    with_labels("of floats", 0, "", lambda m: nrrd(m, kind="float"))
    with_labels("NIfTI", 0, "", lambda m: nifti(m, kind="uchar"), ".nii")
    with_labels(
        "with the third axis reversed",
        0,
        "",
        lambda m: nrrd(
            [v for k in reversed(range(SIZE[2])) for v in m[k * plane : (k + 1) * plane]],
            kind="uchar",
            space_directions="(2,0,0) (0,2,0) (0,0,-2)",
            space_origin="(%g,%g,%g)" % (FIRST_MM[0], FIRST_MM[1], FIRST_MM[2] + 86),
        ),
    )
    with_labels(
        "of half the slices",
        1,
        "the label map has .*segment this scan",
        lambda m: nrrd(m[: plane * half[2]], kind="uchar", sizes="%d %d %d" % half),
    )
    with_labels(
        "of another spacing",
        1,
        "the label map has .*segment this scan",
        lambda m: nrrd(m, kind="uchar", space_directions="(2,0,0) (0,2,0) (0,0,2.5)"),
    )
    with_labels(
        "moved by 6 mm",
        1,
        "corners are 6.0 mm apart.*segment",
        lambda m: nrrd(m, kind="uchar", space_origin="(%g,%g,%g)" % (FIRST_MM[0] + 6, FIRST_MM[1], FIRST_MM[2])),
    )
    with_labels("in other axes", 0, "", lambda m: nrrd(m, kind="uchar", space="left-anterior-superior"))


def damaged_label_maps():
    with_labels("empty", 1, "is empty", lambda m: nrrd([0] * len(m), kind="uchar"))
    with_labels("of one label everywhere", 1, "is empty", lambda m: nrrd([52] * len(m), kind="uchar"))
    with_labels(
        "without an aorta",
        1,
        "no structure is named 'aorta'.*segment",
        lambda m: nrrd([v // 52 * 51 for v in m], kind="uchar"),
    )
    with_labels(
        "with a label that the table lacks",
        1,
        "label 77 has no name.*give the table",
        lambda m: nrrd(m[:-1] + [77], kind="uchar"),
    )
    with_labels("of fractions", 1, "no whole number.*export", lambda m: nrrd([v * 0.37 for v in m], kind="float"))
    with_labels("with -1", 1, "label -1 has no name|whole numbers", lambda m: nrrd(m[:-1] + [-1], kind="short"))
    with_labels(
        "with 70000", 1, "no Hounsfield|label 70000|whole numbers", lambda m: nrrd(m[:-1] + [70000], kind="int")
    )
    with_labels("with nan", 1, "no numbers", lambda m: nrrd(m[:-1] + [float("nan")], kind="float"))
    with_labels(
        "an aorta of 9 voxels",
        1,
        "aorta has 9 voxels.*segment again",
        lambda m: nrrd([52] * 9 + [0] * (len(m) - 9), kind="uchar"),
    )
    with_labels(
        "an aorta in the air",
        0,
        "no arterial contrast medium",
        lambda m: nrrd([52] * 400 + [0] * (len(m) - 400), kind="uchar"),
    )
    with_labels("cut", 1, "truncated", lambda m: nrrd(m, kind="uchar")[:-900])
    case(
        "label maps",
        "a missing one",
        1,
        "is not there",
        lambda kit: [kit.scan(), "--labels", "none.nrrd", "--names", kit.names()],
    )
    case(
        "label maps",
        "the scan itself",
        1,
        "label .* has no name",
        lambda kit: [kit.scan(), "--labels", kit.scan(), "--names", kit.names()],
    )


def tables():
    with_names("lines of numbers and names", 0, "", "52 aorta\n51 heart\n")
    with_names("with a mark of byte order", 0, "", b"\xef\xbb\xbfid,structure\n52,aorta\n")
    with_names("with tabs and ends of Windows", 0, "", "id\tstructure\r\n52\taorta\r\n")
    with_names("with semicolons and quotes", 0, "", 'value;name\n"52";"aorta"\n')
    with_names("with further columns", 0, "", "group,structure,x,id\na,aorta,7,52\n")
    with_names("empty", 1, "no names: write lines", "")
    with_names("with a header only", 1, "no names: write lines", "id,structure\n")
    with_names("in UTF-16", 1, "no text in UTF-8.*export", "52,aorta\n".encode("utf-16"))
    with_names("of noise", 1, "names.csv", bytes(range(256)) * 40)
    with_names("with the label 0", 0, "", "id,structure\n0,background\n52,aorta\n")
    with_names("with the label 70000", 1, "line 1: '70000' is no number", "70000,aorta\n")
    with_names("with a label twice", 1, "line 2: label 52 .*twice", "52,aorta\n52,vena_cava\n")
    with_names("with names that move the cursor", 1, "no structure is named 'aorta'", "52,\x1b[2Jaorta\n")
    with_names("of JSON", 1, "names.csv", '{"52": "aorta"}\n')
    with_names("of 200,000 lines", 1, "names.csv: line|too", "".join("%d,a\n" % n for n in range(1, 200000)))
    case("tables of names", "a missing one", 1, "none.csv", lambda kit: [kit.scan()] + kit.labels("none.csv"))
    case("tables of names", "a folder", 1, "", lambda kit: [kit.scan()] + kit.labels(kit.folder))


def command_lines():
    group = "command lines and other files"
    case(group, "no scan", 2, "SCAN is required", lambda kit: kit.labels())
    case(group, "an unknown option", 2, "--nothing", lambda kit: [kit.scan(), "--nothing"] + kit.labels())
    case(group, "a map without a table", 2, "--names", lambda kit: [kit.scan()] + kit.labels()[:2])
    case(group, "a table without a map", 2, "--labels", lambda kit: [kit.scan()] + kit.labels()[2:])
    case(group, "an empty name", 2, "", lambda kit: [""] + kit.labels())
    case(group, "a scan that is missing", 1, "is not there: give a scan", lambda kit: ["none.nrrd"] + kit.labels())
    case(group, "one slice instead of its folder", 1, "give the folder", lambda kit: [kit.slice()] + kit.labels())
    case(group, "a text", 1, "ending is not known: give", lambda kit: [kit.file("scan.txt", b"a text")] + kit.labels())
    case(
        group,
        "a picture",
        1,
        "ending is not known: give",
        lambda kit: [kit.file("scan.png", b"\x89PNG")] + kit.labels(),
    )
    case(
        group,
        "a folder named as a file",
        1,
        "no DICOM image",
        lambda kit: [kit.made_folder("scan.nrrd")] + kit.labels(),
    )
    case(group, "a pipe", 1, "scan.nrrd", lambda kit: [kit.made_pipe("scan.nrrd")] + kit.labels())
    case(group, "a device", 1, "zero", lambda kit: ["/dev/zero"] + kit.labels())


nrrd_files()
damaged_nrrd_files()
meta_files()
nifti_files()
label_maps()
damaged_label_maps()
tables()
command_lines()
