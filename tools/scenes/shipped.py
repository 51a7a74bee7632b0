#!/usr/bin/env python3
"""Unpacks the shipped compressed scenes (`make run`), or makes the scenes again and compares them with the shipped ones
(`make scene`).

  shipped.py unpack shared/examples/scenes/aorta.tar.xz -o out
  shipped.py make shared/examples/scenes/aorta.tar.xz --anatomy build/anatomy/aorta/scene.toml \\
      --bake build/bin/bake [--accept]

The command `shipped.py make` bakes the anatomy into a temporary folder and compares every file with the shipped file,
byte for byte. With --accept the new files replace the shipped files. Archives that are made from equal files are equal
byte for byte. The exit code is 1 when a file differs from the shipped file or cannot be read.
"""

import argparse
import hashlib
import io
import lzma
import os
import subprocess
import sys
import tarfile
import tempfile

MEMBER_BYTES_MAX = 256 << 20


class Fault(Exception):
    """Raised when a scene or its archive is wrong or cannot be made; the text gives the remedy."""


def read_archive(path):
    """Returns name -> bytes."""
    files = {}
    try:
        with tarfile.open(path, "r:xz") as archive:
            for member in archive:
                if not member.isfile() or "/" in member.name or member.size > MEMBER_BYTES_MAX:
                    raise Fault("%s: '%s' is no file of a scene" % (path, member.name))
                files[member.name] = archive.extractfile(member).read()
    except (OSError, tarfile.TarError, lzma.LZMAError, EOFError) as error:
        raise Fault("%s: cannot be read: %s; get the file again, or `make scene ACCEPT=1`" % (path, error)) from error
    if not files:
        raise Fault("%s: holds no file" % path)
    return files


def write_whole(path, data):
    """Writes a file completely or, after an error, leaves the old file unchanged."""
    temporary = "%s.part%d" % (path, os.getpid())
    try:
        with open(temporary, "wb") as file:
            file.write(data)
        os.replace(temporary, path)
    except OSError as error:
        raise Fault("%s: cannot be written: %s" % (path, error)) from error
    finally:
        if os.path.exists(temporary):
            os.remove(temporary)


def write_archive(path, files):
    packed = io.BytesIO()
    with tarfile.open(
        fileobj=packed, mode="w:xz", preset=9 | lzma.PRESET_EXTREME, format=tarfile.USTAR_FORMAT
    ) as archive:
        for name in sorted(files):
            member = tarfile.TarInfo(name)
            member.size, member.mode = len(files[name]), 0o644
            archive.addfile(member, io.BytesIO(files[name]))
    write_whole(path, packed.getvalue())
    return len(packed.getvalue())


def bake(program, anatomy, name):
    """Makes the scene and its bodies again, and returns a table of the bytes of each file by its name."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([program, anatomy, "-o", os.path.join(folder, name + ".scene")], check=False)
        if done.returncode != 0:
            raise Fault("%s ended with %d" % (program, done.returncode))
        files = {}
        for made in sorted(os.listdir(folder)):
            with open(os.path.join(folder, made), "rb") as file:
                files[made] = file.read()
        return files


def digest(data):
    return hashlib.sha256(data).hexdigest()[:16]


def differences(shipped, made):
    """Returns a sentence for every file that differs from the shipped file."""
    for name in sorted(set(shipped) | set(made)):
        if name not in made:
            yield "%s ships, but is not made" % name
        elif name not in shipped:
            yield "%s is made, but does not ship" % name
        elif shipped[name] != made[name]:
            yield "%s differs: ships %s, is made as %s" % (name, digest(shipped[name]), digest(made[name]))


def unpack(options):
    files = read_archive(options.archive)
    try:
        os.makedirs(options.output, exist_ok=True)
    except OSError as error:
        raise Fault("%s: cannot be made: %s" % (options.output, error)) from error
    for name, data in files.items():
        write_whole(os.path.join(options.output, name), data)
    print("Unpacked %s into %s: %s" % (options.archive, options.output, ", ".join(sorted(files))))


def make(options):
    name = os.path.basename(options.archive).split(".")[0]
    made = bake(options.bake, options.anatomy, name)
    for one in sorted(made):
        print("%s  %s" % (digest(made[one]), one))
    if options.accept:
        print("%s: %d bytes" % (options.archive, write_archive(options.archive, made)))
        return
    found = list(differences(read_archive(options.archive), made))
    if found:
        raise Fault("\n".join(found) + "\n`make scene ACCEPT=1` ships what is made; say in the commit why it changed")
    print("%s holds the same bytes" % options.archive)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("unpack", help="write the files of an archive into a folder")
    one.add_argument("archive")
    one.add_argument("-o", "--output", required=True, help="the folder")
    one = commands.add_parser("make", help="bake an anatomy and compare it with what ships")
    one.add_argument("archive")
    one.add_argument("--anatomy", required=True, help="scene.toml of the anatomy")
    one.add_argument("--bake", required=True, help="the program")
    one.add_argument("--accept", action="store_true", help="the new files ship")
    options = parser.parse_args()
    try:
        unpack(options) if options.command == "unpack" else make(options)
    except Fault as fault:
        print("shipped: %s" % fault, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
