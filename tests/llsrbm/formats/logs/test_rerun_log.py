"""Recordings for rerun, read back with rerun's own reader."""

import gc
import json
import time
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader
from scipy.spatial.transform import Rotation

from llsrbm.errors import InputError
from llsrbm.formats import export
from llsrbm.look.visuals import link_visuals
from llsrbm.motion.sampling import events
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned
from tests.llsrbm.formats.logs.logs import BOARD, link_poses, rollout, sampled, written
from tests.llsrbm.synthetic import FLIGHT

FLOAT = 1e-6  # poses are floats: a robot is within some metres of the origin

# What rerun cannot make sense of it tells as a warning.
pytestmark = pytest.mark.filterwarnings("error")


class Recording:
    """What is in a file: entity -> component -> rows, and the timelines."""

    def __init__(self, path):
        reader = RrdReader(path)
        (self.store,) = reader.recordings()
        self.blueprints = reader.blueprints()
        self.layout = [chunk.entity_path for chunk in reader.stream(store=self.blueprints[0])]
        self.rows = defaultdict(dict)
        self.time = {}
        self.timelines = set()
        for chunk in reader.stream():
            batch = chunk.to_record_batch()
            self.timelines |= set(chunk.timeline_names)
            for name in batch.schema.names:
                if name == "time":
                    ns = batch["time"].cast("int64").to_numpy()
                    assert chunk.entity_path not in self.time, "one chunk an entity"
                    self.time[chunk.entity_path] = ns
                elif name != "rerun.controls.RowId":
                    self.rows[chunk.entity_path][name] = batch[name].to_pylist()

    def seconds(self, entity):
        return self.time[entity] * 1e-9

    def array(self, entity, component):
        """(K, n), what has one instance a row as that instance."""
        rows = np.array(self.rows[entity][component], dtype=float)
        return rows[:, 0] if rows.ndim == 3 else rows

    def scalars(self, name, top="plots"):
        return self.array(f"/{top}/{name}", "Scalars:scalars")

    def static(self, entity, component):
        (row,) = self.rows[entity][component]
        return row


@pytest.fixture(scope="module")
def recording(plan, tmp_path_factory):
    return Recording(written(plan, tmp_path_factory.mktemp("plan"), "rrd"))


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    return Recording(written(rollout(), tmp_path_factory.mktemp("rollout"), "rrd"))


def check_links(recording, top, trajectory):
    name = trajectory.jump.robot
    links = [visual.link for visual in link_visuals(load_robot(name))]
    at, joints = sampled(trajectory, recording.seconds(f"{top}/{links[0]}"))
    for k in np.linspace(0, len(at.time) - 1, 12).astype(int):
        poses = link_poses(name, at, joints, k)
        for link in links:
            rows = recording.rows[f"{top}/{link}"]
            (origin,) = rows["Transform3D:translation"][k]
            (xyzw,) = rows["Transform3D:quaternion"][k]
            np.testing.assert_allclose(origin, poses[link].translation, atol=FLOAT)
            R = Rotation.from_quat(xyzw).as_matrix()
            np.testing.assert_allclose(R, poses[link].rotation, atol=FLOAT)


def test_every_link_is_where_pinocchio_puts_it(plan, recording):
    check_links(recording, "/world/robot", plan)


def test_meshes_are_the_robots(plan, recording):
    for visual in link_visuals(load_robot(plan.jump.robot)):
        entity = f"/world/robot/{visual.link}"
        vertices = recording.static(entity, "Mesh3D:vertex_positions")
        np.testing.assert_array_equal(np.array(vertices, np.float32), visual.vertices)
        rgba = np.array(recording.static(entity, "Mesh3D:vertex_colors"), np.uint32)
        rgb = np.stack([rgba >> 24, (rgba >> 16) & 255, (rgba >> 8) & 255], axis=1)
        np.testing.assert_array_equal(rgb, visual.rgb)


def test_time(plan, recording):
    assert recording.timelines == {"time"}
    exact = np.round((events(plan) - plan.time[0]) * 1e9).astype(int)
    for entity, times in recording.time.items():
        assert times[0] == 0
        assert (np.diff(times) > 0).all()
        if not entity.startswith("/world/blocks"):
            assert np.diff(times).max() <= 5_000_001
            assert set(exact) <= set(times)


def test_scalars_are_doubles(plan, recording):
    at, joints = sampled(plan, recording.seconds("/plots/com"))
    for name, values in (
        ("com", at.com),
        ("com_velocity", at.com_velocity),
        ("linear_momentum", at.linear_momentum),
        ("angular_momentum", at.angular_momentum),
        ("principal_moments", np.linalg.eigvalsh(at.inertia)),
        ("base_position", at.base_position),
        ("base_quat", at.base_quat),
    ):
        np.testing.assert_allclose(recording.scalars(name), values, atol=1e-9, err_msg=name)
    names = recording.static("/plots/joint_position", "SeriesLines:names")
    expected = np.stack([joints[name] for name in names], axis=1)
    np.testing.assert_allclose(recording.scalars("joint_position"), expected, atol=1e-9)
    order = [at.joint_names.index(name) for name in names]
    share = (at.joint_torque / at.joint_torque_limit)[:, order]
    np.testing.assert_allclose(recording.scalars("torque_share"), share, atol=1e-9)
    assert recording.static("/plots/com", "unit") == ["m"]
    assert recording.static("/plots/com", "SeriesLines:names") == ["x", "y", "z"]


def test_forces_and_contacts(plan, recording):
    at, _ = sampled(plan, recording.seconds("/plots/contact"))
    flight = at.phase == FLIGHT
    contact = recording.scalars("contact")
    assert (contact[flight] == 0).all()
    assert (contact[~flight] == 1).all()
    force = np.stack([recording.scalars(f"foot_force/{leg}") for leg in plan.leg_names], axis=1)
    total = at.contact_force.sum(axis=1)[:-1]
    np.testing.assert_allclose(force.sum(axis=1)[:-1], total, atol=1e-6)
    weight = load_robot(plan.jump.robot).mass * 9.81
    for i, leg in enumerate(plan.leg_names):
        vectors = recording.rows[f"/world/forces/{leg}"]["Arrows3D:vectors"]
        origins = recording.rows[f"/world/forces/{leg}"]["Arrows3D:origins"]
        for k in range(len(at.time)):
            pushing = np.linalg.norm(force[k, i]) > 1
            assert len(vectors[k]) == len(origins[k]) == int(pushing)
            if pushing:
                np.testing.assert_allclose(vectors[k][0], 0.8 * force[k, i] / weight, atol=FLOAT)


def test_the_ellipsoid_has_the_inertia(plan, recording):
    at, _ = sampled(plan, recording.seconds("/world/inertia"))
    mass = load_robot(plan.jump.robot).mass
    axes = recording.array("/world/inertia", "Ellipsoids3D:half_sizes")
    quat = recording.array("/world/inertia", "Ellipsoids3D:quaternions")
    a, b, c = axes.T**2
    R = Rotation.from_quat(quat).as_matrix()
    moments = np.stack([b + c, a + c, a + b], axis=1) * mass / 5
    inertia = np.einsum("kij,kj,klj->kil", R, moments, R)
    np.testing.assert_allclose(inertia, at.inertia, rtol=1e-4, atol=1e-5)


def test_what_stands_beside_the_numbers(plan, recording):
    (text,) = recording.static("/description/json", "TextDocument:text")
    about = json.loads(text)
    assert about["request"] == plan.jump.as_dict()
    assert about["solver"]["status"] == "solved"
    (told,) = recording.static("/description", "TextDocument:text")
    assert told.startswith(f"# {about['robot']['name']}: plan\n")
    assert recording.static("/description", "TextDocument:media_type") == ["text/markdown"]


def test_a_layout_comes_with_it(recording):
    assert len(recording.blueprints) == 1
    assert recording.store.application_id == recording.blueprints[0].application_id
    assert sum(path.startswith("/view/") for path in recording.layout) > 8


def test_a_rollout_and_the_plan_that_it_followed(simulated):
    check_links(simulated, "/world/robot", rollout())
    check_links(simulated, "/world/plan", rollout().plan)
    colour = simulated.static("/world/plan/base", "Mesh3D:albedo_factor")[0]
    assert colour & 255 < 128
    at, _ = sampled(rollout().plan, simulated.seconds("/planned/com"))
    np.testing.assert_allclose(simulated.scalars("com", "planned"), at.com, atol=1e-9)


def test_the_board_comes_in_mid_flight(simulated):
    middle = rollout().plan.phase_start[1:3].mean()
    assert simulated.seconds("/world/blocks/board") == pytest.approx([middle], abs=1e-9)
    (centre,), (half,) = (
        simulated.static("/world/blocks/board", f"Boxes3D:{name}")
        for name in ("centers", "half_sizes")
    )
    assert centre[2] + half[2] == pytest.approx(BOARD, abs=FLOAT)


def test_nothing_keeps_running(tmp_path):
    tasks = Path("/proc/self/task")
    if not tasks.exists():
        pytest.skip("counts threads as Linux shows them")
    export(planned("slider"), tmp_path / "0.rrd", format="rrd")
    gc.collect()
    before = len(list(tasks.iterdir()))
    for i in range(3):
        export(planned("slider"), tmp_path / f"{i}.rrd", format="rrd")
    gc.collect()
    deadline = time.monotonic() + 20
    while len(list(tasks.iterdir())) > before and time.monotonic() < deadline:
        time.sleep(0.02)
    assert len(list(tasks.iterdir())) <= before


def test_switched_off_by_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("RERUN", "off")
    with pytest.raises(InputError, match="environment variable RERUN"):
        export(planned("go2"), tmp_path / "x.rrd", format="rrd")
    assert not list(tmp_path.iterdir())
