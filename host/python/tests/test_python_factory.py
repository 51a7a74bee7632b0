#!/usr/bin/env python3
"""Tests the factory of labelled pictures (docs/factory.md): its bytes do not depend on workers, parts or kills; its
labels agree with the geometry; readers that share no code with the writers can read its files; wrong options are
refused by name. Prints TAP."""

import io
import json
import os
import shutil
import struct
import subprocess
import sys
import tarfile
import tempfile
import zlib
from dataclasses import replace

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import cournand  # noqa: E402
import factory_runs as runs  # noqa: E402
import numpy as np  # noqa: E402
from cournand.factory import Course, Options, UsageError, plan_shard, png  # noqa: E402
from cournand.factory.formats.coco import annotations_of  # noqa: E402
from cournand.factory.formats.webdataset import header  # noqa: E402
from cournand.factory.frame import CLEAR, OUTSIDE, areas_of  # noqa: E402
from cournand.factory.options import VARIATION, varied  # noqa: E402
from cournand.factory.plan import ATTEMPTS, AS_SHIPPED  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402

FOLDER = tempfile.TemporaryDirectory()
WHOLE = os.path.join(FOLDER.name, "whole")
KILLS = 3


def folder(name):
    return os.path.join(FOLDER.name, name)


def a_run_writes_a_checked_data_set():
    good = runs.made(WHOLE, *runs.SMALL, *runs.FORMATS)
    code, text, _ = runs.factory("check", WHOLE, "--again", "1")
    names = {"plan.json", "index.json", "datasheet.md", "statistics.html", "contact_sheet.png"}
    return good and code == 0 and "10 frames in 3 shards" in text and names <= set(os.listdir(WHOLE))


def two_workers_write_the_bytes_of_one():
    words = [*runs.SMALL, *runs.FORMATS, "--out", folder("two"), "--workers", "2", "--quiet"]
    return runs.run_command(*words) == 0 and runs.equal(WHOLE, folder("two"))


def parts_of_several_machines_write_the_bytes_of_one():
    at = folder("parts")
    good = runs.made(at, *runs.SMALL, *runs.FORMATS, "--shards", "1/2")
    good = good and not os.path.exists(os.path.join(at, "index.json"))
    return good and runs.factory("resume", at, "--shards", "0/2")[0] == 0 and runs.equal(WHOLE, at)


def a_run_that_is_killed_continues_without_a_lost_or_double_frame():
    return runs.survives_kills(folder("killed"), WHOLE, [*runs.SMALL, *runs.FORMATS], KILLS, seed=7)


def a_shard_does_not_depend_on_the_number_of_frames():
    at = folder("long")
    words = [word if word != "10" else "13" for word in runs.SMALL]
    good = runs.made(at, *words, "--shards", "1/4")
    shard = "shards/000001/webdataset/000001.tar"
    with open(os.path.join(at, shard), "rb") as one, open(os.path.join(WHOLE, shard), "rb") as other:
        return good and one.read() == other.read()


def what_is_damaged_is_found_and_made_again():
    at = folder("damaged")
    shutil.copytree(WHOLE, at)  # copies have no second name, so the format's folder keeps the good file
    with open(os.path.join(at, "shards", "000001", "webdataset", "000001.tar"), "r+b") as file:
        file.seek(5000)
        file.write(b"\xff")
    open(os.path.join(at, "shards", "000002", "more"), "w", encoding="ascii").close()
    code, _, errors = runs.factory("check", at)
    good = code == 1 and "000001.tar has changed" in errors and "more is not in the manifest" in errors
    for shard in ("000001", "000002"):
        shutil.rmtree(os.path.join(at, "shards", shard))
    good = good and "is missing: resume" in runs.factory("check", at)[2]
    return good and runs.factory("resume", at)[0] == 0 and runs.equal(WHOLE, at)


def the_same_command_again_makes_nothing_and_other_options_are_refused():
    before = runs.contents(WHOLE)
    good = runs.made(WHOLE, *runs.SMALL, *runs.FORMATS) and runs.contents(WHOLE) == before
    code, _, errors = runs.factory(*runs.SMALL, "--out", WHOLE, "--pulses", "30")
    return good and code == 2 and "other options" in errors and runs.contents(WHOLE) == before


# --- labels ---


def frames(count=5, **more):
    """Yields the frames of several shards with different tools."""
    options = Options(**{**dict(frames=4 * count, seed=5, shard_frames=4, block_frames=2, size=256), **more})
    for shard in range(count):
        for attempt in range(ATTEMPTS):
            try:
                yield from Course(options, plan_shard(options, shard, attempt)).frames()
                break
            except RuntimeError:  # the core refuses these factors
                continue


def touches(mask, column, row):
    """Returns whether a pixel of the mask has its centre within 0.75 pixels, half a pixel's diagonal. The end of a
    thin wire covers the centre of one of the pixels that meet there, and not always of the one that it lies in."""
    rows, columns = np.nonzero(mask)
    return np.hypot(columns + 0.5 - column, rows + 0.5 - row).min() < 0.75


def tips_and_centrelines_lie_in_the_masks_of_their_tools():
    good, tips, points = True, 0, 0
    for frame in frames():
        for tool in frame.tools:
            mask = (frame.labels >> tool.position) & 1
            if tool.tip.visibility != OUTSIDE:
                good = good and touches(mask, *tool.tip.px)
                tips += 1
            seen = tool.centreline[(tool.centreline[:, 7] != OUTSIDE) & (tool.centreline[:, 1] > 0)]
            good = good and mask[seen[:, 6].astype(int), seen[:, 5].astype(int)].all()
            good = good and (np.diff(tool.centreline[:, 1]) >= 0).all() and tool.centreline[0, 1] == 0
            points += len(seen)
    print("# %d tips, %d points of centrelines" % (tips, points))
    return good and tips > 15 and points > 300


def a_point_is_clear_only_where_its_tool_is_alone():
    seen = set()
    for frame in frames(3, tools=("coronary_014+guide_jr4_6f", "beacon_5f")):
        for tool in frame.tools:
            for column, row, kind in tool.centreline[:, 5:8]:
                is_inside = 0 <= column < 256 and 0 <= row < 256
                bits = frame.labels[int(row), int(column)] if is_inside else 0
                expected = OUTSIDE if not is_inside else CLEAR if bits == 1 << tool.position else 1
                seen.add(expected)
                if kind != expected:
                    print("# (%.1f, %.1f): %d, expected %d" % (column, row, kind, expected))
                    return False
    return seen == {OUTSIDE, 1, CLEAR}


def the_projection_in_the_file_gives_the_pixels_in_the_file():
    worst = 0.0
    for facts, members in read_tar(0):
        matrix = np.array(facts["projection"])
        lines = np.load(io.BytesIO(members["centrelines.npy"])).astype(np.float64)
        scaled = np.column_stack([lines[:, 2:5], np.ones(len(lines))]) @ matrix.T
        worst = max(worst, np.abs(scaled[:, :2] / scaled[:, 2:] - lines[:, 5:7]).max())
    print("# at most %.5f pixels apart" % worst)
    return worst < 5e-5  # measured 1.2e-5: the file has 24 bits


def medium_balloon_and_stent_appear_in_their_masks():
    most, phases = {"MEDIUM": 0, "STENT": 0, "BALLOON": 0}, set()
    tools = ("pigtail_5f", "rosen+balloon_6x20@renal_6_0x18")
    for frame in frames(3, tools=tools, block_frames=2, shard_frames=12, frames=36, size=128):
        phases.add(frame.facts["contrast_phase"])
        for name in most:
            most[name] = max(most[name], frame.areas[name])
        if frame.facts["contrast_phase"] == "none" and frame.areas["MEDIUM"]:
            return False
    print("# pixels: %s; phases: %s" % (most, ", ".join(sorted(phases))))
    return all(area > 20 for area in most.values()) and {"none", "injection"} <= phases


def marker_bands_lie_on_the_balloon():
    found = 0
    for frame in frames(2, tools=("rosen+balloon_6x20",)):
        balloon = frame.tools[1]
        for marker, expected_mm in zip(balloon.markers, (8.5, 27.5)):
            away = np.linalg.norm(np.array(marker.mm) - np.array(balloon.tip.mm))
            if not 0.9 * expected_mm <= away <= expected_mm + 0.01:  # along the bent catheter
                return False
            found += 1
    return found > 10


def a_refused_set_of_tools_is_drawn_again():
    options = Options(frames=8, shard_frames=4, seed=3, tools=("coronary_014",))
    plans = [plan_shard(options, 1, attempt) for attempt in (0, 1, AS_SHIPPED)]
    good = plans[0].factors != plans[1].factors and plans[0].tools == plans[1].tools
    return good and set(plans[2].factors[0].values()) == {1.0} and plans[0] == plan_shard(options, 1, 0)


def ranges_of_dose_angles_and_offset_hold_and_stand_in_the_plan():
    at = folder("ranges")
    words = ["--frames", "8", "--shard-frames", "4", "--block-frames", "1", "--size", "64", "--tools", "j_wire"]
    words += ["--dose", "10", "20", "--primary", "-30", "-20", "--secondary", "5", "5", "--offset", "0"]
    good = runs.made(at, *words)
    with open(os.path.join(at, "plan.json"), encoding="utf-8") as file:
        kept = json.load(file)["options"]
    variation = kept["variation"]
    good = good and (variation["dose"], kept["offset_part"]) == ([0.25, 0.5], 0.0)
    good = good and (variation["primary_deg"], variation["secondary_deg"]) == ([-30, -20], [5, 5])
    options = Options(frames=8, shard_frames=4, block_frames=1, variation=varied((10, 20), (0, 0), (0, 0)))
    doses = [block.dose_nGy for block in plan_shard(options, 0).blocks]
    for facts, _ in read_tar(0, at):
        view, tip = facts["view"], facts["tools"][0]["tip"]
        good = good and facts["dose"]["detector_nGy"] in doses
        good = good and -30 <= view["primary_deg"] <= -20 and view["secondary_deg"] == 5
        good = good and np.hypot(*(np.array(tip["px"]) - 32)) < 2.0  # the tip moves by up to 2.7 mm before the picture
    return good and 10 <= min(doses) and max(doses) <= 20


# --- files, read from their bytes ---


def read_png(content):
    """Reads a PNG file as the PNG standard describes it: chunks with their checksums, and the filters 0 to 2."""
    at, data, kinds = 8, b"", []
    while at < len(content):
        (size,) = struct.unpack(">I", content[at : at + 4])
        kind, body = content[at + 4 : at + 8], content[at + 8 : at + 8 + size]
        if struct.unpack(">I", content[at + 8 + size : at + 12 + size])[0] != zlib.crc32(kind + body):
            raise ValueError("a chunk is damaged")
        kinds.append(kind)
        head = body if kind == b"IHDR" else head  # noqa: F821
        data += body if kind == b"IDAT" else b""
        at += 12 + size
    width, height, bits, colour = struct.unpack(">IIBB", head[:10])
    step = bits // 8 * (3 if colour == 2 else 1)
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, width * step + 1)
    lines = [np.zeros((width, step), np.uint8)]
    for row in rows:
        line = row[1:].reshape(width, step)
        if row[0] == 1:
            line = np.cumsum(line, axis=0, dtype=np.uint8)
        elif row[0] == 2:
            line = line + lines[-1]
        lines.append(line)
    pixels = np.stack(lines[1:])
    return pixels.reshape(height, width, step) if colour == 2 else pixels.copy().view(">u%d" % step)[:, :, 0]


def read_tar(shard, at=WHOLE):
    """Yields the metadata and the files of each frame of a shard."""
    with tarfile.open(os.path.join(at, "webdataset", "%06d.tar" % shard)) as tar:
        members = {}
        for member in tar.getmembers():
            key, _, ending = member.name.partition(".")
            members.setdefault(key, {})[ending] = tar.extractfile(member).read()
    for parts in members.values():
        yield json.loads(parts["json"]), parts


def a_png_holds_the_pixels_with_every_compression():
    draw = np.random.default_rng(1)
    images = [draw.integers(0, 2**16, (48, 64)).astype(np.uint16), draw.integers(0, 256, (300, 301)).astype(np.uint8)]
    images.append(draw.integers(0, 256, (20, 30, 3)).astype(np.uint8))
    good = all(
        np.array_equal(read_png(png.encode(image, how)), image)
        for image in images
        for how in ("stored", "fast", "flat")
    )
    return good and np.array_equal(png.decode_colour(png.encode(images[2], "flat")), images[2])


def a_picture_without_pixels_has_no_png():
    for shape in ((2, 0), (0, 2)):
        for how in ("stored", "flat"):
            try:
                png.encode(np.zeros(shape, np.uint8), how)
            except ValueError:
                continue
            return False
    return True


def rounding_leaves_no_range_of_angles():
    variation = replace(VARIATION, primary_deg=(5.04, 5.06))
    options = Options(frames=24, shard_frames=24, block_frames=1, variation=variation)
    return {block.primary_deg for block in plan_shard(options, 0).blocks} <= {5.04, 5.06}


def a_png_of_a_mask_holds_its_pixels():
    """Masks of random sizes, from empty ones to noise, whose runs lie along the rows or along the columns."""
    draw, good = np.random.default_rng(2), True
    for part in (0.0, 0.001, 0.02, 0.5) * 20:
        height, width = draw.integers(1, 600, 2)
        mask = (draw.random((height, width)) < part).astype(np.uint8) * draw.integers(1, 256, dtype=np.uint8)
        mask = np.maximum.accumulate(mask, axis=int(draw.integers(0, 2)))
        good = good and np.array_equal(read_png(png.encode(mask, "flat")), mask)
        counts = areas_of(mask)
        good = good and all(counts[one.name] == np.count_nonzero(mask & np.uint8(one)) for one in cournand.Label)
    return good


def a_tar_holds_every_frame_once_and_its_masks_have_the_stated_areas():
    indexes, bits = [], {"TOOL_0": 1, "TOOL_1": 2, "TOOL_2": 4, "MEDIUM": 8, "STENT": 16, "BALLOON": 32}
    for shard in range(3):
        for facts, members in read_tar(shard):
            indexes.append(facts["index"])
            labels, raw = read_png(members["labels.png"]), read_png(members["raw.png"])
            areas = {name: int(((labels & bit) != 0).sum()) for name, bit in bits.items()}
            if areas != facts["areas_px"] or raw.dtype.itemsize != 2 or raw.max() > 16383:
                return False
            if read_png(members["grey.png"]).shape != (64, 64) or facts["tools"][0]["tip"]["visibility"] not in (
                0,
                1,
                2,
            ):
                return False
    return indexes == list(range(10))


def a_header_of_a_tar_is_that_of_tarfile():
    for name, size in (("a", 0), ("000012-00003.centrelines.npy", 511), ("n" * 100, 8**11 - 1)):
        info = tarfile.TarInfo(name)
        info.size, info.mode = size, 0o644
        if header(name, size) != info.tobuf(tarfile.USTAR_FORMAT):
            return False
    return True


def unpacked(text):
    """Reads the text of a run-length mask letter by letter."""
    counts, at = [], 0
    while at < len(text):
        number, shift = 0, 0
        while True:
            group = ord(text[at]) - 48
            number |= (group & 31) << shift
            at, shift = at + 1, shift + 5
            if not group & 32:
                break
        if group & 16:
            number -= 1 << shift
        counts.append(number + (counts[-2] if len(counts) > 2 else 0))
    return counts


def run_lengths_give_the_masks_back():
    found = 0
    for frame in frames(3, tools=("rosen+balloon_6x20@renal_6_0x18", "beacon_5f")):
        for one in annotations_of(frame):
            counts = unpacked(one["segmentation"]["counts"])
            values = np.arange(len(counts)) % 2
            mask = np.repeat(values, counts).reshape(256, 256).T.astype(bool)
            bit = {4: 8, 5: 16, 6: 32}.get(one["category_id"]) or 1 << one["position"]
            left, top, width, height = one["bbox"]
            if not np.array_equal(mask, (frame.labels & bit) != 0) or mask.sum() != one["area"]:
                return False
            if mask[top : top + height, left : left + width].sum() != one["area"]:
                return False
            found += 1
    return found > 20


def the_annotations_of_all_shards_are_one_file():
    with open(os.path.join(WHOLE, "coco", "annotations.json"), encoding="utf-8") as file:
        coco = json.load(file)
    identities = [one["id"] for one in coco["annotations"]]
    good = [one["id"] for one in coco["images"]] == list(range(10)) and len(identities) == len(set(identities)) > 10
    for image in coco["images"]:
        with open(os.path.join(WHOLE, "coco", image["file_name"]), "rb") as file:
            good = good and read_png(file.read()).shape == (image["height"], image["width"])
    points = [len(one["keypoints"]) for one in coco["annotations"] if "keypoints" in one]
    return good and set(points) == {3 * len(coco["categories"][0]["keypoints"])}


def dicom_files_have_no_errors():
    words, errors, count = ["dciodvfy"], [], 0
    for at, _, names in sorted(os.walk(os.path.join(WHOLE, "dicom"))):
        for name in sorted(names):
            ended = subprocess.run([*words, os.path.join(at, name)], capture_output=True, text=True, check=False)
            errors += [line for line in ended.stderr.splitlines() if line.startswith("Error")]
            count += 1
    print("".join("# %s\n" % line for line in errors), end="")
    return count == 5 and not errors


def the_pages_need_no_network_and_name_seed_and_versions():
    with open(os.path.join(WHOLE, "statistics.html"), encoding="utf-8") as file:
        page = file.read()
    with open(os.path.join(WHOLE, "datasheet.md"), encoding="utf-8") as file:
        sheet = file.read()
    good = "http" not in page and page.count("data:image/png;base64,") == 1 and "Contrast phase" in page
    return good and "seed 28" in sheet and "numpy" in sheet and "rosen+balloon_6x20@renal_6_0x18" in sheet


# --- the command line ---


def wrong_options_are_refused_by_name():
    out, good = folder("none"), True
    wrong = [
        (("--frames", "0"), "--frames"),
        (("--frames", "x"), "--frames"),
        (("--frames", "5", "--size", "100"), "--size"),
        (("--frames", "5", "--seed", "-1"), "--seed"),
        (("--frames", "5", "--formats", "tiff"), "tiff"),
        (("--frames", "5", "--formats", ""), "--formats"),
        (("--frames", "5", "--tools", "j_wires"), "j_wires"),
        (("--frames", "5", "--tools", "j_wire+rosen+bentson+beacon_5f"), "one to three"),
        (("--frames", "5", "--tools", "balloon_6x20@nothing"), "nothing"),
        (("--frames", "5", "--scenes", "moon"), "moon"),
        (("--frames", "5", "--pulses", "nan"), "--pulses"),
        (("--frames", "5", "--workers", "0"), "--workers"),
        (("--frames", "5", "--shards", "2/2"), "--shards"),
        (("--frames", "5", "--shards", "a"), "--shards"),
        (("--frames", "5", "--bits", "3"), "--bits"),
        (("--frames", "5", "--dose", "20", "10"), "--dose"),
        (("--frames", "5", "--dose", "0.5", "10"), "--dose"),
        (("--frames", "5", "--dose", "nan", "nan"), "--dose"),
        (("--frames", "5", "--primary", "-121", "0"), "--primary"),
        (("--frames", "5", "--secondary", "0", "51"), "--secondary"),
        (("--frames", "5", "--secondary", "0"), "--secondary"),
        (("--frames", "5", "--offset", "0.5"), "--offset"),
        ((), "--frames"),
    ]
    for words, name in wrong:
        code, _, errors = runs.factory(*words, "--out", out)
        if code != 2 or name not in errors or "Traceback" in errors:
            print("# %s: exit code %d, %s" % (" ".join(words), code, errors.strip()))
            good = False
    for words in (("resume", out), ("check", out), ("stats", out)):
        code, _, errors = runs.factory(*words)
        good = good and code == 2 and "holds no data set" in errors
    return good and not os.path.exists(os.path.join(out, "plan.json"))


def a_damaged_plan_is_refused():
    at, good = folder("plan"), True
    os.makedirs(at)
    for text in ("", "[]", "{}", '{"options": 3}', '{"options": {"frames": 5}, "versions": {}}', "\xff"):
        with open(os.path.join(at, "plan.json"), "w", encoding="utf-8") as file:
            file.write(text)
        code, _, errors = runs.factory("resume", at)
        good = good and code == 2 and "plan.json" in errors and "Traceback" not in errors
    with open(os.path.join(WHOLE, "plan.json"), encoding="utf-8") as file:
        plan = json.load(file)
    plan["versions"]["numpy"] = "1.0"
    with open(os.path.join(at, "plan.json"), "w", encoding="utf-8") as file:
        json.dump(plan, file)
    code, _, errors = runs.factory("resume", at)
    return good and code == 2 and "numpy 1.0" in errors


def a_folder_of_other_files_is_refused():
    at = folder("other")
    os.makedirs(at)
    open(os.path.join(at, "thesis.txt"), "w", encoding="ascii").close()
    code, _, errors = runs.factory(*runs.SMALL, "--out", at)
    return code == 2 and "not an empty folder" in errors and os.listdir(at) == ["thesis.txt"]


def a_second_run_at_the_same_time_is_refused():
    words = [*runs.WORDS, *runs.SMALL, "--out", folder("busy"), "--quiet"]
    first = subprocess.Popen(words, stderr=subprocess.DEVNULL)
    lock = os.path.join(folder("busy"), "parts", "0-of-1.lock")
    while not os.path.exists(lock) and first.poll() is None:
        pass
    code, _, errors = runs.factory("resume", folder("busy"))
    is_refused = code == 1 and "another run is at work" in errors
    return first.wait() == 0 and is_refused


def a_plan_is_shown_without_work():
    code, text, _ = runs.factory("plan", *runs.SMALL)
    return code == 0 and "10 frames in 3 shards" in text and text.count("shard ") == 3


def the_script_for_slurm_makes_every_shard():
    """Runs the printed script as Slurm would: first each task of the array, then the job that depends on them."""
    at = folder("slurm")
    code, text, _ = runs.factory("slurm", *runs.SMALL, *runs.FORMATS, "--out", at, "--tasks", "2", "--cpus", "1")
    good = code == 0 and "#SBATCH --array=0-1\n" in text and "afterok" in text
    script = folder("factory.sh")
    with open(script, "w", encoding="utf-8") as file:
        file.write(text)
    for task in ("1", "0"):
        ended = subprocess.run(["sh", script], env=dict(os.environ, SLURM_ARRAY_TASK_ID=task), capture_output=True)
        good = good and ended.returncode == 0
    return good and subprocess.run(["sh", script, "end"], capture_output=True).returncode == 0 and runs.equal(WHOLE, at)


def options_are_checked_in_python_too():
    for more in ({"frames": 0}, {"frames": 1, "compression": "best"}, {"frames": 1, "tools": ()}):
        try:
            Options(**more)
            return False
        except UsageError:
            continue
    return Options(frames=10, shard_frames=4).shards == 3


if __name__ == "__main__":
    tap.run(
        [
            a_run_writes_a_checked_data_set,
            two_workers_write_the_bytes_of_one,
            parts_of_several_machines_write_the_bytes_of_one,
            a_run_that_is_killed_continues_without_a_lost_or_double_frame,
            a_shard_does_not_depend_on_the_number_of_frames,
            what_is_damaged_is_found_and_made_again,
            the_same_command_again_makes_nothing_and_other_options_are_refused,
            tips_and_centrelines_lie_in_the_masks_of_their_tools,
            a_point_is_clear_only_where_its_tool_is_alone,
            the_projection_in_the_file_gives_the_pixels_in_the_file,
            medium_balloon_and_stent_appear_in_their_masks,
            marker_bands_lie_on_the_balloon,
            a_refused_set_of_tools_is_drawn_again,
            ranges_of_dose_angles_and_offset_hold_and_stand_in_the_plan,
            a_png_holds_the_pixels_with_every_compression,
            a_picture_without_pixels_has_no_png,
        rounding_leaves_no_range_of_angles,
        a_png_of_a_mask_holds_its_pixels,
            a_tar_holds_every_frame_once_and_its_masks_have_the_stated_areas,
            a_header_of_a_tar_is_that_of_tarfile,
            run_lengths_give_the_masks_back,
            the_annotations_of_all_shards_are_one_file,
            dicom_files_have_no_errors,
            the_pages_need_no_network_and_name_seed_and_versions,
            wrong_options_are_refused_by_name,
            a_damaged_plan_is_refused,
            a_folder_of_other_files_is_refused,
            a_second_run_at_the_same_time_is_refused,
            a_plan_is_shown_without_work,
            the_script_for_slurm_makes_every_shard,
            options_are_checked_in_python_too,
        ]
    )
