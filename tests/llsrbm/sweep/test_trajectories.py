import numpy as np
import xarray

from llsrbm.sweep import trajectories
from llsrbm.sweep.shard import Shard

SIZES = {"knot": 5, "xyz": 3, "wxyz": 4, "leg": 2, "contact": 2, "joint": 3}


def part(folder, jumps, group="slider/srbm/5"):
    """A part of jumps whose every number is that of the jump."""
    arrays = {"jump": np.array(jumps), "leg": np.array(["L", "R"]), "joint": np.array(list("abc"))}
    for name, (dimensions, _) in trajectories.QUANTITIES.items():
        shape = [SIZES[dimension] for dimension in dimensions]
        arrays[name] = np.stack([np.full(shape, float(jump)) for jump in jumps])
    path = folder / f"{min(jumps):012d}.npz"
    path.write_bytes(trajectories.packed(Shard(jumps, b"", {group: arrays})))
    return path


def test_parts_become_one_store_by_jump(tmp_path, monkeypatch):
    monkeypatch.setattr(trajectories, "_TOGETHER", 3)
    shards = ([0, 1, 7], [2, 3], [4, 6, 9], [5], [8, 10, 11])
    parts = sorted(part(tmp_path, jumps) for jumps in shards)
    parts.append(part(tmp_path, [12, 13], "slider/srbm/9"))
    trajectories.merge(parts, tmp_path / "t.zarr")
    found = xarray.open_zarr(tmp_path / "t.zarr", group="slider/srbm/5")
    np.testing.assert_array_equal(found.jump, np.arange(12))
    for name in trajectories.QUANTITIES:
        values = found[name].to_numpy().reshape(12, -1)
        np.testing.assert_array_equal(values, np.broadcast_to(np.arange(12)[:, None], values.shape))
    assert list(found.joint.values) == ["a", "b", "c"]
    assert found.com.attrs["units"] == "m"
    other = xarray.open_zarr(tmp_path / "t.zarr", group="slider/srbm/9")
    assert list(other.jump.values) == [12, 13]


def test_a_store_that_is_there_is_replaced_and_none_is_a_store_too(tmp_path):
    trajectories.merge([part(tmp_path, [0, 1])], tmp_path / "t.zarr")
    trajectories.merge([], tmp_path / "t.zarr")
    assert list((tmp_path / "t.zarr").iterdir()) == []
