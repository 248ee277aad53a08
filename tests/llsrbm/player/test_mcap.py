"""The log of a play, read back by another package."""

import json

import numpy as np
import pytest

from tests.llsrbm.player.stages import GO2, Stage

pytest.importorskip("foxglove", reason="needs the extra llsrbm[mcap]")
reader = pytest.importorskip("mcap.reader")

from llsrbm.player.mcap import write  # noqa: E402


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    stage = Stage("closed-loop", foot_force=True)
    stage.at = [(1.2, lambda: stage.player.stop("enough"))]
    stage.run()
    path = tmp_path_factory.mktemp("log") / "play.mcap"
    write(stage.player.log, path, {"tier": "closed-loop", "ticks": len(stage.player.log)})
    with path.open("rb") as file:
        made = reader.make_reader(file)
        messages = [
            (channel.topic, message.log_time, json.loads(message.data))
            for _, channel, message in made.iter_messages()
        ]
        metadata = {each.name: each.metadata for each in made.iter_metadata()}
    return stage.player.log.arrays(), messages, metadata


def test_every_tick_is_there(played):
    columns, messages, metadata = played
    assert metadata["llsrbm"]["tier"] == "closed-loop"
    rows = {topic: [m for t, _, m in messages if t == topic] for topic, _, _ in messages}
    assert set(rows) == {"/play", "/command", "/readings", "/estimate"}
    assert len(rows["/play"]) == len(rows["/readings"]) == len(columns["time"])
    sent = np.isfinite(columns["command/q"]).all(axis=1)
    assert len(rows["/command"]) == sent.sum() < len(columns["time"])
    assert [row["state"]["number"] for row in rows["/play"]] == columns["state"].tolist()


def test_numbers_are_those_that_were_read_and_sent(played):
    columns, messages, _ = played
    joint = "RR_calf_joint"
    place = GO2.joint_names.index(joint)
    sent = np.isfinite(columns["command/q"]).all(axis=1)
    commands = [(time, m) for topic, time, m in messages if topic == "/command"]
    assert [m["tau"][joint] for _, m in commands] == columns["command/tau"][sent, place].tolist()
    since = columns["time"][sent] - columns["time"][0]
    assert [time for time, _ in commands] == np.round(1e9 * since).astype(int).tolist()
    readings = [m for topic, _, m in messages if topic == "/readings"]
    assert [m["q"][joint] for m in readings] == columns["readings/q"][:, place].tolist()
    assert [m["foot_force"]["FL"] for m in readings] == columns["readings/foot_force"][
        :, 0
    ].tolist()
    estimates = [m for topic, _, m in messages if topic == "/estimate"]
    known = np.isfinite(columns["estimate/q"]).all(axis=1)
    assert [m["position"]["z"] for m in estimates] == columns["estimate/q"][known, 2].tolist()
