"""`llsrbm dataset`, as a user types it."""

import pytest

from llsrbm.cli import main
from llsrbm.commands import console
from llsrbm.sweep import dataset


def test_no_sweep_is_one_line(tmp_path, refused):
    out = str(tmp_path / "out")
    line = refused("dataset", str(tmp_path), "--format", "lerobot", "--out", out)
    assert line == f"{tmp_path}: no sweep is there; expected a folder that llsrbm sweep made\n"


@pytest.mark.parametrize("missing", ["--format", "--out"])
def test_what_has_to_be_given(tmp_path, refused, missing):
    given = {"--format": "npz", "--out": str(tmp_path / "out")}
    given.pop(missing)
    assert missing in refused("dataset", str(tmp_path), *next(iter(given.items())))


def test_options_and_result(tmp_path, capsys, monkeypatch):
    asked = {}

    def made(sweep, out, name, *, progress, **options):
        asked.update(options, name=name)
        progress(2, 2)
        return dataset.Summary(2, 1, (7,), out / "index.parquet")

    monkeypatch.setattr(dataset, "make_dataset", made)
    options = ["--robot", "go2", "--source", "plan", "--limit", "2", "--fps", "25"]
    command = ["dataset", str(tmp_path), "--format", "csv", "--out", str(tmp_path), *options]
    assert main(command) == console.DONE
    told = capsys.readouterr()
    assert "motions  2, of them 1 computed now" in told.out
    assert "1 rows are not strict when computed again, and are left out: 7" in told.err
    assert asked == {"name": "csv", "robot": "go2", "source": "plan", "limit": 2, "fps": 25.0}
