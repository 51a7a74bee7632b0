"""Makes the files for the tests of the file readers: valid files, pseudo-random mutations of valid files, and hand-made
files that are likely to break a reader. The extension of a file's name gives the kind of its content (see KINDS). The
script importers.py uses this module.
"""

import base64
import json
import random
import struct

KINDS = {".ply": "mesh", ".stl": "mesh", ".obj": "mesh", ".gltf": "mesh", ".glb": "mesh", ".toml": "toml",
         ".nrrd": "scan", ".mha": "scan", ".nii": "scan", ".gz": "scan", ".dcm": "series", ".csv": "line",
         ".json": "line", ".vtp": "line"}
INTERESTING = [b"0", b"-1", b"2147483647", b"-2147483648", b"4294967295", b"99999999999999999999", b"1e300", b"-1e300",
               b"nan", b"inf", b"none", b"1e-300", b"0x10", b"1.5", b"", b" ", b"\0", b"\xff", b"{", b"[",
               b"(", b"\n", b"3", b"65535"]
CORNERS = [(float(x), float(y), float(z)) for z in (0, 20) for y in (0, 30) for x in (0, 10)]
FACES = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2),
         (1, 3, 7), (1, 7, 5)]


def ply_head(style, vertices, faces):
    return ("ply\nformat %s 1.0\nelement vertex %s\nproperty float x\nproperty float y\nproperty float z\n"
            "element face %s\nproperty list uchar int vertex_indices\nend_header\n" % (style, vertices, faces)).encode()


def ply(style="ascii", vertices=8, faces=12, corners=FACES):
    if style == "ascii":
        body = "".join("%g %g %g\n" % v for v in CORNERS)
        body += "".join("%d %s\n" % (len(f), " ".join(map(str, f))) for f in corners)
        return ply_head(style, vertices, faces) + body.encode()
    order = "<" if "little" in style else ">"
    body = b"".join(struct.pack(order + "3f", *v) for v in CORNERS)
    lists = b"".join(struct.pack("%sB%di" % (order, len(f)), len(f), *f) for f in corners)
    return ply_head(style, vertices, faces) + body + lists


def stl(is_text):
    if not is_text:
        return b"box".ljust(80, b"\0") + struct.pack("<I", 12) + b"".join(
            struct.pack("<12fH", 0, 0, 0, *[c for i in f for c in CORNERS[i]], 0) for f in FACES)
    text = "solid box\n"
    for face in FACES:
        text += "facet normal 0 0 0\nouter loop\n%sendloop\nendfacet\n" % "".join(
            "vertex %g %g %g\n" % CORNERS[i] for i in face)
    return (text + "endsolid box\n").encode()


def obj():
    return ("# a box\no box\n" + "".join("v %g %g %g\n" % v for v in CORNERS)
            + "".join("f %d %d %d\n" % tuple(i + 1 for i in f) for f in FACES)).encode()


def gltf_root(uri=None, **changes):
    count = {"position": 8, "offset": 0, "index": 36, "bytes": 168}
    count.update(changes)
    buffer = {"byteLength": count["bytes"]}
    if uri:
        buffer["uri"] = uri
    return {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "box"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [{"bufferView": 0, "byteOffset": count["offset"], "componentType": 5126,
                           "count": count["position"], "type": "VEC3",
                           "min": [0, 0, 0], "max": [10, 30, 20]},
                          {"bufferView": 1, "componentType": 5123, "count": count["index"], "type": "SCALAR"}],
            "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 96},
                            {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
            "buffers": [buffer]}


GLTF_BYTES = b"".join(struct.pack("<3f", *v) for v in CORNERS) + b"".join(struct.pack("<3H", *f) for f in FACES)
GLTF_URI = "data:application/octet-stream;base64," + base64.b64encode(GLTF_BYTES).decode()


def gltf(**changes):
    return json.dumps(gltf_root(GLTF_URI, **changes)).encode()


def glb(root=None):
    text = json.dumps(root or gltf_root()).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(GLTF_BYTES), b"BIN\0") + GLTF_BYTES
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def nested_nodes(depth):
    root = gltf_root(GLTF_URI)
    root["nodes"] = [{"children": [i + 1]} for i in range(depth)] + [{"mesh": 0}]
    return json.dumps(root).encode()


def seeds():
    """Returns valid mesh files as pairs (name, bytes)."""
    return [("a.ply", ply()), ("b.ply", ply("binary_little_endian")), ("c.ply", ply("binary_big_endian")),
            ("a.stl", stl(True)),
            ("b.stl", stl(False)), ("a.obj", obj()), ("a.gltf", gltf()), ("a.glb", glb())]


def meshes_by_hand():
    box, flat = "binary_little_endian", [list(f) for f in FACES]
    wrapped, low = [list(f) for f in FACES], [list(f) for f in FACES]
    wrapped[5][1], low[7][2] = 2147483647, -1
    large = ply_head(box, 1300, 2300) + b"\0" * (12 * 1300) + struct.pack("<B3i", 3, 0, 1, 2147483647) + \
        struct.pack("<B3i", 3, 0, 1, 2) * 2299
    return [
        ("index_wrap.ply", large), ("index_wrap_text.ply", ply(corners=wrapped)), ("index_low.ply", ply(corners=low)),
        ("ten_vertices.ply", ply(box, vertices=10)), ("six_vertices.ply", ply(box, vertices=6)),
        ("huge_count.ply", ply(vertices=99999999999999999999)), ("huge_faces.ply", ply(box, faces=4000000000)),
        ("fewer_faces.ply", ply(box, faces=11)), ("more_faces.ply", ply(faces=13)),
        ("word.ply", ply().replace(b"30 0\n", b"thirty 0\n", 1)),
        ("nan.ply", ply().replace(b"10 30 20\n", b"nan 30 20\n", 1)),
        ("long_list.ply", ply(corners=flat[:11] + [list(range(8)) * 40])),
        ("no_face.ply", ply().replace(b"face", b"fac3")),
        ("count.stl", stl(False)[:80] + struct.pack("<I", 4294967295) + stl(False)[84:]), ("cut.stl", stl(False)[:-30]),
        ("word.stl", stl(True).replace(b"vertex 10 0 0", b"vertex ten 0 0", 1)),
        ("lost.stl", stl(True).replace(b"vertex 10 0 0\n", b"", 1)),
        ("index.obj", obj() + b"f 1 2 2147483647\n"), ("zero.obj", obj() + b"f 0 1 2\n"),
        ("low.obj", obj() + b"f -9 1 2\n"),
        ("word.obj", obj().replace(b"v 10 0 0", b"v ten 0 0", 1)), ("normal.obj", obj() + b"f 1//7 2//7 3//7\n"),
        ("nodes.gltf", nested_nodes(100000)),
        ("loop.gltf", json.dumps({**gltf_root(GLTF_URI), "nodes": [{"children": [0]}]}).encode()),
        ("brackets.gltf", b"[" * 10 ** 6 + b"]" * 10 ** 6), ("open_brackets.gltf", b'{"a":' * 10 ** 6),
        ("offset.gltf", gltf(offset=99)), ("offset_even.gltf", gltf(offset=96)), ("count.gltf", gltf(position=9)),
        ("index_count.gltf", gltf(index=4000000000)), ("buffer.gltf", gltf(bytes=10 ** 12)),
        ("primitives.gltf", gltf().replace(b'"primitives"', b'"primitkves"', 1)),
        ("far.stl", stl(True).replace(b"vertex 10 0 0", b"vertex 99999999999999999999 0 0", 1)),
        ("far.obj", obj().replace(b"v 10 0 0", b"v 99999999999999999999 0 0", 1)),
        ("length.glb", glb()[:8] + b"\xff\xff\xff\x7f" + glb()[12:]),
        ("offset.glb", glb(gltf_root(offset=99))), ("cut.glb", glb()[:-20])]


def volumes_and_lines_by_hand():
    head = "ObjectType = Image\nNDims = %s\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" \
        "ElementSpacing = %s\nDimSize = %s\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"
    values = bytes(range(128)) * 2

    def meta(dims, spacing, sizes):
        return (head % (dims, spacing, sizes)).encode() + values[:128]

    def nrrd(lines, sizes="4 4 4", dimension="3"):
        return ("NRRD0004\ntype: int16\ndimension: %s\nsizes: %s\nendian: little\nencoding: raw\n%s\n\n"
                % (dimension, sizes, lines)).encode() + values[:128]

    def directions(text):
        return "space: left-posterior-superior\nspace directions: %s\nspace origin: (0,0,0)" % text

    upright = "(1,0,0) (0,1,0) (0,0,1)"
    nifti = bytearray(352)
    struct.pack_into("<i", nifti, 0, 348)
    struct.pack_into("<8h", nifti, 40, 3, 4, 4, 4, 1, 1, 1, 1)
    struct.pack_into("<hh", nifti, 70, 4, 16)
    struct.pack_into("<8f", nifti, 76, 1, 1, 1, 1, 1, 1, 1, 1)
    struct.pack_into("<f", nifti, 108, 352)
    nifti[123] = 2
    nifti[344:348] = b"n+1\0"

    def nii(place, form, value):
        changed = bytearray(nifti)
        struct.pack_into(form, changed, place, value)
        return bytes(changed) + values[:128]

    deep = b'{"markups": ' + b"[" * 10 ** 6 + b"]" * 10 ** 6 + b"}"
    row = b"branch,x_mm,y_mm,z_mm,radius_mm\n0,0,0,0,2\n"
    return [
        ("dots.toml", b"[" + b"a." * 400000 + b"a]\n"), ("dots_key.toml", b"a." * 400000 + b"a = 1\n"),
        ("arrays.toml", b"a = " + b"[" * 10 ** 6),
        ("tables.toml", b"a = " + b"{b = " * 10 ** 5), ("quotes.toml", b'a = ["""x"""", ' + b"[" * 10 ** 5),
        ("spaces.toml", b"[" + b"'a' . " * 10 ** 5 + b"a]"),
        ("axes.mha", meta("-1", "1 1 1", "4 4 4")), ("axes_many.mha", meta("99999999", "1 1 1", "4 4 4")),
        ("size.mha", meta("3", "1 1 1", "99999 99999 99999")),
        ("size_low.mha", meta("3", "1 1 1", "4 -4 4")), ("spacing.mha", meta("3", "1 1e300 1", "4 4 4")),
        ("spacing_none.mha", meta("3", "none 1 1", "4 4 4")),
        ("spacing_few.mha", meta("3", "1 1", "4 4 4")),
        ("spacing_absent.mha", meta("3", "1 1 1", "4 4 4").replace(b"ElementSpacing = 1 1 1\n", b"")),
        ("metres.mha", meta("3", "1 1 1", "4 4 4").replace(b"ElementType", b"DistanceUnits = m\nElementType")),
        ("far.nrrd", nrrd(directions("(1e300,0,0) (0,1,0) (0,0,1)"))),
        ("none.nrrd", nrrd(directions("none (0,1,0) (0,0,1)"))),
        ("all_none.nrrd", nrrd(directions("none none none"))),
        ("nan.nrrd", nrrd(directions("(nan,0,0) (0,1,0) (0,0,1)"))), ("unscaled.nrrd", nrrd("space dimension: 3")),
        ("spacings.nrrd", nrrd("spacings: 1 nan 1")), ("spacings_far.nrrd", nrrd("spacings: 1 1e300 1")),
        ("metres.nrrd", nrrd(directions(upright) + '\nspace units: "m" "m" "m"')),
        ("size.nrrd", nrrd("spacings: 1 1 1", "99999 99999 99999")),
        ("dimension.nrrd", nrrd("spacings: 1 1 1", "4 4 4", "16")), ("short.nrrd", nrrd("spacings: 1 1 1", "4 4 5")),
        ("size.nii", nii(42, "<h", 32000)), ("size_low.nii", nii(42, "<h", -4)),
        ("spacing.nii", nii(80, "<f", float("nan"))),
        ("spacing_far.nii", nii(80, "<f", 1e30)), ("spacing_zero.nii", nii(80, "<f", 0)),
        ("axes.nii", nii(40, "<h", -1)),
        ("deep.mrk.json", deep), ("deep_open.mrk.json", b"[" * 10 ** 6), ("index.csv", row + b"4294967295,0,5,0,2\n"),
        ("far.csv", row + b"0,1e300,5,0,2\n"),
        ("nan.csv", row + b"0,nan,5,0,2\n"), ("cells.csv", row + b"," * 10 ** 6), ("deep.vtp", b"<a>" * 10 ** 6),
        ("count.vtp", b'<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="99999999999999999999" '
                      b'NumberOfLines="1"/></PolyData></VTKFile>')]


def by_hand():
    """Returns pairs (name, bytes) of files that the readers must refuse; each of these files once made a reader fail or
    was misread."""
    return meshes_by_hand() + volumes_and_lines_by_hand()


def mutated(data, draw):
    """Returns a copy of the file's bytes with one to four random faults."""
    data = bytearray(data)
    for _ in range(draw.choice((1, 1, 1, 2, 4))):
        kind, at = draw.randrange(9), draw.randrange(len(data) + 1)
        if kind <= 1 and data:
            data[at % len(data)] = draw.randrange(256)
        elif kind == 2 and data:
            data[at % len(data)] ^= 1 << draw.randrange(8)
        elif kind == 3:
            del data[at:]
        elif kind == 4:
            del data[at:at + draw.randrange(1, 16)]
        elif kind == 5:
            data[at:at] = data[at:at + draw.randrange(1, 64)]
        elif kind == 6:
            data[at:at] = draw.choice(INTERESTING)
        else:
            # One whole number or word becomes another.
            begin = at
            while begin > 0 and data[begin - 1:begin] not in (b" ", b"\n", b",", b":", b"[", b"=", b"(", b"\""):
                begin -= 1
            end = begin
            while end < len(data) and data[end:end + 1] not in (b" ", b"\n", b",", b"]", b"}", b")", b"\""):
                end += 1
            if end - begin < 40:
                data[begin:end] = draw.choice(INTERESTING)
    return bytes(data)


def generator(seed):
    return random.Random(seed)
