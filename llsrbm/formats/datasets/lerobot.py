"""LeRobot's data set, version 3.0, of one robot: frames of all motions in Parquet, without videos.

    meta/info.json                                features, rate, how many episodes and frames
    meta/stats.json                               of each feature over all frames
    meta/tasks.parquet                            the request in words -> task_index
    meta/episodes/chunk-000/file-000.parquet      an episode a row: length, where it is, statistics
    data/chunk-000/file-000.parquet               a frame a row, episode after episode

Features, 32 bits each, world frame (x forward, y left, z up), SI units, joints by name in the
robot's order: `observation.state`: position of the root link, its attitude as a quaternion
w, x, y, z without jumps of sign, joint positions; then velocity of the root link's origin, angular
velocity in world axes, joint velocities. `observation.contact`: 1 for each foot that stands.
`observation.torque`: of the joints. `action`: joint positions of the next frame, of the last frame
its own: what a position controller is to reach. Frames are evenly spaced, 50 a second by
default: LeRobot takes whole rates alone.
"""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.files.atomic import staged
from llsrbm.formats.base import Options
from llsrbm.formats.datasets import DatasetFormat, Episode
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion

VERSION = "v3.0"

_PARTS = "parts"  # files of single motions, until all are there
_CHUNK, _DATA_MB, _VIDEO_MB = 1000, 100, 500  # LeRobot's own: files a folder, sizes of files
_DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_EPISODES = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_INFO = "meta/info.json"
# Columns that every such data set has, and their types.
_COUNTED = {"timestamp": "float32"}
_COUNTED |= dict.fromkeys(("frame_index", "episode_index", "index", "task_index"), "int64")

_NAMES, _ROBOT = b"llsrbm.names", b"llsrbm.robot"  # a part's names and robot in its schema
_QUANTILES = (0.01, 0.1, 0.5, 0.9, 0.99)  # those that LeRobot computes


def _check_options(options: Options) -> None:
    if options.fps != int(options.fps):
        raise InputError(f"fps: LeRobot takes whole rates, got {options.fps:g}")


def _write_part(trajectory: Trajectory, path: Path, options: Options) -> None:
    motion = whole_body_motion(trajectory, options.fps, options.pad)
    features = _features(motion)
    columns = {name: _fixed(values) for name, (values, _) in features.items()}
    names = {name: labels for name, (_, labels) in features.items()}
    table = pa.table(columns).replace_schema_metadata(
        {_NAMES: json.dumps(names), _ROBOT: motion.robot.name}
    )
    with staged(path) as target:
        pq.write_table(table, target, compression="snappy")


def _features(motion: WholeBodyMotion) -> dict[str, tuple[NDArray[np.float32], list[str]]]:
    """Name -> (K, n) values and the n names of what they are."""
    joints, legs = motion.robot.joint_names, [leg.name for leg in motion.robot.legs]
    state = [
        *(f"root.{axis}" for axis in ("x", "y", "z", "qw", "qx", "qy", "qz")),
        *(f"{joint}.pos" for joint in joints),
        *(f"root.{axis}" for axis in ("vx", "vy", "vz", "wx", "wy", "wz")),
        *(f"{joint}.vel" for joint in joints),
    ]
    velocity = (motion.base_velocity, motion.angular_velocity, motion.joint_velocity)
    values: dict[str, tuple[Any, list[str]]] = {
        "observation.state": (np.hstack([motion.qpos, *velocity]), state),
        "observation.contact": (motion.contact, [f"{leg}.contact" for leg in legs]),
    }
    if motion.joint_torque is not None:
        torque = [f"{joint}.torque" for joint in joints]
        values["observation.torque"] = (motion.joint_torque, torque)
    following = np.minimum(np.arange(len(motion.time)) + 1, len(motion.time) - 1)
    values["action"] = (motion.joint_position[following], [f"{joint}.pos" for joint in joints])
    return {name: (np.asarray(v, dtype=np.float32), labels) for name, (v, labels) in values.items()}


def _finish(folder: Path, episodes: Sequence[Episode], options: Options) -> None:
    """Make the data set of its parts, which are then removed; `meta/info.json` comes last."""
    # Checked before anything is written: features differ from robot to robot.
    schemas = [pq.read_schema(episode.file) for episode in episodes]
    robots = {schema.metadata[_ROBOT].decode() for schema in schemas}
    if len(robots) > 1 or any(not schema.equals(schemas[0]) for schema in schemas):
        raise InputError(
            f"a LeRobot data set is of one robot, here are {', '.join(sorted(robots))}; expected "
            "--robot with one of them"
        )
    names = json.loads(schemas[0].metadata[_NAMES])
    tasks = {task: n for n, task in enumerate(dict.fromkeys(e.task for e in episodes))}
    writer = _Writer(folder, options.fps, tasks)
    for episode in episodes:
        writer.add(pq.read_table(episode.file), episode.task)
    writer.close()
    _write_tasks(folder / "meta" / "tasks.parquet", tasks)
    _write_json(folder / "meta" / "stats.json", writer.stats())
    info = {
        "codebase_version": VERSION,
        "robot_type": robots.pop(),
        "total_episodes": len(episodes),
        "total_frames": writer.frames,
        "total_tasks": len(tasks),
        "chunks_size": _CHUNK,
        "data_files_size_in_mb": _DATA_MB,
        "video_files_size_in_mb": _VIDEO_MB,
        "fps": int(options.fps),
        "splits": {"train": f"0:{len(episodes)}"},
        "data_path": _DATA,
        "video_path": None,
        "features": _described(names),
    }
    _write_json(folder / _INFO, info)
    shutil.rmtree(folder / _PARTS, ignore_errors=True)


class _Writer:
    """Frames and episodes, file after file; `frames`: how many there are."""

    def __init__(self, folder: Path, fps: float, tasks: dict[str, int]) -> None:
        self._folder, self._fps, self._tasks = folder, fps, tasks
        self.frames = 0
        self._episodes: list[dict[str, Any]] = []
        self._tables: list[pa.Table] = []
        self._written: dict[str, list[NDArray[Any]]] = {}
        self._file = 0
        for old in ("data", "meta"):  # of a process that died here
            shutil.rmtree(folder / old, ignore_errors=True)

    def add(self, part: pa.Table, task: str) -> None:
        """The next episode."""
        count, number = len(part), len(self._episodes)
        frame = np.arange(count)
        counted = {
            "timestamp": frame / self._fps,
            "frame_index": frame,
            "episode_index": np.full(count, number),
            "index": self.frames + frame,
            "task_index": np.full(count, self._tasks[task]),
        }
        for name, kind in _COUNTED.items():
            part = part.append_column(name, pa.array(counted[name].astype(kind)))
        arrays = {name: _dense(part[name]) for name in part.column_names}
        for name, values in arrays.items():
            self._written.setdefault(name, []).append(values)
        if sum(table.nbytes for table in self._tables) + part.nbytes > _DATA_MB * 2**20:
            self._flush()
        self._tables.append(part.replace_schema_metadata(None))
        chunk, file = divmod(self._file, _CHUNK)
        episode: dict[str, Any] = {
            "episode_index": number,
            "tasks": [task],
            "length": count,
            "data/chunk_index": chunk,
            "data/file_index": file,
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + count,
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }
        for name, values in arrays.items():
            episode |= {f"stats/{name}/{key}": value for key, value in _stats(values).items()}
        self._episodes.append(episode)
        self.frames += count

    def close(self) -> None:
        """Write what is left, and the table of episodes."""
        self._flush()
        table = pa.Table.from_pylist(self._episodes)
        _write_table(self._folder / _EPISODES.format(chunk_index=0, file_index=0), [table])

    def stats(self) -> dict[str, dict[str, list[float]]]:
        """Feature -> statistic -> values, over all frames."""
        return {name: _stats(np.concatenate(values)) for name, values in self._written.items()}

    def _flush(self) -> None:
        if not self._tables:
            return
        chunk, file = divmod(self._file, _CHUNK)
        path = self._folder / _DATA.format(chunk_index=chunk, file_index=file)
        _write_table(path, self._tables)
        self._tables, self._file = [], self._file + 1


def _stats(values: NDArray[Any]) -> dict[str, list[float]]:
    """Statistics of (K, n) values: n numbers of each, and one count."""
    wide = values.astype(np.float64)
    found = {name: getattr(wide, name)(axis=0) for name in ("min", "max", "mean", "std")}
    quantiles = np.quantile(wide, _QUANTILES, axis=0)
    found |= {f"q{round(100 * q):02d}": row for q, row in zip(_QUANTILES, quantiles, strict=True)}
    stats: dict[str, list[Any]] = {name: value.tolist() for name, value in found.items()}
    return stats | {"count": [len(values)]}


def _described(names: dict[str, list[str]]) -> dict[str, Any]:
    """Type, shape and names of each feature, for info.json."""
    own = {
        name: {"dtype": "float32", "shape": [len(labels)], "names": labels}
        for name, labels in names.items()
    }
    counted = {name: {"dtype": t, "shape": [1], "names": None} for name, t in _COUNTED.items()}
    return own | counted


def _fixed(values: NDArray[np.float32]) -> pa.Array:
    return pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), values.shape[1])


def _dense(column: pa.ChunkedArray) -> NDArray[Any]:
    """(K, n) of a column; n = 1 of plain numbers."""
    array = column.combine_chunks()
    if pa.types.is_fixed_size_list(array.type):
        return np.asarray(array.flatten()).reshape(-1, array.type.list_size)
    return np.asarray(array).reshape(-1, 1)


def _write_tasks(path: Path, tasks: dict[str, int]) -> None:
    """As pandas would write a frame of task_index whose index is the task."""

    def column(name: str, kind: str, numpy: str) -> dict[str, Any]:
        types = {"pandas_type": kind, "numpy_type": numpy}
        return {"name": name, "field_name": name, **types, "metadata": None}

    pandas = {
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")],
        "creator": {"library": "pyarrow", "version": pa.__version__},
        "pandas_version": "2.0.0",
    }
    table = pa.table({"task_index": pa.array([*tasks.values()], pa.int64()), "task": [*tasks]})
    _write_table(path, [table.replace_schema_metadata({b"pandas": json.dumps(pandas)})])


def _write_table(path: Path, tables: Sequence[pa.Table]) -> None:
    """Each as a group of rows, so that readers can take one episode alone."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with pq.ParquetWriter(path, tables[0].schema, compression="snappy") as writer:
        for table in tables:
            writer.write_table(table)


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with staged(path) as target:
        target.write_text(json.dumps(content, indent=4, allow_nan=False) + "\n", encoding="utf-8")


LEROBOT = DatasetFormat(
    name="lerobot",
    folder=_PARTS,
    suffix=".parquet",
    write=_write_part,
    options=("fps", "pad"),
    defaults=Options(fps=50.0),
    check=_check_options,
    finish=_finish,
    one_robot=True,
    finished=_INFO,
)
