"""Stores shards on the disk so that each shard appears complete or not at all.

A shard is first written into its own folder below `parts`. When it is complete, its files and its manifest are synced
to the disk, and the folder gets its final name below `shards`. A killed run therefore leaves only folders below
`parts`, which the next run removes, and a shard that has its name is complete.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

SHARDS, PARTS, MANIFEST = "shards", "parts", "manifest.json"


class StoreError(Exception):
    """A data set on the disk is not as it must be; the message names the file, the defect and the remedy."""


def write_whole(path: Path, content: bytes) -> None:
    """Writes a file that appears under its name only when it is complete."""
    write_parts(path, (content,))


def write_parts(path: Path, parts: Iterable[bytes]) -> None:
    """Writes a file that appears under its name only when it is complete; the file may be larger than the memory."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(".%s.part%d" % (path.name, os.getpid()))
    try:
        with open(part, "wb") as file:
            for content in parts:
                file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
    _sync_folder(path.parent)


def _sync_folder(folder: Path) -> None:
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


class HashedFile:
    """A file that is written once, from its beginning to its end, while its size and its hash are computed."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file: BinaryIO = open(path, "wb")
        self._hash = hashlib.sha256()
        self.bytes = 0

    def write(self, content: bytes) -> int:
        self._hash.update(content)
        self.bytes += len(content)
        return self._file.write(content)

    def close(self) -> str:
        """Syncs the file to the disk, and returns its hash."""
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()
        return self._hash.hexdigest()

    def abandon(self) -> None:
        self._file.close()


class ShardFolder:
    """The folder of a shard during the writing of the shard."""

    def __init__(self, dataset: Path, shard: int) -> None:
        self._dataset, self.shard = dataset, shard
        self._final = shard_folder(dataset, shard)
        self.folder = dataset / PARTS / ("%06d-%d" % (shard, os.getpid()))
        self._files: dict[str, HashedFile] = {}
        self._closed: dict[str, dict[str, Any]] = {}

    def __enter__(self) -> ShardFolder:
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for file in self._files.values():
            file.abandon()
        shutil.rmtree(self.folder, ignore_errors=True)

    def open(self, name: str) -> HashedFile:
        """Opens a file of the shard; `path` is relative to the shard's folder."""
        self._files[name] = HashedFile(self.folder / name)
        return self._files[name]

    def close(self, name: str) -> None:
        file = self._files.pop(name)
        self._closed[name] = {"bytes": file.bytes, "sha256": file.close()}

    def put(self, name: str, content: bytes) -> None:
        """Writes a whole file of the shard."""
        self.open(name).write(content)
        self.close(name)

    def publish(self, facts: dict[str, Any]) -> None:
        """Closes all files, writes the manifest, and gives the shard's folder its final name."""
        for name in list(self._files):
            self.close(name)
        files = {name: self._closed[name] for name in sorted(self._closed)}
        manifest = json.dumps({**facts, "files": files}, sort_keys=True) + "\n"
        write_whole(self.folder / MANIFEST, manifest.encode())
        for folder, _, _ in os.walk(self.folder):
            _sync_folder(Path(folder))
        self._final.parent.mkdir(parents=True, exist_ok=True)
        try:
            os.rename(self.folder, self._final)
        except OSError:
            if not is_made(self._dataset, self.shard):
                raise
        _sync_folder(self._final.parent)


def shard_folder(dataset: Path, shard: int) -> Path:
    return dataset / SHARDS / ("%06d" % shard)


def is_made(dataset: Path, shard: int) -> bool:
    return (shard_folder(dataset, shard) / MANIFEST).exists()


def read_manifest(dataset: Path, shard: int) -> dict[str, Any]:
    path = shard_folder(dataset, shard) / MANIFEST
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise StoreError("%s cannot be read: %s. Remedy: delete its folder, then resume" % (path, error)) from error
    if not isinstance(manifest, dict) or "files" not in manifest:
        raise StoreError("%s is damaged. Remedy: delete its folder, then resume" % path)
    return manifest


def faults_of_shard(dataset: Path, shard: int, frames: int) -> list[str]:
    """Returns a text for each defect of a shard: a missing, changed or additional file, or a wrong number of frames."""
    folder = shard_folder(dataset, shard)
    if not folder.exists():
        return ["%s is missing: resume makes it" % folder]
    try:
        manifest = read_manifest(dataset, shard)
    except StoreError as error:
        return [str(error)]
    faults = []
    if manifest.get("frames") != frames:
        faults.append("%s has %r frames, and the plan has %d" % (folder, manifest.get("frames"), frames))
    there = {str(one.relative_to(folder)) for one in folder.rglob("*") if one.is_file()} - {MANIFEST}
    known = set(manifest["files"])
    faults += ["%s is not in the manifest" % (folder / name) for name in sorted(there - known)]
    faults += ["%s is missing" % (folder / name) for name in sorted(known - there)]
    for name in sorted(known & there):
        if hash_file(folder / name) != manifest["files"][name]["sha256"]:
            faults.append("%s has changed since it was written" % (folder / name))
    return faults


def hash_file(path: Path) -> str:
    hashed = hashlib.sha256()
    with open(path, "rb") as file:
        while part := file.read(1 << 20):
            hashed.update(part)
    return hashed.hexdigest()


def remove_parts(dataset: Path, shards: list[int]) -> None:
    """Removes the unfinished folders that a killed run has left for these shards."""
    folder = dataset / PARTS
    wanted = {"%06d" % shard for shard in shards}
    for path in folder.glob("*-*") if folder.exists() else ():
        if path.name.partition("-")[0] in wanted:
            shutil.rmtree(path, ignore_errors=True)


@contextmanager
def only_run(dataset: Path, name: str) -> Iterator[None]:
    """Refuses a second run that makes the same shards at the same time. If a process ends, the operating system
    releases the lock of this process."""
    (dataset / PARTS).mkdir(parents=True, exist_ok=True)
    with open(dataset / PARTS / (name + ".lock"), "w", encoding="ascii") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise StoreError("another run is at work in %s. Remedy: wait for its end, or stop it" % dataset) from error
        yield
