#!/usr/bin/env python3
"""Reads the files of the factory of labelled pictures with the libraries that people use for them: pycocotools,
pydicom, webdataset, and, for LeRobot, pyarrow, pandas and datasets. All libraries must find the same pixels and masks
for the same frames. Prints TAP."""

import io
import json
import os
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__), "requirements-factory.txt")

import datasets  # noqa: E402
import factory_runs as runs  # noqa: E402
import numpy as np  # noqa: E402
import pandas  # noqa: E402
import pydicom  # noqa: E402
import webdataset  # noqa: E402
from PIL import Image  # noqa: E402
from pycocotools.coco import COCO  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402

FOLDER = tempfile.TemporaryDirectory()
WHOLE = os.path.join(FOLDER.name, "whole")
BITS = {4: 8, 5: 16, 6: 32}  # of the categories that are no tools


def image(content):
    return np.array(Image.open(io.BytesIO(content)))


def path(*parts):
    return os.path.join(WHOLE, *parts)


def samples():
    """Returns the samples of all shards in the order of their frames."""
    tars = [path("webdataset", name) for name in sorted(os.listdir(path("webdataset")))]
    return list(webdataset.WebDataset(tars, shardshuffle=False))


def webdataset_reads_every_frame_once():
    runs.made(WHOLE, *runs.SMALL, "--formats", "webdataset,coco,dicom,lerobot", "--compression", "fast")
    found = samples()
    raws = [image(one["raw.png"]) for one in found]
    indexes = [json.loads(one["json"])["index"] for one in found]
    good = indexes == list(range(10)) and len({one["__key__"] for one in found}) == 10
    return good and all(raw.dtype == np.uint16 and raw.shape == (64, 64) and raw.max() > 255 for raw in raws)


def pycocotools_gives_the_masks_of_the_label_images():
    coco, found = COCO(path("coco", "annotations.json")), 0
    for one in samples():
        facts, labels = json.loads(one["json"]), image(one["labels.png"])
        picture = coco.loadImgs(facts["index"])[0]
        with open(path("coco", picture["file_name"]), "rb") as file:
            if not np.array_equal(image(file.read()), image(one["grey.png"])):
                return False
        annotations = coco.loadAnns(coco.getAnnIds(imgIds=[facts["index"]]))
        for annotation in annotations:
            bit = BITS.get(annotation["category_id"]) or 1 << annotation["position"]
            if not np.array_equal(coco.annToMask(annotation) != 0, (labels & bit) != 0):
                return False
            found += 1
        if len(annotations) != sum(area > 0 for area in facts["areas_px"].values()):
            return False
    return found > 10


def clear_key_points_of_coco_lie_on_the_masks():
    """At a covered point (visibility 1), the mask of its tool may have no pixel; at a clear point (2), it always has
    one."""
    coco, found = COCO(path("coco", "annotations.json")), 0
    for annotation in coco.loadAnns(coco.getAnnIds(catIds=[1, 2, 3])):
        points = np.array(annotation["keypoints"], dtype=float).reshape(-1, 3)
        mask = coco.annToMask(annotation)
        for column, row, _ in points[points[:, 2] == 2]:
            if mask[min(int(row), 63), min(int(column), 63)] != 1:
                return False
            found += 1
        if annotation["num_keypoints"] != (points[:, 2] > 0).sum():
            return False
    return found > 50


def pydicom_reads_pixels_and_overlays():
    found = samples()
    frame = 0
    for at, _, names in sorted(os.walk(path("dicom"))):
        for name in sorted(names):
            file = pydicom.dcmread(os.path.join(at, name))
            pixels = file.pixel_array
            groups = {file[group, 0x1500].value: group for group in range(0x6000, 0x6020, 2) if (group, 0x3000) in file}
            for number in range(len(pixels)):
                labels = image(found[frame]["labels.png"])
                if not np.array_equal(pixels[number], image(found[frame]["raw.png"])):
                    return False
                for label, group in groups.items():
                    bit = {"TOOL_0": 1, "TOOL_1": 2, "MEDIUM": 8, "STENT": 16, "BALLOON": 32}[label]
                    if not np.array_equal(file.overlay_array(group)[number] != 0, (labels & bit) != 0):
                        return False
                frame += 1
            if "TOOL_0" not in groups or file.Modality != "XA":
                return False
    return frame == 10


def datasets_reads_the_episodes_of_lerobot():
    with open(path("lerobot", "meta", "info.json"), encoding="utf-8") as file:
        info = json.load(file)
    kinds = {}
    for name, feature in info["features"].items():
        value = datasets.Value(feature["dtype"]) if feature["dtype"] != "image" else datasets.Image()
        width = feature["shape"][0]
        kinds[name] = datasets.Sequence(value, length=width) if len(feature["shape"]) == 1 and width > 1 else value
    files = [path("lerobot", info["data_path"].format(chunk_index=0, file_index=k)) for k in range(3)]
    table = datasets.Dataset.from_parquet(
        files, features=datasets.Features(kinds), cache_dir=os.path.join(FOLDER.name, "cache")
    )
    good = table["index"][:] == list(range(10)) and table["episode_index"][:] == [0] * 4 + [1] * 4 + [2] * 2
    for row, one in zip(table, samples()):
        good = good and np.array_equal(np.array(row["observation.images.fluoroscopy"]), image(one["grey.png"]))
        good = good and np.array_equal(np.array(row["observation.images.labels"]), image(one["labels.png"]))
        tip = json.loads(one["json"])["tools"][0]["tip"]
        good = good and np.allclose(row["observation.state"][:5], [*tip["px"], *tip["mm"]], atol=1e-3)
    return good and info["total_frames"] == 10


def pandas_reads_tasks_and_episodes_of_lerobot():
    tasks = pandas.read_parquet(path("lerobot", "meta", "tasks.parquet"))
    episodes = pandas.read_parquet(path("lerobot", "meta", "episodes", "chunk-000", "file-000.parquet"))
    good = tasks.loc["move j_wire"].task_index in range(3) and list(tasks.task_index) == [0, 1, 2]
    good = good and list(episodes.dataset_from_index) == [0, 4, 8] and list(episodes.dataset_to_index) == [4, 8, 10]
    return good and set(tasks.index) == {task for tasks_of in episodes.tasks for task in tasks_of}


def the_statistics_of_lerobot_are_those_of_the_rows():
    with open(path("lerobot", "meta", "stats.json"), encoding="utf-8") as file:
        kept = json.load(file)["observation.state"]
    tables = [pandas.read_parquet(path("lerobot", "data", "chunk-000", "file-%03d.parquet" % k)) for k in range(3)]
    rows = np.stack([row for table in tables for row in table["observation.state"]]).astype(float)
    worst = max(np.abs(rows.mean(axis=0) - kept["mean"]).max(), np.abs(rows.std(axis=0) - kept["std"]).max())
    print("# at most %.6f apart" % worst)
    return worst < 2e-5  # measured 5e-6: the rows are float32


if __name__ == "__main__":
    tap.run(
        [
            webdataset_reads_every_frame_once,
            pycocotools_gives_the_masks_of_the_label_images,
            clear_key_points_of_coco_lie_on_the_masks,
            pydicom_reads_pixels_and_overlays,
            datasets_reads_the_episodes_of_lerobot,
            pandas_reads_tasks_and_episodes_of_lerobot,
            the_statistics_of_lerobot_are_those_of_the_rows,
        ]
    )
