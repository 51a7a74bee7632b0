#!/usr/bin/python3
"""Tests the tracker of tips (docs/tracker.md): it reads the factory's files, divides them by shard, finds the places
that its targets state, and learns a few frames by heart. The frames show straight wires that the test draws itself. The
test needs PyTorch from Debian (section [tracker] of tools/packages.txt), and therefore Debian's Python. Prints TAP."""

import contextlib
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[3]
sys.path[:0] = [str(HERE.parent), str(ROOT / "tools" / "check"), str(ROOT / "host" / "python" / "tests")]
try:
    import numpy as np
    import torch
    from PIL import Image
except ImportError as error:
    sys.exit("test_tip_tracker: %s. Remedy: sudo apt-get install python3-torch python3-pil" % error)

import prepare  # noqa: E402
import tap  # noqa: E402
from tip_tracker import __main__ as program  # noqa: E402
from tip_tracker.data import DataError, contrast_at, innermost_tool, read, split  # noqa: E402
from tip_tracker.doses import ratios_of  # noqa: E402
from tip_tracker.judge import errors_of, median_interval  # noqa: E402
from tip_tracker.model import CELL, chances_of, flattened, located, target  # noqa: E402
from tip_tracker.noise import NOISE_CELL, added_factor, drawn_noise, noise_of  # noqa: E402
from tip_tracker.train import Course, example, train, turned_tip  # noqa: E402

FOLDER = tempfile.TemporaryDirectory()
SIZE = 128
torch.set_num_threads(1)


def drawn(random):
    """Returns detector values [SIZE, SIZE] with a wire that ends in the picture, the wire's mask, and its tip."""
    tip, away = random.uniform(24, SIZE - 24, 2), random.uniform(-1, 1, 2)
    away /= np.linalg.norm(away)
    rows, columns = np.mgrid[0:SIZE, 0:SIZE] + 0.5
    along = (columns - tip[0]) * away[0] + (rows - tip[1]) * away[1]
    across = (columns - tip[0]) * away[1] - (rows - tip[1]) * away[0]
    distance = np.where(along >= 0, np.abs(across), np.hypot(along, across))
    raw = 3000 * np.exp(-0.4 * np.clip(2.0 - distance, 0, 1) + 0.3 * np.sin(columns / 40))
    return random.poisson(raw).astype(np.uint16), distance < 1.0, tip


def tool(position, inserted_mm, px, visibility=2):
    tip = {"px": list(px), "mm": [0, 0, 0], "visibility": visibility}
    return {"position": position, "inserted_mm": inserted_mm, "file": "wire", "tip": tip}


def png(pixels):
    """Returns the PNG file of a picture."""
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    return file.getvalue()


def data_set(name, frames=16, shard_frames=4, seed=1, size=SIZE, is_empty=False):
    """Writes a data set of drawn wires as the factory would, and returns its folder. Every fifth tip is covered; with
    `is_empty`, all tips are outside of the picture. Below SIZE, `size` cuts the pictures."""
    folder, random = Path(FOLDER.name) / name, np.random.default_rng(seed)
    (folder / "webdataset").mkdir(parents=True)
    for shard in range(-(-frames // shard_frames)):
        with tarfile.open(folder / "webdataset" / ("%06d.tar" % shard), "w") as tar:
            for number in range(min(shard_frames, frames - shard * shard_frames)):
                raw, mask, tip = drawn(random)
                covered = 0 if is_empty else 1 if (shard * shard_frames + number) % 5 == 4 else 2
                raw, mask = raw[:size, :size], mask[:size, :size]
                facts = {"scene": "drawn", "tools": [tool(0, 90.0, tip, covered)], "dose": {"detector_nGy": 40.0}}
                files = {"json": json.dumps(facts).encode(), "labels.png": png(mask.astype(np.uint8))}
                files["raw.png"] = png(raw)
                for ending, content in files.items():
                    member = tarfile.TarInfo("%06d-%05d.%s" % (shard, number, ending))
                    member.size = len(content)
                    tar.addfile(member, io.BytesIO(content))
    return folder


def said(*words):
    """Runs a command of the program, and returns its exit code, its output, and its errors."""
    printed, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
        try:
            code = program.main([str(word) for word in words])
        except SystemExit as ended:
            code = ended.code
    return code, printed.getvalue(), errors.getvalue()


# --- data ---


def the_innermost_tool_is_the_first_in_the_patient():
    wire, catheter = tool(0, 200.0, (1, 1)), tool(1, 250.0, (2, 2))
    good = innermost_tool({"tools": [catheter, wire]}) is wire
    return good and innermost_tool({"tools": [catheter]}) is catheter and innermost_tool({"tools": []}) is None


def the_frames_read_are_those_that_were_written():
    frames, random = read(data_set("written")), np.random.default_rng(1)
    for number in range(16):
        raw, mask, tip = drawn(random)
        cells = mask.reshape(SIZE // CELL, CELL, SIZE // CELL, CELL).any(axis=(1, 3))
        flat = flattened(torch.from_numpy(raw.astype(np.float32))[None, None])[0, 0].numpy()
        worst = np.abs(np.clip(flat, -0.5, 0.5) - np.clip(frames.pictures[number] / 250.0, -0.5, 0.5)).max()
        if worst > 0.003 or not np.array_equal(frames.masks[number], cells):  # half a step is 0.002
            return False
        if not np.allclose(frames.tips[number], tip, atol=1e-4):
            return False
    return list(np.flatnonzero(frames.visible == 1)) == [4, 9, 14] and len(frames.seen()) == 13


def frames_that_were_kept_are_the_same():
    folder, keep = data_set("kept"), Path(FOLDER.name) / "kept.npz"
    first, second = read(folder, keep), read(folder, keep)
    arrays = all(np.array_equal(getattr(first, name), getattr(second, name)) for name in ("pictures", "masks", "tips"))
    return arrays and first.facts == second.facts and [one.name for one in keep.parent.glob("*.part.npz")] == []


def what_was_kept_is_not_taken_for_another_data_set():
    """Two data sets have the same name in different folders; then the first one is made again with other frames."""
    keep, folders = Path(FOLDER.name) / "taken.npz", [data_set("a/same", seed=2), data_set("b/same", seed=3)]
    read(folders[0], keep)
    good = np.array_equal(read(folders[1], keep).tips, read(folders[1]).tips)
    (folders[1] / "webdataset").rename(folders[1] / "before")
    data_set("b/same", seed=4)
    good = good and np.array_equal(read(folders[1], keep).tips, read(folders[1]).tips)
    keep.write_bytes(b"damaged")
    return good and np.array_equal(read(folders[1], keep).tips, read(folders[1]).tips)


def factory_set(name, dose_nGy):
    """Makes a small data set of the factory. The factory needs the Python of the package's tests, which has other
    packages than this one."""
    folder = Path(FOLDER.name) / name
    words = ["--frames", "6", "--shard-frames", "3", "--block-frames", "1", "--size", "128", "--tools", "j_wire"]
    words += ["--dose", str(dose_nGy), str(dose_nGy), "--offset", "0.1", "--seed", "3", "--quiet", "--out", str(folder)]
    environment = dict(os.environ, PYTHONPATH=prepare.SITE)
    subprocess.run([prepare.prepare(), "-m", "cournand.factory", *words], env=environment, check=True)
    return folder


def a_data_set_of_the_factory_is_read():
    frames = read(factory_set("factory", 100))
    middle = np.abs(frames.tips / 128 - 0.5).max(axis=1)
    print("# tips at most %.3f of the field from the middle" % middle.max())
    on_tool = [frames.masks[k][int(tip[1]) // CELL, int(tip[0]) // CELL] for k, tip in enumerate(frames.tips)]
    return len(frames) == 6 and all(on_tool) and {one["dose_nGy"] for one in frames.facts} == {100.0}


def the_noise_of_the_factory_has_a_square_inverse_to_the_dose():
    """A pixel of these small pictures has 16 times the quanta of one in pictures of 512 × 512 pixels. Steep edges of
    bones add to the second differences, and they count for more at the higher dose."""
    low, high = (read(factory_set("factory-%d" % dose, dose)).noise for dose in (1, 4))
    ratios = low / high / np.sqrt(4 / 1)
    print("# %.3f of the rule, from %.3f to %.3f" % (np.median(ratios), ratios.min(), ratios.max()))
    return abs(float(np.median(ratios)) - 1) < 0.15  # measured 0.049


def a_shard_is_either_learned_or_watched():
    frames = read(data_set("split", 40))
    learned, watched = split(frames, 0.3, seed=5)
    again = split(frames, 0.3, seed=5)
    shards = [{frames.facts[k]["key"][:6] for k in part} for part in (learned, watched)]
    good = np.array_equal(learned, again[0]) and np.array_equal(watched, again[1])
    good = good and not np.array_equal(watched, split(frames, 0.3, seed=6)[1])
    return good and not shards[0] & shards[1] and len(shards[1]) == 3 and len(learned) + len(watched) == 40


def what_cannot_be_read_is_refused_with_a_remedy():
    folder, good = data_set("damaged"), True
    with open(folder / "webdataset" / "000001.tar", "r+b") as file:
        file.truncate(700)
    empty = Path(FOLDER.name) / "empty"
    for where, name in ((folder, "000001"), (empty, "has no webdataset")):
        code, _, errors = said("train", where, "--out", Path(FOLDER.name) / "none")
        good = good and code == 1 and name in errors and "Remedy" in errors
    code, _, errors = said("judge", empty, "x=%s" % folder, "--out", Path(FOLDER.name) / "none")
    good = good and code == 1 and "Remedy" in errors
    empty.mkdir()
    (empty / "tracker.pt").write_bytes(b"no tracker")
    code, _, errors = said("judge", empty, "x=%s" % folder, "--out", empty)
    good = good and code == 1 and "has no tracker" in errors
    (empty / "tracker.pt").write_bytes(b"")
    code, _, errors = said("judge", empty, "x=%s" % folder, "--out", empty)
    good = good and code == 1 and "has no tracker" in errors
    code, _, errors = said("train", data_set("narrow", size=96), "--out", Path(FOLDER.name) / "none")
    good = good and code == 1 and "a multiple of 64" in errors
    return good and said("judge", empty, "x", "--out", empty)[0] == 2 and said("learn")[0] == 2


def numbers_that_make_no_sense_are_refused():
    words = ["train", "data", "--out", str(Path(FOLDER.name) / "none")]
    for more in (
        ("--threads", 0),
        ("--crop-epochs", -1),
        ("--crop-epochs", 0, "--whole-epochs", 0),
        ("--rate", 0),
        ("--rate", "nan"),
    ):
        if said(*words, *more)[0] != 2:
            return False
    return True


def a_set_without_tips_is_refused():
    out = Path(FOLDER.name) / "some"
    good = said("train", data_set("some-tips"), "--out", out, "--crop-epochs", 0, "--whole-epochs", 1)[0] == 0
    code, _, errors = said("judge", out, "none=%s" % data_set("no-tips", is_empty=True), "--out", out)
    return good and code == 1 and "no frame with a tip" in errors


# --- noise ---


def the_deviation_of_drawn_noise_is_found():
    """White noise, and noise that neighbours share, in a picture with an edge of bone and a thin wire."""
    rows, columns = torch.meshgrid(torch.arange(256.0), torch.arange(256.0), indexing="ij")
    body = 0.3 * (columns > 130).float() - 0.2 * ((rows - 0.7 * columns).abs() < 1.5).float()
    deviations = 0.05 + 0.05 * (rows >= 128).float()
    torch.manual_seed(1)
    worst = 0.0
    for share in (0.0, 0.1, 0.2):
        found = noise_of((body + drawn_noise(deviations, share))[None])[0]
        part = found / deviations[NOISE_CELL // 2 :: NOISE_CELL, NOISE_CELL // 2 :: NOISE_CELL] - 1
        worst = max(worst, abs(float(part.mean())))
    print("# at most %.3f off" % worst)
    return worst < 0.06  # measured 0.02


def the_noise_of_a_lower_dose_is_that_of_fewer_quanta():
    """Poisson counts of a fourth of the quanta are the reference for noise added to the logarithm of all quanta. The
    place is measured as well: a half of the picture has a third of the quanta."""
    random = np.random.default_rng(1)
    quanta = np.where(np.arange(256) < 128, 1200.0, 400.0) * np.ones((256, 1))
    many, few = (torch.from_numpy(np.log(random.poisson(quanta / part))).float()[None] for part in (1, 4))
    at_each = torch.kron(noise_of(many)[0], torch.ones(NOISE_CELL, NOISE_CELL))
    torch.manual_seed(1)
    made = noise_of(many + np.sqrt(4 - 1) * drawn_noise(at_each, 0.0))[0]
    off = (made / noise_of(few)[0] - 1).reshape(8, 2, 4).mean(dim=(0, 2))
    print("# %.3f and %.3f off" % tuple(off))
    return float(off.abs().max()) < 0.05  # measured 0.015


def the_dose_that_is_drawn_lies_between_its_limits():
    random = np.random.default_rng(1)
    doses = 80.0 / (1 + np.array([added_factor(80.0, 5.0, random) for _ in range(2000)]) ** 2)
    middle = float(np.median(doses))
    print("# from %.2f to %.2f nGy, median %.1f nGy" % (doses.min(), doses.max(), middle))
    good = doses.min() >= 5.0 and doses.max() <= 80.0 and abs(middle / 20.0 - 1) < 0.15  # 20 = sqrt(5 * 80)
    return good and added_factor(4.0, 5.0, random) == 0.0


def the_contrast_of_a_tool_is_measured_beside_it():
    flat, is_tool = np.full((64, 64), 0.1), np.zeros((64, 64), bool)
    is_tool[30:33, :40] = True
    flat[is_tool] = -0.2
    flat[:, 60:] = 9.0  # too far away
    good = abs(contrast_at(flat, is_tool, (39.5, 31.5)) - 0.3) < 1e-12
    return good and np.isnan(contrast_at(flat, is_tool, (5.0, 5.0)))


def the_contrast_to_noise_falls_with_the_root_of_the_dose():
    frames = read(data_set("ratios"))
    ratios = ratios_of(frames)
    frames.noise = frames.noise * 2
    print("# contrast to noise %.1f to %.1f" % (ratios.min(), ratios.max()))
    # The wire lets exp(-0.4) of some 3000 quanta pass at its middle, half as much of the contrast at its edges.
    return np.allclose(ratios_of(frames), ratios / 2) and 5 < np.median(ratios) < 0.4 * np.sqrt(4000)


# --- geometry ---


def flattening_removes_the_dose():
    """A factor on the detector's values adds a constant to their logarithm, which the local mean removes."""
    raw = torch.rand(1, 1, 128, 128) * 1000 + 500
    raw[..., :9] = 3.0  # a blade of the collimator
    worst = float((flattened(raw) - flattened(3 * raw)).abs().max())
    print("# at most %.1e apart" % worst)
    return worst < 9e-6  # measured 2.9e-6: rounding of float32


def the_place_found_is_that_of_the_target():
    """The mean of a Gaussian over whole cells is its middle; the window cuts its edges off."""
    tips = torch.rand(200, 2) * 100 + 14
    places, inside = located(target(tips, 32)[:, :-1].reshape(200, 32, 32))
    worst = float(torch.linalg.norm(places - tips, dim=1).max())
    print("# at most %.3f px" % worst)
    return worst < 0.7 and float(inside.min()) > 0.9  # measured 0.24: half a cell off, 1.2 % of the mass is cut off


class Darkest(torch.nn.Module):
    """Stands for a tracker: its score is high where a cell is dark, and where the cell above is, which is no symmetry
    of the square."""

    def forward(self, flat):
        dark = -40 * torch.nn.functional.avg_pool2d(flat, CELL)
        return torch.cat([dark + 0.2 * dark.roll(1, 2), dark], dim=1)


def a_turned_picture_has_a_turned_distribution():
    flat = torch.randn(2, 1, 64, 64)
    chances = chances_of(Darkest(), flat)
    worst = float((chances_of(Darkest(), torch.rot90(flat, 1, (2, 3))) - torch.rot90(chances, 1, (1, 2))).abs().max())
    flipped = float((chances_of(Darkest(), flat.flip(3)) - chances.flip(2)).abs().max())
    single = torch.zeros(1, 1, 64, 64)
    single[0, 0, 8:12, 40:44] = -1.0
    best = int(chances_of(Darkest(), single).flatten().argmax())
    print("# at most %.1e apart" % max(worst, flipped))
    return max(worst, flipped) < 1e-6 and best == 2 * 16 + 10 and abs(float(chances[0].sum()) - 1) < 1e-5


def a_tip_turns_with_its_picture():
    for turns in range(4):
        for is_flipped in (False, True):
            picture = np.zeros((64, 64))
            picture[10, 30] = 1.0
            turned = np.rot90(picture, turns)
            turned = turned[:, ::-1] if is_flipped else turned
            row, column = np.argwhere(turned == 1.0)[0]
            if not np.allclose(turned_tip(np.array([30.5, 10.5]), 64, turns, is_flipped), [column + 0.5, row + 0.5]):
                return False
    return True


def a_crop_has_the_mask_at_its_tip_or_has_no_tip():
    frames, random = read(data_set("crops")), np.random.default_rng(2)
    inside = 0
    for number in range(16):
        for _ in range(10):
            flat, tip, mask = example(frames, number, 64, Course(), random)
            is_inside = bool((tip >= 0).all() and (tip < 64).all())
            wanted = target(tip[None], 16)[0]
            good = flat.shape == (1, 64, 64) and mask.shape == (16, 16) and float(wanted[-1]) == 1 - is_inside
            if not good or (is_inside and mask[int(tip[1]) // CELL, int(tip[0]) // CELL] != 1):
                return False
            inside += is_inside
    print("# %d of 160 crops have a tip" % inside)
    return 112 <= inside < 160


# --- learning ---


def it_learns_sixteen_frames_by_heart():
    frames = read(data_set("heart", 20)).seen()
    course = Course(crop_epochs=0, whole_epochs=60, is_changed=False)
    tracker, rows = train(frames, None, course)
    errors, sums, _ = errors_of(tracker, frames)
    print("# %d frames: median %.2f px, largest %.2f px" % (len(frames), np.median(errors), errors.max()))
    return len(frames) == 16 and errors.max() < 1.0 and sums.min() > 0.5 and rows[-1][3] < rows[0][3]


def the_same_seed_gives_the_same_tracker():
    frames = read(data_set("seed")).seen()
    states = []
    for seed in (1, 1, 2):
        tracker, _ = train(frames, None, Course(1, 1, crop=64, batch=4, seed=seed))
        states.append(torch.cat([one.flatten().float() for one in tracker.state_dict().values()]))
    return torch.equal(states[0], states[1]) and not torch.equal(states[0], states[2])


def the_interval_of_a_median_comes_from_whole_shards():
    """Ten shards of ten equal errors: the median of 100 numbers is that of 10, and its interval is as wide as for 10
    independent numbers: between the second and the ninth of them (binomial distribution: 97.9 %)."""
    errors = np.repeat(np.arange(10.0), 10)
    low, high = median_interval(errors, ["%d" % (k // 10) for k in range(100)])
    alone = median_interval(np.tile(np.arange(10.0), 10), ["%d" % (k // 10) for k in range(100)])
    print("# %.2f to %.2f; equal shards: %.2f to %.2f" % (low, high, *alone))
    return 1.0 <= low <= 2.5 and 6.5 <= high <= 8.0 and alone == (4.5, 4.5)


def the_doses_are_compared_in_equal_courses():
    out = Path(FOLDER.name) / "doses"
    data = data_set("dosed", 20)
    good = said("train", data, "--out", out, "--crop-epochs", 0, "--whole-epochs", 1)[0] == 0
    code, text, _ = said("doses", out, "40=%s" % data, "20=%s" % data, "--out", out)
    first, second = (line.split("\t") for line in (out / "doses.tsv").read_text().splitlines()[1:])
    good = good and code == 0 and text.startswith("dose_nGy\tclear\tmedian_px")
    good = good and (first[0], second[0]) == ("20", "40") and first[1:] == second[1:] and first[1] == "16"
    tips = [int(line.split("\t")[2]) for line in (out / "contrast.tsv").read_text().splitlines()[1:]]
    good = good and sum(tips) == 32 and Image.open(out / "doses.png").size[0] > 2 * 150
    return good and said("doses", out, "dark=%s" % data, "--out", out)[0] == 2


def the_commands_train_and_judge():
    folder, out = data_set("whole", 40), Path(FOLDER.name) / "out"
    code, text, _ = said("train", folder, "--out", out, "--crop-epochs", 1, "--whole-epochs", 2)
    good = code == 0 and "40 frames" in text and len((out / "curve.tsv").read_text().splitlines()) == 4
    more = said("train", folder, "--from", out, "--out", out, "--crop-epochs", 0, "--whole-epochs", 1)
    good = good and more[0] == 0 and len((out / "curve.tsv").read_text().splitlines()) == 2
    code, text, _ = said("judge", out, "same=%s" % folder, "--out", out)
    names, *rows = (line.split("\t") for line in text.splitlines())
    good = good and code == 0 and names[:3] == ["set", "inside", "clear"] and rows[0][1:] == rows[1][1:]
    good = good and [row[:3] for row in rows] == [["same", "40", "32"], ["same wire", "40", "32"]]
    figure = (out / "figures.tsv").read_text().split("\t")
    good = good and figure == ["tracker.median_px", rows[0][3], "px", "set=same\n"]
    return good and Image.open(out / "same.png").size == (4 * 260, 3 * 260)


if __name__ == "__main__":
    tap.run(
        [
            the_innermost_tool_is_the_first_in_the_patient,
            the_frames_read_are_those_that_were_written,
            frames_that_were_kept_are_the_same,
            what_was_kept_is_not_taken_for_another_data_set,
            a_data_set_of_the_factory_is_read,
            the_noise_of_the_factory_has_a_square_inverse_to_the_dose,
            a_shard_is_either_learned_or_watched,
            what_cannot_be_read_is_refused_with_a_remedy,
            numbers_that_make_no_sense_are_refused,
            a_set_without_tips_is_refused,
            the_deviation_of_drawn_noise_is_found,
            the_noise_of_a_lower_dose_is_that_of_fewer_quanta,
            the_dose_that_is_drawn_lies_between_its_limits,
            the_contrast_of_a_tool_is_measured_beside_it,
            the_contrast_to_noise_falls_with_the_root_of_the_dose,
            flattening_removes_the_dose,
            the_place_found_is_that_of_the_target,
            a_turned_picture_has_a_turned_distribution,
            a_tip_turns_with_its_picture,
            a_crop_has_the_mask_at_its_tip_or_has_no_tip,
            it_learns_sixteen_frames_by_heart,
            the_same_seed_gives_the_same_tracker,
            the_interval_of_a_median_comes_from_whole_shards,
            the_doses_are_compared_in_equal_courses,
            the_commands_train_and_judge,
        ]
    )
