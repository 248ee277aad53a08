import json
import shutil

import pyarrow.parquet as pq
import pytest

from llsrbm import cli
from llsrbm.sweep import jump, run
from tests.llsrbm.sweep.specs import GRID, in_this_process, without_planning


@pytest.fixture
def sweep(tmp_path, monkeypatch):
    """Run the command with a spec's text; its status."""
    without_planning(monkeypatch)
    monkeypatch.setattr(run, "connected", in_this_process)

    def command(text=GRID, *options):
        (tmp_path / "spec.toml").write_text(text)
        out = ("--out", str(tmp_path / "out"))
        return cli.main(["sweep", str(tmp_path / "spec.toml"), *out, *options])

    return command


def test_a_table_and_a_summary(sweep, tmp_path, capfd):
    assert sweep() == 0
    told = capfd.readouterr()
    assert "40 jumps, 40 rows; expected" in told.err
    assert "dashboard: http://" in told.err
    assert "anymal   20 rows: 16 planned, 4 not planned" in told.out
    assert len(pq.read_table(tmp_path / "out" / "jumps.parquet")) == 40


def test_drafts_are_asked_for_by_the_spec_or_the_command(sweep, tmp_path, monkeypatch):
    asked = []
    given = jump._planned
    monkeypatch.setattr(jump, "_planned", lambda s, p: asked.append(s.draft) or given(s, p))
    for options, draft in (((), False), (("--draft",), True)):
        shutil.rmtree(tmp_path / "out", ignore_errors=True)
        assert sweep(GRID, *options) == 0
        assert {*asked[-40:]} == {draft}


def test_json_is_one_object_and_done_is_done(sweep, capfd):
    assert sweep(GRID, "--json") == 0
    first = json.loads(capfd.readouterr().out)
    assert first["robots"]["go2"] == {"rows": 20, "planned": 16, "not planned": 4}
    assert first["run"]["jumps"] == 40
    assert sweep(GRID, "--json") == 0
    again = capfd.readouterr()
    assert json.loads(again.out) == first | {"run": None}
    assert "going on: 40 of 40 jumps are done" in again.err


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        (GRID.replace("forward", "forwards"), (), 'unknown key "axes.forwards"'),
        (GRID.replace("go2", "go3"), (), 'no robot "go3"; did you mean "go2"'),
        (GRID.replace("count = 5", "count = 100000000000"), (), "expected at most 1e+08"),
        (GRID.replace("count = 5", "count = 200000"), (), "expected --yes"),
        (GRID, ("--workers", "0"), "--workers 0: expected 1 or more"),
        (GRID, ("--workers", "2", "--scheduler", "tcp://x:1"), "expected one of them"),
    ],
)
def test_what_cannot_be_is_one_line(sweep, capfd, text, options, said):
    assert sweep(text, *options) == 2
    told = capfd.readouterr()
    *_, last = told.err.splitlines()
    assert last.startswith("llsrbm: ")
    assert said in last
    assert "Traceback" not in told.err
    assert told.out == ""


def test_interrupted_it_says_how_to_go_on(sweep, monkeypatch, capfd):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "run", interrupted)
    assert sweep() == 130
    assert "run the same command again to go on" in capfd.readouterr().err
