"""Makes random anatomies for tasks: scenes of different patients, each from its own seed.

    python -m cournand.anatomies --count 8 --first 0 --out anatomies
    python -m cournand.anatomies --task iliac --split judge --out anatomies
    python -m cournand.anatomies --count 3 --bodies --out anatomies
    python -m cournand.anatomies --count 3 --kind heart --out anatomies

A scene of the kind `aorta` has drawn arteries from the groins to the arch; a scene of the kind `heart` has drawn
coronary arteries on the shipped heart, which beats. To make a scene, the programs `anatomy` and `bake` are needed, and
about 20 s of processor time (a minute for a heart), or a minute more with `--bodies`. Without `--bodies`, X-ray
pictures show the tools and the contrast medium alone. An existing scene is not made again, so the same command
continues after an interruption.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from .errors import BadFileError

SEED_MAX = 2**32 - 1
PROGRAMS = ("anatomy", "bake")
KINDS = ("aorta", "heart")
# The report of `bake` compares the scene with its mesh at many points, which a drawn scene does not need each time.
SHORT_REPORT = ("--poses", "0", "--points", "100")


def path_of(folder: str | os.PathLike[str], seed: int, *, kind: str = "aorta", bodies: bool = False) -> Path:
    """Returns the path of the scene of a kind and a seed, whether the scene exists or not."""
    return Path(folder) / ("%s-%d%s.scene" % (kind, seed, "-bodies" if bodies else ""))


def find_programs(given: str | os.PathLike[str] | None = None) -> tuple[str, str]:
    """Returns the paths of `anatomy` and `bake`: in the folder `given`, else in $COURNAND_PROGRAMS, in build/bin of the
    current folder, and in PATH."""
    own = os.environ.get("COURNAND_PROGRAMS")
    folders = [os.fspath(given)] if given is not None else ([own] if own else []) + [os.path.join("build", "bin")]
    found = []
    for name in PROGRAMS:
        path = shutil.which(name, path=os.pathsep.join(os.path.abspath(folder) for folder in folders))
        path = path or (shutil.which(name) if given is None else None)
        if path is None:
            where = os.fspath(given) if given is not None else "COURNAND_PROGRAMS, build/bin or PATH"
            raise BadFileError(
                "no program '%s' in %s. Remedy: build it (make install), or name its folder: --programs FOLDER"
                % (name, where)
            )
        found.append(path)
    return found[0], found[1]


def make(
    seeds: Sequence[int],
    folder: str | os.PathLike[str],
    *,
    kind: str = "aorta",
    workers: int = 1,
    programs: str | os.PathLike[str] | None = None,
    bodies: bool = False,
) -> Iterator[tuple[int, bool]]:
    """Makes the scenes of the given seeds; yields each seed, and True if its scene is new. A scene gets its final name
    only when it is complete. With `bodies`, the scenes also have bones, lungs, heart, belly and skin for pictures."""
    for seed in seeds:
        if not 0 <= seed <= SEED_MAX:
            raise ValueError("the seed %d of an anatomy is not within 0 and %d" % (seed, SEED_MAX))
    if workers < 1:
        raise ValueError("workers: %d is less than 1" % workers)
    if kind not in KINDS:
        raise ValueError("kind: %r is not one of %s" % (kind, ", ".join(KINDS)))
    wanted = list(dict.fromkeys(seeds))
    missing = [seed for seed in wanted if not path_of(folder, seed, kind=kind, bodies=bodies).exists()]
    for seed in wanted:
        if seed not in missing:
            yield seed, False
    if not missing:
        return
    found = find_programs(programs)
    os.makedirs(folder, exist_ok=True)
    with ThreadPoolExecutor(workers) as pool:  # each thread waits for the processes of one scene
        running = {}
        for seed in missing:
            final = path_of(folder, seed, kind=kind, bodies=bodies)
            running[pool.submit(_make_one, found, final, kind, seed, bodies)] = seed
        try:
            for done in as_completed(running):
                done.result()
                yield running[done], True
        finally:
            for other in running:
                other.cancel()


def _make_one(programs: tuple[str, str], final: Path, kind: str, seed: int, bodies: bool) -> None:
    with tempfile.TemporaryDirectory(prefix=".making-%d-" % seed, dir=final.parent) as work:
        baked = os.path.join(work, final.name)
        drawn = os.path.join(work, "drawn")
        without = [] if bodies else ["--no-bodies"]
        _call([programs[0], kind, "--seed", str(seed), *without, "--quiet", "-o", drawn])
        _call([programs[1], os.path.join(drawn, "scene.toml"), "-o", baked, *SHORT_REPORT])
        for ending in (".bodies", ".scene"):  # the scene last: it is what says that both exist
            made = final.with_suffix(ending).name
            os.replace(os.path.join(work, made), final.with_name(made))


def _call(words: Sequence[str]) -> None:
    ended = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if ended.returncode != 0:
        raise BadFileError(
            "`%s` ended with exit code %d: %s" % (" ".join(words), ended.returncode, ended.stdout[-800:])
        )


def need(folder: str | os.PathLike[str], seeds: Sequence[int], command: str, *, kind: str = "aorta") -> None:
    """If scenes of the given seeds do not exist, raises BadFileError with the command that makes them."""
    missing = [seed for seed in dict.fromkeys(seeds) if not path_of(folder, seed, kind=kind).exists()]
    if missing:
        raise BadFileError(
            "%s does not exist, nor %d other scenes. Remedy: %s"
            % (path_of(folder, missing[0], kind=kind), len(missing) - 1, command)
        )


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    from .tasks.catalogue import CHALLENGES, SPLITS

    parser = argparse.ArgumentParser(
        prog="python -m cournand.anatomies",
        description="Makes drawn anatomies as scenes DIR/KIND-SEED.scene. Scenes that exist are kept.",
        epilog="Exit codes: 0 all scenes exist, 1 a scene could not be made, 2 usage.",
    )
    parser.add_argument("--count", type=int, default=8, metavar="N", help="number of scenes (default 8)")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="seed of the first one (default 0)")
    parser.add_argument("--kind", choices=KINDS, default="aorta", help="what is drawn (default aorta)")
    parser.add_argument("--task", choices=list(CHALLENGES), help="make what a task needs, in place of --count")
    parser.add_argument("--split", choices=SPLITS, help="only the anatomies of training, or of judging")
    parser.add_argument("--episodes", type=int, default=100, metavar="N", help="of the task (default 100)")
    parser.add_argument("--out", default="anatomies", metavar="DIR", help="folder of the scenes (default anatomies)")
    parser.add_argument("--bodies", action="store_true", help="with bones and organs: DIR/KIND-SEED-bodies.scene")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, metavar="N", help="scenes at a time")
    parser.add_argument("--programs", metavar="DIR", help="folder of the programs `anatomy` and `bake`")
    given = parser.parse_args(words)
    if given.count < 1 or given.episodes < 1 or given.workers < 1:
        parser.error("--count, --episodes and --workers are at least 1")
    if given.task is not None and given.bodies:
        parser.error("--bodies does not go with --task: tasks have no pictures of bones and organs")
    if given.task is not None and given.kind != "aorta":
        parser.error("--kind does not go with --task: a task decides what is drawn")
    if given.task is None and given.split is not None:
        parser.error("--split belongs to --task")
    if given.task is None and not 0 <= given.first <= SEED_MAX - given.count + 1:
        parser.error("--first: the seeds are not within 0 and %d" % SEED_MAX)
    return given


def main(words: Sequence[str] | None = None) -> int:
    from .tasks.catalogue import SPLITS, challenge_of

    given = _arguments(words)
    seeds = list(range(given.first, given.first + given.count))
    kind: str = given.kind
    if given.task is not None:
        challenge = challenge_of(given.task)
        splits, kind = [given.split] if given.split else list(SPLITS), challenge.kind
        seeds = [seed for split in splits for seed in challenge.anatomies(split, given.episodes)]
    try:
        made = make(seeds, given.out, kind=kind, workers=given.workers, programs=given.programs, bodies=given.bodies)
        for number, (seed, is_new) in enumerate(made):
            path, note = path_of(given.out, seed, kind=kind, bodies=given.bodies), "made" if is_new else "exists"
            print("%d/%d  %s  %s" % (number + 1, len(set(seeds)), path, note), flush=True)
    except (OSError, ValueError) as error:
        print("anatomies: %s" % error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
