import webbrowser
from pathlib import Path

import pytest

from llsrbm.cli import main
from tests.llsrbm.formats.jumps import planned


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("replay") / "plan.npz"
    planned("slider").save(path)
    return path


@pytest.fixture(autouse=True)
def opened(monkeypatch):
    """Addresses that a browser would have opened."""
    asked = []
    monkeypatch.setattr(webbrowser, "open", lambda url: asked.append(url) or True)
    return asked


def test_it_is_written_and_opened(saved, opened, tmp_path, capsys):
    out = tmp_path / "look.html"
    assert main(["replay", str(saved), "--out", str(out)]) == 0
    assert capsys.readouterr().out.strip() == str(out)
    assert out.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert opened == [out.as_uri()]


def test_left_to_itself_it_is_a_temporary_file(saved, opened, capsys):
    assert main(["replay", str(saved), "--no-open"]) == 0
    path = Path(capsys.readouterr().out.strip())
    assert path.name == "slider_forward20cm_up35cm.html"
    assert path.exists()
    assert opened == []
    path.unlink()
    path.parent.rmdir()


def test_no_browser(saved, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(webbrowser, "open", lambda url: False)
    out = tmp_path / "look.html"
    assert main(["replay", str(saved), "--out", str(out)]) == 1
    assert "no browser was found" in capsys.readouterr().err
    assert out.exists()
