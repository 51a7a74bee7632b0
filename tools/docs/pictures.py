#!/usr/bin/env python3
"""Makes the pictures of README and docs from simulated sessions. The program stores the core's version and the command
that made the picture in each picture file, as its stamp.

  pictures.py --write [NAME ...]   make these pictures (all without a name) and stamp them
  pictures.py --check              exit 1 when a picture has no stamp, or an old one
  pictures.py --show FILE ...      print stamps

The file tools/docs/pictures.toml describes how each picture is made. The stamp of a picture is a JPEG comment or a PNG
text chunk with one `key: value` per line. The stamp's keys are `core` (the core's version when the picture was made),
`command`, `inputs` and `shows`. `inputs` is a hash over the picture's entry in pictures.toml and over the sessions,
tools and lesions that the command names. `shows` is the vessel branch in which the tool's tip ended, according to the
session's report. A picture of a session is old when the core or the inputs in its stamp differ from the present ones. A
picture that shows no simulated tool is marked as `still`, and is old only when its inputs differ. A picture that an
older core made may be marked as `kept`; its caption must then name the version of that core.
"""

import argparse
import hashlib
import json
import os
import re
import struct
import subprocess
import sys
import tomllib
import zlib

MANIFEST = "tools/docs/pictures.toml"
WORK = "out/docs"
CAPTION_LETTERS = 500  # behind a picture's link
LINK = re.compile(r"!\[[^\]]*\]\(([^)]+\.(?:jpg|png))\)")


class PictureError(Exception):
    """Raised for an error in a picture; the text names the picture and the remedy."""


def read_manifest(path=MANIFEST):
    with open(path, "rb") as file:
        return tomllib.load(file)


def core_version(header="firmware/core/core.h"):
    with open(header, encoding="utf-8") as file:
        return re.search(r"CRN_CORE_VERSION = (\d+)", file.read()).group(1)


# --- stamps ----------------------------------------------------------------------------------------------------------


def stamp_text(fields):
    return "".join("%s: %s\n" % (key, value) for key, value in fields.items())


def stamp_fields(text):
    return dict(line.split(": ", 1) for line in text.splitlines() if ": " in line)


def jpeg_segments(data):
    """Yields (marker, begin, end) of every JPEG segment before the image data."""
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF and data[at + 1] != 0xDA:
        end = at + 2 + struct.unpack(">H", data[at + 2 : at + 4])[0]
        yield data[at + 1], at, end
        at = end


def png_chunks(data):
    at = 8
    while at + 8 <= len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        yield kind, at, at + 12 + length
        at += 12 + length


def read_stamp(path):
    """Returns the fields of a picture file's stamp, or an empty table if the file has no stamp."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:2] == b"\xff\xd8":
        for marker, begin, end in jpeg_segments(data):
            if marker == 0xFE and data[begin + 4 : end].startswith(b"core: "):
                return stamp_fields(data[begin + 4 : end].decode("utf-8"))
    elif data[:8] == b"\x89PNG\r\n\x1a\n":
        for kind, begin, end in png_chunks(data):
            if kind == b"tEXt" and data[begin + 8 : end - 4].startswith(b"Comment\0core: "):
                return stamp_fields(data[begin + 16 : end - 4].decode("latin-1"))
    else:
        raise PictureError("%s: neither JPEG nor PNG" % path)
    return {}


def put_stamp(path, fields):
    """Replaces the file's stamp."""
    with open(path, "rb") as file:
        data = file.read()
    text = stamp_text(fields).encode("utf-8")
    if data[:2] == b"\xff\xd8":
        old = [(b, e) for m, b, e in jpeg_segments(data) if m == 0xFE]
        place, piece = 2, b"\xff\xfe" + struct.pack(">H", len(text) + 2) + text
    else:
        old = [(b, e) for k, b, e in png_chunks(data) if k == b"tEXt"]
        body = b"tEXtComment\0" + text
        place, piece = 33, struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    for begin, end in reversed(old):
        data = data[:begin] + data[end:]
    with open(path, "wb") as file:
        file.write(data[:place] + piece + data[place:])


# --- the inputs of a picture -------------------------------------------------------------------------------------


def film_of(manifest, picture):
    return manifest["film"][picture["film"]] if "film" in picture else {}


def inputs_hash(manifest, picture):
    """Returns a hash of a picture's entry in the manifest and of every file that the entry names, except the programs
    and the scene."""
    film = film_of(manifest, picture)
    # How old a picture may be changes nothing in it.
    made = {key: value for key, value in picture.items() if key not in ("kept", "still")}
    digest = hashlib.sha256(json.dumps([made, film], sort_keys=True).encode())
    for path in [film.get("session")] + film.get("tools", []) + film.get("stents", []) + picture.get("inputs", []):
        if path:
            with open(path, "rb") as file:
                lines = file.read().splitlines(keepends=True)
            # The manifest itself states the scene and the tools; a session's own `needs` lines change no picture.
            is_session = path.endswith(".session")
            digest.update(b"".join(line for line in lines if not (is_session and line.startswith(b"needs "))))
    return digest.hexdigest()[:12]


def film_command(name, film, build="build"):
    words = [build + "/bin/cournand", "run", "--scene", film["scene"]]
    for tool in film["tools"]:
        words += ["--tool", tool]
    for stent in film.get("stents", []):
        words += ["--stent", stent]
    words += [
        "--session",
        film["session"],
        "--size",
        str(film.get("size", 512)),
        "--quiet",
        "--record",
        "%s/%s.rec" % (WORK, name),
        "--json",
        "%s/%s.json" % (WORK, name),
        "--mp4",
        "%s/%s.mp4" % (WORK, name),
    ]
    return words + film.get("options", [])


def command_of(manifest, picture):
    """Returns the command with which a reader of the documents can make the picture."""
    return (
        picture.get("command") or "make docs-pictures NAMES=%s" % os.path.splitext(os.path.basename(picture["file"]))[0]
    )


def problems(manifest, linked, core):
    """Returns the errors that --check prints, one line per wrong picture."""
    known = {picture["file"]: picture for picture in manifest["picture"]}
    found = ["%s: shown in the documents but not in %s" % (path, MANIFEST) for path in sorted(linked - set(known))]
    found += ["%s: in %s but shown in no document" % (path, MANIFEST) for path in sorted(set(known) - linked)]
    for path, picture in known.items():
        again = "run: make docs-pictures NAMES=" + os.path.splitext(os.path.basename(path))[0]
        if not os.path.exists(path):
            found.append("%s: not there; %s" % (path, again))
            continue
        stamp = read_stamp(path)
        if not stamp:
            found.append("%s: no stamp; %s" % (path, again))
            continue
        if "kept" in picture:
            found += unsaid(path, picture["kept"], stamp)
        elif not picture.get("still") and stamp.get("core") != core:
            found.append("%s: made by core %s, this is core %s; %s" % (path, stamp.get("core"), core, again))
        if stamp.get("inputs") != inputs_hash(manifest, picture):
            found.append("%s: its session, tools or entry have changed since; %s" % (path, again))
        if stamp.get("command") != command_of(manifest, picture):
            found.append("%s: its stamp names another command; %s" % (path, again))
        wanted = film_of(manifest, picture).get("tip")
        if wanted and stamp.get("shows") != wanted:
            found.append("%s: shows a tip in '%s' instead of '%s'; %s" % (path, stamp.get("shows"), wanted, again))
    return found


def unsaid(path, kept, stamp):
    """Checks a picture that is kept from an older core. Every caption of a picture that is kept must name the version
    of the older core."""
    found = (
        []
        if stamp.get("core") == str(kept)
        else ["%s: its stamp says core %s, %s says %d" % (path, stamp.get("core"), MANIFEST, kept)]
    )
    for document in documents():
        with open(document, encoding="utf-8") as file:
            text = file.read()
        at = text.find("](%s)" % os.path.relpath(path, os.path.dirname(document) or "."))
        if at >= 0 and "core %d" % kept not in text[at : at + CAPTION_LETTERS]:
            found.append("%s: %s shows it without saying that core %d made it" % (path, document, kept))
    return found


def linked_pictures(documents):
    """Returns the paths of the pictures that the documents show."""
    linked = set()
    for document in documents:
        with open(document, encoding="utf-8") as file:
            for target in LINK.findall(file.read()):
                linked.add(os.path.normpath(os.path.join(os.path.dirname(document), target)))
    return linked


def documents():
    return ["README.md"] + [os.path.join("docs", name) for name in sorted(os.listdir("docs")) if name.endswith(".md")]


# --- making ----------------------------------------------------------------------------------------------------------


def run(words, what):
    done = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        raise PictureError(
            "%s failed (exit code %d): %s\n%s" % (what, done.returncode, " ".join(words), done.stdout[-2000:])
        )


class Maker:
    """Makes each film of a session only once, even if several pictures are taken from the film."""

    def __init__(self, manifest):
        self.manifest = manifest
        self.reports = {}

    def film(self, name):
        """Returns the session report that belongs to a film, after making the film if it does not exist yet."""
        if name not in self.reports:
            film = self.manifest["film"][name]
            print("  film %s" % name, flush=True)
            run(film_command(name, film), "the session of film '%s'" % name)
            with open("%s/%s.json" % (WORK, name), encoding="utf-8") as file:
                self.reports[name] = json.load(file)
            branch = self.reports[name]["tip"]["branch"]
            if branch != film.get("tip", branch):
                raise PictureError("film '%s' ends with its tip in '%s' instead of '%s'" % (name, branch, film["tip"]))
        return self.reports[name]

    def make(self, picture):
        shows = "-"
        os.makedirs(WORK, exist_ok=True)
        if "film" in picture:
            shows = self.film(picture["film"])["tip"]["branch"]
            self.compose(picture)
        for line in picture.get("shell", []):
            run(["bash", "-euo", "pipefail", "-c", line], picture["file"])
        put_stamp(
            picture["file"],
            {
                "core": core_version(),
                "command": command_of(self.manifest, picture),
                "inputs": inputs_hash(self.manifest, picture),
                "shows": shows,
            },
        )
        print("  %s" % picture["file"], flush=True)

    def compose(self, picture):
        """Makes a picture by putting several frames of a film side by side."""
        if "frames" not in picture:
            return
        film = "%s/%s.mp4" % (WORK, picture["film"])
        words, parts = ["ffmpeg", "-v", "error", "-y"], []
        for number, frame in enumerate(picture["frames"]):
            at_s, source = self.moment(picture, frame), film
            if isinstance(frame, dict) and "film" in frame:
                self.film(frame["film"])
                source = "%s/%s.mp4" % (WORK, frame["film"])
            words += ["-ss", "%.3f" % at_s, "-i", source]
            parts.append(
                "[%d:v]trim=end_frame=1%s[p%d]"
                % (number, "," + picture["filter"] if "filter" in picture else "", number)
            )
        joined = "".join("[p%d]" % number for number in range(len(parts)))
        graph = ";".join(parts) + ";" + joined + ("hstack=%d" % len(parts) if len(parts) > 1 else "null")
        os.makedirs(os.path.dirname(picture["file"]), exist_ok=True)
        run(words + ["-filter_complex", graph, "-frames:v", "1", "-q:v", "4", picture["file"]], picture["file"])

    def moment(self, picture, frame):
        wanted = frame["at"] if isinstance(frame, dict) else frame
        report = self.film(frame["film"] if isinstance(frame, dict) and "film" in frame else picture["film"])
        at_s, end_s = seconds_of(wanted, report), report["ticks"] * 1e-3
        if at_s > end_s:
            raise PictureError(
                "%s: no frame at %s, its film ends after %.1f s; give `frames` of %s in %s anew"
                % (picture["file"], wanted, end_s, picture["file"], MANIFEST)
            )
        # The last picture of a film covers its last fifteenth of a second.
        return max(min(at_s, end_s - 0.1), 0.0)


def seconds_of(wanted, report):
    """Returns the time in a film, in seconds, of the moment that a text describes. The text that describes the moment
    is a number of seconds, `end`, `expect N`, `run N at S` or `fluoroscopy N at S`. The text `expect N` stands for the
    moment at which the session's Nth expectation was checked. The texts `run N at S` and `fluoroscopy N at S` stand for
    S seconds after the beginning of the Nth X-ray run, or of the Nth time that the pedal of fluoroscopy was down."""
    if not isinstance(wanted, str):
        return wanted
    words = wanted.split()
    if wanted == "end":
        return report["ticks"] * 1e-3
    if words[0] == "expect" and len(words) == 2:
        return report["expected"][int(words[1]) - 1]["at_s"]
    if words[0] in ("run", "fluoroscopy") and words[2:3] == ["at"] and len(words) == 4:
        beams = report["room"]["irradiations"]
        if words[0] == "run":
            numbered = [(one["run"], one) for one in beams]
        else:
            numbered = list(enumerate((one for one in beams if one["kind"] == "fluoroscopy"), 1))
        for number, one in numbered:
            if number == int(words[1]) and one["begin_s"] + float(words[3]) <= one["end_s"]:
                return one["begin_s"] + float(words[3])
        raise PictureError(
            "no X-ray %s %s that lasts %s s; see `irradiations` of the film's report" % (words[0], words[1], words[3])
        )
    raise PictureError("'%s' is no moment: seconds, end, expect N, run N at S or fluoroscopy N at S" % wanted)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    action = parser.add_mutually_exclusive_group(required=True)
    action.add_argument("--write", nargs="*", metavar="NAME")
    action.add_argument("--check", action="store_true")
    action.add_argument("--show", nargs="+", metavar="FILE")
    options = parser.parse_args()
    manifest = read_manifest()
    try:
        if options.show:
            for path in options.show:
                print(path + "\n" + stamp_text(read_stamp(path)))
            return 0
        if options.check:
            found = problems(manifest, linked_pictures(documents()), core_version())
            print("\n".join(found) if found else "%d pictures are current" % len(manifest["picture"]))
            return 1 if found else 0
        return write(manifest, options.write)
    except PictureError as error:
        print("pictures: %s" % error, file=sys.stderr)
        return 1


def write(manifest, names):
    named = {os.path.splitext(os.path.basename(picture["file"]))[0]: picture for picture in manifest["picture"]}
    unknown = [name for name in names if name not in named]
    if unknown:
        print("pictures: no picture '%s'; known: %s" % (unknown[0], " ".join(sorted(named))), file=sys.stderr)
        return 2
    maker = Maker(manifest)
    for name, picture in named.items():
        if name in names or (not names and not picture.get("apart")):
            maker.make(picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
