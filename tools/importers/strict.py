"""Reads the file formats strictly, and independently of the program `importers`. Each function returns the content of a
file, or raises ValueError. If the program `importers` accepts a file but reads other content than these functions do,
it has misread the file without reporting an error. The script importers.py uses this module.
"""

import base64
import csv
import gzip
import io
import json
import math
import re
import struct
import tomllib
import xml.etree.ElementTree as xml
import zlib


def number(word):
    text = word.decode() if isinstance(word, bytes) else word
    if "_" in text or not re.fullmatch(r"[+-]?(\d+\.?\d*([eE][+-]?\d+)?|\.\d+([eE][+-]?\d+)?)", text):
        raise ValueError("no number: %r" % text[:40])
    return float(text)


def single(value):
    """Rounds a number to a 32-bit float."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def summed(vertices, faces):
    """Returns a summary of a mesh: its number of triangles, and the sum and the range of its coordinates. The program
    `importers` splits a polygon into a fan of triangles, so some corners are counted several times. The summary
    therefore has the sum of the corner coordinates only if all faces are triangles."""
    total, low, high, triangles, other = 0.0, math.inf, -math.inf, 0, 0
    for face in faces:
        if any(not 0 <= corner < len(vertices) for corner in face):
            raise ValueError("a corner that is not there")
        if len(face) < 3:
            other += 1
            continue
        triangles += len(face) - 2
        for corner in face:
            for k in range(3):
                value = single(vertices[corner][k])
                if not math.isfinite(value):
                    raise ValueError("not finite")
                low, high = min(low, value), max(high, value)
                total += value * (k + 1)
    plain = all(len(face) <= 3 for face in faces)
    return {"faces": triangles, "sum": total if plain else None, "low": low, "high": high}


PLY = {
    "char": "b",
    "int8": "b",
    "uchar": "B",
    "uint8": "B",
    "short": "h",
    "int16": "h",
    "ushort": "H",
    "uint16": "H",
    "int": "i",
    "int32": "i",
    "uint": "I",
    "uint32": "I",
    "float": "f",
    "float32": "f",
    "double": "d",
    "float64": "d",
}


def ply(data):
    head, mark, body = data.partition(b"end_header")
    if not mark:
        raise ValueError("no end_header")
    body = body[body.index(b"\n") + 1 :]
    elements, style = [], None
    for row in head.decode("latin-1").split("\n")[1:]:
        words = row.split()
        if not words:
            continue
        if words[0] == "format":
            style = words[1]
        elif words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            elements[-1][2].append(words[1:])
    records = {}
    words, at = iter(body.split()), 0
    order = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}[style]

    def value(kind):
        nonlocal at
        if order is None:
            word = next(words, None)
            if word is None:
                raise ValueError("cut short")
            return number(word) if PLY[kind] in "fd" else int(number(word))
        size = struct.calcsize(PLY[kind])
        if at + size > len(body):
            raise ValueError("cut short")
        at += size
        return struct.unpack_from(order + PLY[kind], body, at - size)[0]

    for name, count, properties in elements:
        if count < 0 or count > len(body) + 1:
            raise ValueError("count")
        records[name] = rows = []
        for _ in range(count):
            row = {}
            for kind in properties:
                if kind[0] == "list":
                    row[kind[3]] = [value(kind[2]) for _ in range(value(kind[1]))]
                else:
                    row[kind[1]] = value(kind[0])
            rows.append(row)
    vertices = [(row["x"], row["y"], row["z"]) for row in records["vertex"]]
    return summed(vertices, [row.get("vertex_indices", row.get("vertex_index")) for row in records["face"]])


def stl(data):
    if len(data) >= 84 and 84 + 50 * struct.unpack_from("<I", data, 80)[0] == len(data):
        points = [
            struct.unpack_from("<3f", data, 84 + 50 * i + 12 + 12 * k)
            for i in range((len(data) - 84) // 50)
            for k in range(3)
        ]
    else:
        text = data.decode("latin-1")
        if not text.lstrip().startswith("solid"):
            raise ValueError("no STL")
        points = [tuple(map(number, row)) for row in re.findall(r"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", text)]
        if len(points) != 3 * len(re.findall(r"\bendfacet\b", text)):
            raise ValueError("facets")
    return summed(points, [(i, i + 1, i + 2) for i in range(0, len(points), 3)])


def obj(data):
    vertices, faces = [], []
    for row in data.decode("latin-1").replace("\\\n", " ").split("\n"):
        words = row.split("#")[0].split()
        if words and words[0] == "v":
            vertices.append(tuple(map(number, words[1:4])))
        elif words and words[0] == "f":
            corners = [int(word.split("/")[0]) for word in words[1:]]
            faces.append([c - 1 if c > 0 else len(vertices) + c for c in corners])
    return summed(vertices, faces)


GLTF = {5121: "B", 5123: "H", 5125: "I", 5126: "f"}


def gltf(data):
    chunk = b""
    if data[:4] == b"glTF":
        length = struct.unpack_from("<I", data, 12)[0]
        text, chunk = data[20 : 20 + length], data[28 + length :]
    else:
        text = data
    root = json.loads(text)
    blobs = []
    for buffer in root["buffers"]:
        blob = base64.b64decode(buffer["uri"].partition(",")[2]) if "uri" in buffer else chunk
        if len(blob) < buffer["byteLength"]:
            raise ValueError("buffer")
        blobs.append(blob[: buffer["byteLength"]])

    def values(index, size):
        accessor = root["accessors"][index]
        view = root["bufferViews"][accessor["bufferView"]]
        begin, kind = view.get("byteOffset", 0), GLTF[accessor["componentType"]]
        if index < 0 or accessor["bufferView"] < 0 or begin + view["byteLength"] > len(blobs[view["buffer"]]):
            raise ValueError("view")
        own = blobs[view["buffer"]][begin : begin + view["byteLength"]]
        each = struct.calcsize("<%d%s" % (size, kind))
        stride, offset = view.get("byteStride", each), accessor.get("byteOffset", 0)
        return [struct.unpack_from("<%d%s" % (size, kind), own, offset + stride * i) for i in range(accessor["count"])]

    vertices, faces = [], []
    for node in root["nodes"]:
        if "mesh" not in node:
            continue
        for primitive in root["meshes"][node["mesh"]]["primitives"]:
            base, moved = len(vertices), node.get("translation", [0, 0, 0])
            if primitive.get("mode", 4) != 4 or any(key in node for key in ("matrix", "rotation", "scale", "children")):
                return None  # this reader does not handle it
            vertices += [
                tuple(v[k] + moved[k] for k in range(3)) for v in values(primitive["attributes"]["POSITION"], 3)
            ]
            corners = (
                [c[0] + base for c in values(primitive["indices"], 1)]
                if "indices" in primitive
                else list(range(base, len(vertices)))
            )
            faces += [corners[i : i + 3] for i in range(0, len(corners) - 2, 3)]
    return summed(vertices, faces)


def toml(data):
    found = {"keys": 0, "letters": 0, "values": 0, "sum": 0.0}

    def add(node):
        if isinstance(node, dict):
            for key, value in node.items():
                found["keys"] += 1
                found["letters"] += len(key.encode())
                add(value)
        elif isinstance(node, list):
            for value in node:
                add(value)
        else:
            found["values"] += 1
            if isinstance(node, str):
                found["letters"] += len(node.encode())
            elif isinstance(node, (int, float)) and not isinstance(node, bool) and math.isfinite(node):
                found["sum"] += node

    add(tomllib.loads(data.decode("utf-8-sig")))
    return found


KINDS = {
    "short": "h",
    "int16": "h",
    "unsigned short": "H",
    "uint16": "H",
    "int": "i",
    "int32": "i",
    "float": "f",
    "double": "d",
    "uchar": "B",
    "unsigned char": "B",
    "uint8": "B",
    "MET_SHORT": "h",
    "MET_USHORT": "H",
    "MET_INT": "i",
    "MET_FLOAT": "f",
    "MET_UCHAR": "B",
    "MET_CHAR": "b",
    "MET_DOUBLE": "d",
}


def grid(sizes, spacings, values):
    if len(sizes) < 3 or len(spacings) < 3 or not all(math.isfinite(s) and 0.01 <= s <= 10 for s in spacings[:3]):
        raise ValueError("grid")
    if min(sizes) < 1 or any(n != 1 for n in sizes[3:]):
        raise ValueError("sizes")
    return {"size": list(sizes[:3]), "spacing_mm": list(spacings[:3]), "sum": values}


def total(body, sizes, kind, order):
    count = math.prod(sizes)
    if count > 10**7 or len(body) < count * struct.calcsize(kind):
        raise ValueError("cut short")
    return float(sum(struct.unpack_from("%s%d%s" % (order, count, kind), body)))


def nrrd(data):
    head, _, body = data.partition(b"\n\n")
    fields = {}
    for row in head.decode("latin-1").split("\n")[1:]:
        if not row.startswith("#") and ":=" not in row:
            name, _, value = row.partition(":")
            fields[name.strip().lower()] = value.strip()
    sizes = [int(n) for n in fields["sizes"].split()]
    if "space directions" in fields:
        vectors = re.findall(r"\(([^)]*)\)|(none)", fields["space directions"])
        spacings = [math.hypot(*(number(n.strip()) for n in v.split(","))) for v, none in vectors]
    else:
        spacings = [number(n) for n in fields["spacings"].split()]
    if int(fields["dimension"]) != 3:
        raise ValueError("dimension")
    if fields["encoding"].lower() in ("gzip", "gz"):
        body = zlib.decompressobj(31).decompress(body)
    elif fields["encoding"].lower() != "raw":
        return grid(sizes, spacings, None)
    kind = KINDS.get(fields["type"].lower())
    if kind is None:
        return grid(sizes, spacings, None)
    return grid(sizes, spacings, total(body, sizes, kind, ">" if fields.get("endian") == "big" else "<"))


def meta(data):
    fields, at = {}, 0
    while "ElementDataFile" not in fields:
        end = data.index(b"\n", at)
        name, _, value = data[at:end].decode("latin-1").partition("=")
        fields[name.strip()] = value.strip()
        at = end + 1
    axes = int(fields["NDims"])
    sizes = [int(n) for n in fields["DimSize"].split()]
    spacings = [number(n) for n in fields["ElementSpacing"].split()]
    if axes not in (3, 4) or len(sizes) != axes or len(spacings) != axes:
        raise ValueError("axes")
    # The position of the values follows from the end of the file, whatever precedes them: ITK's rule for HeaderSize
    # -1.
    kind, body = KINDS[fields["ElementType"]], data[at:]
    if fields.get("CompressedData", "False").lower()[0] in "t1":
        body = zlib.decompress(body)
    if fields.get("HeaderSize") is not None or fields.get("BinaryData", "True") != "True":
        return grid(sizes, spacings, None)
    big = fields.get("BinaryDataByteOrderMSB", fields.get("ElementByteOrderMSB", "False")).lower()[:1] in ("t", "1")
    return grid(sizes, spacings, total(body, sizes, kind, ">" if big else "<"))


def nifti(data):
    if data[:2] == b"\x1f\x8b":
        data = gzip.decompress(data)
    order = "<" if struct.unpack_from("<i", data)[0] == 348 else ">"
    axes = struct.unpack_from(order + "8h", data, 40)
    spacings = struct.unpack_from(order + "8f", data, 76)[1:4]
    unit = {1: 1000.0, 3: 1e-3}.get(data[123] & 7, 1.0)
    return grid(list(axes[1 : 1 + axes[0]]), [unit * s for s in spacings], None)


def tree_of(branches):
    spheres = [sphere for branch in branches for sphere in branch]
    if not all(math.isfinite(v) for s in spheres for v in s) or not all(s[3] > 0 for s in spheres):
        raise ValueError("sphere")
    return {
        "branches": len(branches),
        "spheres": len(spheres),
        "sum": sum(s[0] + 2 * s[1] + 3 * s[2] for s in spheres),
        "radii": sum(s[3] for s in spheres),
    }


def table(data):
    rows = [
        row
        for row in csv.reader(io.StringIO(data.decode("latin-1")))
        if row and not row[0].startswith("#") and any(cell.strip() for cell in row)
    ]
    titles = [cell.strip() for cell in rows[0]]
    branches = {}
    for row in rows[1:]:
        cell = dict(zip(titles, (c.strip() for c in row)))
        branches.setdefault(int(number(cell["branch"])), []).append(
            tuple(number(cell[name]) for name in ("x_mm", "y_mm", "z_mm", "radius_mm"))
        )
    return tree_of(list(branches.values()))


def markups(data):
    branches = []
    for markup in json.loads(data)["markups"]:
        radii = next(m["controlPointValues"] for m in markup["measurements"] if m.get("name") == "Radius")
        unit = {"m": 1000.0, "cm": 10.0, "mm": 1.0, "um": 1e-3}[markup.get("coordinateUnits", "mm")]
        branches.append(
            [
                tuple(unit * v for v in (*point["position"], radius))
                for point, radius in zip(markup["controlPoints"], radii, strict=True)
            ]
        )
    return tree_of(branches)


def polydata(data):
    # Letters that XML does not allow occur in names that are not read; within numbers they are refused below.
    root = xml.fromstring(bytes(c if c in b"\t\n\r" or 32 <= c < 127 else 95 for c in data))
    arrays = {}
    for piece in root.iter("Piece"):
        if arrays:
            return None  # this reader does not handle several pieces
        for part in piece:
            for array in part:
                if array.get("format") not in ("ascii", None):
                    return None
                arrays.setdefault((part.tag, array.get("Name")), (array.text or "").split())
        points = [number(w) for w in (piece.find("Points")[0].text or "").split()]
        lines = int(piece.get("NumberOfLines"))
    radii = [number(w) for w in arrays[("PointData", "MaximumInscribedSphereRadius")]]
    order = [int(number(w)) for w in arrays[("Lines", "connectivity")]]
    ends = [int(number(w)) for w in arrays[("Lines", "offsets")]]
    if len(points) != 3 * len(radii) or len(ends) != lines:
        raise ValueError("counts")
    branches = [[(*points[3 * p : 3 * p + 3], radii[p]) for p in order[a:b]] for a, b in zip([0] + ends, ends)]
    return tree_of(branches)


READERS = {
    ".ply": ply,
    ".stl": stl,
    ".obj": obj,
    ".gltf": gltf,
    ".glb": gltf,
    ".toml": toml,
    ".nrrd": nrrd,
    ".mha": meta,
    ".nii": nifti,
    ".gz": nifti,
    ".csv": table,
    ".json": markups,
    ".vtp": polydata,
}
