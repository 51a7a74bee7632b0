"""A data set on the disk: its plan, its completion from the manifests of all shards, and its check.

    plan.json                     the options and versions; the first file of a run
    shards/000012/                one shard: the files of all formats, and manifest.json
    webdataset/ coco/ dicom/ lerobot/    the same files by format (hard links), with what a format has for all shards
    index.json datasheet.md statistics.html contact_sheet.png

The files of the last two lines above are made from the manifests, in the order of the shards. These files can be made
again at any time, and have the same bytes each time.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path

from . import datasheet, statistics
from .formats import coco
from .options import PLAN, Options, UsageError, read_options, versions, write_options
from .shard import make_shard
from .store import MANIFEST, StoreError, faults_of_shard, is_made, read_manifest, shard_folder, write_parts, write_whole

INDEX, DATASHEET, STATISTICS, SHEET = "index.json", "datasheet.md", "statistics.html", "contact_sheet.png"


def begin(dataset: Path, options: Options) -> None:
    """Writes the plan into a folder that has no plan, or checks that the folder's plan is the same."""
    path = dataset / PLAN
    if path.exists():
        if load(dataset) != options:
            raise UsageError(
                "%s holds a data set with other options. Remedy: `resume` it, or name another --out" % dataset
            )
        return
    if dataset.exists() and (not dataset.is_dir() or any(dataset.iterdir())):
        raise UsageError("%s is not an empty folder, and no data set. Remedy: name another --out" % dataset)
    try:
        write_whole(path, write_options(options).encode())
    except OSError as error:
        raise StoreError("%s cannot be written: %s" % (path, error)) from error


def load(dataset: Path) -> Options:
    """Returns the options of a data set that was begun by the same versions of all programs."""
    try:
        text = (dataset / PLAN).read_text(encoding="utf-8")
    except OSError as error:
        raise UsageError("%s holds no data set: %s" % (dataset, error.strerror)) from error
    options, made_by = read_options(text)
    here = versions(options)
    if here != made_by:
        other = [
            "%s %s (here %s)" % (name, made_by.get(name), here[name])
            for name in here
            if here[name] != made_by.get(name)
        ]
        raise UsageError(
            "%s was begun with %s, which may write other bytes. Remedy: install these versions"
            % (dataset, ", ".join(other))
        )
    return options


def missing(dataset: Path, options: Options) -> list[int]:
    return [shard for shard in range(options.shards) if not is_made(dataset, shard)]


# --- completion ---


def complete(dataset: Path, options: Options) -> None:
    """Makes all files that describe the whole data set. All shards must be made."""
    absent = missing(dataset, options)
    if absent:
        raise StoreError(
            "%d of %d shards are missing, the first is %d: resume" % (len(absent), options.shards, absent[0])
        )
    manifests = [read_manifest(dataset, shard) for shard in range(options.shards)]
    for manifest in manifests:
        for name in manifest["files"]:
            if "/" in name and not name.endswith(coco.ANNOTATIONS):
                _link(shard_folder(dataset, manifest["shard"]) / name, dataset / name)
    if "coco" in options.formats:
        info = {"description": "Simulated angiograms by Cournand", "contributor": "Cournand"}
        write_parts(dataset / coco.FOLDER / coco.ANNOTATIONS, coco.merged(dataset, options.shards, info))
    if "lerobot" in options.formats:
        from .formats import lerobot

        for name, content in lerobot.completed(dataset, options, manifests).items():
            write_whole(dataset / name, content)
    shards = [{key: one[key] for key in ("shard", "frames", "first_index", "attempt", "files")} for one in manifests]
    write_whole(dataset / INDEX, (json.dumps({"frames": options.frames, "shards": shards}, indent=1) + "\n").encode())
    pictures = statistics.pictures_of(dataset, manifests)
    write_whole(dataset / SHEET, pictures)
    page = statistics.page(options, manifests, pictures)
    write_whole(dataset / STATISTICS, page.encode())
    write_whole(dataset / DATASHEET, datasheet.text(options, versions(options), manifests).encode())


def _link(source: Path, target: Path) -> None:
    """Gives a file of a shard a second name: a hard link, or a relative symbolic link where the system has no hard
    links."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.exists() and os.path.samefile(source, target):
        return
    part = target.with_name(".%s.link%d" % (target.name, os.getpid()))
    part.unlink(missing_ok=True)
    try:
        os.link(source, part)
    except OSError:
        part.symlink_to(os.path.relpath(source, target.parent))
    os.replace(part, target)
    part.unlink(missing_ok=True)  # rename() leaves both names if they are already one file


# --- check ---


def faults(dataset: Path, options: Options) -> list[str]:
    """Returns a text for each defect that the check finds in the files of a data set."""
    found: list[str] = []
    for shard in range(options.shards):
        found += faults_of_shard(dataset, shard, options.frames_of(shard))
    known = {"%06d" % shard for shard in range(options.shards)}
    there = {path.name for path in (dataset / "shards").iterdir()} if (dataset / "shards").exists() else set()
    found += ["%s is no shard of the plan" % (dataset / "shards" / name) for name in sorted(there - known)]
    if not found and not (dataset / INDEX).exists():
        found.append("%s is missing: resume makes it" % (dataset / INDEX))
    return found


def differences(dataset: Path, options: Options, shard: int) -> list[str]:
    """Makes a shard again in a temporary folder, and returns the names of its files that differ from those of the data
    set."""
    if not 0 <= shard < options.shards:
        raise UsageError("--again: there is no shard %d: they are 0 to %d" % (shard, options.shards - 1))
    before = read_manifest(dataset, shard)
    folder = Path(tempfile.mkdtemp(prefix="cournand-factory-"))
    try:
        make_shard(options, folder, shard)
        after = read_manifest(folder, shard)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    names = sorted(set(before["files"]) | set(after["files"]))
    changed = [name for name in names if before["files"].get(name) != after["files"].get(name)]
    if before != after and not changed:
        changed.append(MANIFEST)
    return ["%s: shard %d made again has other bytes" % (name, shard) for name in changed]
