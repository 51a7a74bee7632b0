"""LeRobot, version 3 of its format: each shard is one episode in one Parquet file. It needs pyarrow.

Pictures and label images stand as PNG files in the table; a video's compression would change values of pixels.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from .. import png
from ..frame import KEYPOINTS, LabelledFrame
from ..options import Options
from ..plan import ShardPlan
from ..store import ShardFolder

FILES_PER_CHUNK = 1000
PICTURE, LABELS = "observation.images.fluoroscopy", "observation.images.labels"
STATE, POINTS, ACTION = "observation.state", "observation.keypoints", "action"
STATE_NAMES = (
    *("tip%d_%s" % (k, axis) for k in range(3) for axis in ("column_px", "row_px", "x_mm", "y_mm", "z_mm")),
    *("inserted%d_mm" % k for k in range(3)),
    *("force%d_N" % k for k in range(3)),
    "heart_phase",
    "breath_phase",
)
ACTION_NAMES = (
    *("push%d_m_per_s" % k for k in range(3)),
    *("turn%d_rad_per_s" % k for k in range(3)),
    "inflator_kPa",
)
POINT_NAMES = tuple("%s%d" % (axis, k) for k in range(KEYPOINTS) for axis in ("column", "row", "visibility"))
STEP = 8  # of the pixels from which the statistics of pictures are taken
WHOLE = ("timestamp", "float32"), ("frame_index", "int64"), ("episode_index", "int64"), ("index", "int64")


def place(shard: int) -> tuple[int, int]:
    """Returns the number of the chunk and the number of the file in which an episode lies."""
    return divmod(shard, FILES_PER_CHUNK)


def path_of(shard: int) -> str:
    return "lerobot/data/chunk-%03d/file-%03d.parquet" % place(shard)


def task_of(tools: Iterable[str]) -> str:
    return "move " + " in ".join(tools)


def state_of(frame: LabelledFrame) -> list[float]:
    tips, inserted, forces = [0.0] * 15, [0.0] * 3, [0.0] * 3
    for tool in frame.tools:
        tips[tool.position * 5 : tool.position * 5 + 5] = [*tool.tip.px, *tool.tip.mm]
        inserted[tool.position] = tool.inserted_mm
        forces[tool.position] = frame.force_N[tool.position]
    return [*tips, *inserted, *forces, frame.facts["heart_phase"], frame.facts["breath_phase"]]


def action_of(frame: LabelledFrame) -> list[float]:
    tools = (len(frame.action) - 1) // 2
    rest = [0.0] * (3 - tools)
    return [*frame.action[:tools], *rest, *frame.action[tools : 2 * tools], *rest, frame.action[-1]]


def points_of(frame: LabelledFrame) -> list[float]:
    """Returns the key points of the leading tool."""
    if not frame.tools:
        return [0.0] * len(POINT_NAMES)
    leading = max(frame.tools, key=lambda tool: (tool.inserted_mm, -tool.position))
    return [float(number) for number in leading.keypoints.ravel()]


class LeRobotWriter:
    """Writes an episode."""

    def __init__(self, options: Options, plan: ShardPlan, folder: ShardFolder) -> None:
        self._options, self._plan, self._folder = options, plan, folder
        self._columns: dict[str, list[Any]] = {name: [] for name in (PICTURE, LABELS, STATE, POINTS, ACTION)}
        self._grey = [0.0, 0.0, 255.0, 0.0, 0.0]  # count, sum, least, most, sum of squares

    def add(self, frame: LabelledFrame) -> None:
        self._columns[PICTURE].append(png.encode(frame.grey, self._options.compression))
        self._columns[LABELS].append(png.encode(frame.labels, "flat"))
        self._columns[STATE].append(state_of(frame))
        self._columns[POINTS].append(points_of(frame))
        self._columns[ACTION].append(action_of(frame))
        some = frame.grey[::STEP, ::STEP].astype(np.int64)
        count, total, least, most, squares = self._grey
        self._grey = [
            count + some.size,
            total + int(some.sum()),
            min(least, int(some.min())),
            max(most, int(some.max())),
            squares + int((some * some).sum()),
        ]

    def end(self) -> dict[str, Any]:
        import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]
        from pyarrow import parquet  # type: ignore[import-not-found, import-untyped, unused-ignore]

        count = len(self._columns[STATE])
        first = self._plan.shard * self._options.shard_frames
        numbers = np.arange(count)
        arrays: dict[str, Any] = {}
        for name in (PICTURE, LABELS):
            bytes_of = pa.array(self._columns[name], pa.binary())
            paths = pa.nulls(count, pa.string())
            arrays[name] = pa.StructArray.from_arrays([bytes_of, paths], ["bytes", "path"])
        for name in (STATE, POINTS, ACTION):
            rows = np.asarray(self._columns[name], dtype=np.float32)
            arrays[name] = pa.FixedSizeListArray.from_arrays(pa.array(rows.ravel()), rows.shape[1])
        arrays["timestamp"] = pa.array((numbers / self._options.pulses_per_s).astype(np.float32))
        arrays["frame_index"] = pa.array(numbers, pa.int64())
        arrays["episode_index"] = pa.array(np.full(count, self._plan.shard), pa.int64())
        arrays["index"] = pa.array(first + numbers, pa.int64())
        arrays["task_index"] = pa.array(np.full(count, self._task_index()), pa.int64())
        name = path_of(self._plan.shard)
        file = self._folder.open(name)
        sink = pa.BufferOutputStream()
        parquet.write_table(pa.table(arrays), sink, compression="none", row_group_size=count)
        file.write(sink.getvalue().to_pybytes())
        self._folder.close(name)
        return {"grey": self._grey, **{key: _sums(self._columns[key]) for key in (STATE, POINTS, ACTION)}}

    def _task_index(self) -> int:
        names = tasks_of(self._options)
        return names.index(task_of(self._plan.tools))


def tasks_of(options: Options) -> list[str]:
    """Returns the different tasks, one for each set of tools, in the order of their names."""
    return sorted({task_of(tools.partition("@")[0].split("+")) for tools in options.tools})


def _sums(rows: list[list[float]]) -> list[list[float]]:
    """Returns the number of values, their sum, the smallest and the largest one, and the sum of squares, for each
    column."""
    table = np.asarray(rows, dtype=np.float64)
    count = [float(len(table))] * table.shape[1]
    made = [count, table.sum(axis=0), table.min(axis=0), table.max(axis=0), (table * table).sum(axis=0)]
    return [[float(number) for number in row] for row in made]


def _statistics(parts: list[list[Any]]) -> dict[str, Any]:
    """Computes the statistics of all episodes from those of each episode, in the order of the episodes."""
    count, total, squares = (np.sum([part[k] for part in parts], axis=0) for k in (0, 1, 4))
    mean = total / count
    return {
        "count": [int(np.max(count))],
        "mean": mean.tolist(),
        "std": np.sqrt(np.maximum(squares / count - mean * mean, 0.0)).tolist(),
        "min": np.min([part[2] for part in parts], axis=0).tolist(),
        "max": np.max([part[3] for part in parts], axis=0).tolist(),
    }


def _features(options: Options) -> dict[str, Any]:
    shape = [options.size, options.size, 1]
    made: dict[str, Any] = {
        name: {"dtype": "image", "shape": shape, "names": ["height", "width", "channels"]} for name in (PICTURE, LABELS)
    }
    for name, names in ((STATE, STATE_NAMES), (POINTS, POINT_NAMES), (ACTION, ACTION_NAMES)):
        made[name] = {"dtype": "float32", "shape": [len(names)], "names": list(names)}
    for name, kind in (*WHOLE, ("task_index", "int64")):
        made[name] = {"dtype": kind, "shape": [1], "names": None}
    return made


def _parquet(table: Any) -> bytes:
    import pyarrow as pa
    from pyarrow import parquet

    sink = pa.BufferOutputStream()
    parquet.write_table(table, sink, compression="none")
    return bytes(sink.getvalue().to_pybytes())


def _tasks_table(options: Options) -> Any:
    """Returns the table of tasks, whose index is the text of the task, as pandas writes it."""
    import pyarrow as pa

    names = tasks_of(options)
    column = {"name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64"}
    index = {"name": None, "field_name": "__index_level_0__", "pandas_type": "unicode", "numpy_type": "object"}
    about = {
        "index_columns": ["__index_level_0__"],
        "column_indexes": [],
        "columns": [{**column, "metadata": None}, {**index, "metadata": None}],
        "pandas_version": "2.0.0",
    }
    table = pa.table({"task_index": pa.array(range(len(names)), pa.int64()), "__index_level_0__": pa.array(names)})
    return table.replace_schema_metadata({"pandas": json.dumps(about)})


def completed(dataset: Path, options: Options, manifests: list[dict[str, Any]]) -> dict[str, bytes]:
    """Returns the files of the whole data set: information, statistics, tasks and episodes."""
    import pyarrow as pa

    sums = [manifest["formats"]["lerobot"] for manifest in manifests]
    statistics: dict[str, Any] = {key: _statistics([one[key] for one in sums]) for key in (STATE, POINTS, ACTION)}
    grey = _statistics([[[number] for number in one["grey"]] for one in sums])
    picture = {key: [[[grey[key][0] / 255.0]]] for key in ("mean", "std", "min", "max")}
    statistics[PICTURE] = {**picture, "count": grey["count"]}
    info = {
        "codebase_version": "v3.0",
        "robot_type": "cournand",
        "total_episodes": len(manifests),
        "total_frames": options.frames,
        "total_tasks": len(tasks_of(options)),
        "chunks_size": FILES_PER_CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": int(options.pulses_per_s) if options.pulses_per_s.is_integer() else options.pulses_per_s,
        "splits": {"train": "0:%d" % len(manifests)},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": None,
        "features": _features(options),
    }
    places = [place(manifest["shard"]) for manifest in manifests]
    firsts = [manifest["first_index"] for manifest in manifests]
    episodes = pa.table(
        {
            "episode_index": pa.array([manifest["shard"] for manifest in manifests], pa.int64()),
            "tasks": pa.array([[task_of(manifest["tools"])] for manifest in manifests], pa.list_(pa.string())),
            "length": pa.array([manifest["frames"] for manifest in manifests], pa.int64()),
            "data/chunk_index": pa.array([chunk for chunk, _ in places], pa.int64()),
            "data/file_index": pa.array([file for _, file in places], pa.int64()),
            "dataset_from_index": pa.array(firsts, pa.int64()),
            "dataset_to_index": pa.array([f + m["frames"] for f, m in zip(firsts, manifests)], pa.int64()),
            "meta/episodes/chunk_index": pa.array([0] * len(manifests), pa.int64()),
            "meta/episodes/file_index": pa.array([0] * len(manifests), pa.int64()),
        }
    )
    return {
        "lerobot/meta/info.json": (json.dumps(info, indent=1) + "\n").encode(),
        "lerobot/meta/stats.json": (json.dumps(statistics, indent=1) + "\n").encode(),
        "lerobot/meta/tasks.parquet": _parquet(_tasks_table(options)),
        "lerobot/meta/episodes/chunk-000/file-000.parquet": _parquet(episodes),
    }
