"""`llsrbm library`: lists, one motion, exports, additions, builds; bad input in one line."""

import json

import pytest

from llsrbm import cli
from llsrbm.library.attempt import KEPT, Attempt
from llsrbm.library.card import Simulated
from tests.llsrbm.library.shipped_motions import NAME, card, library, plan
from tests.llsrbm.library.test_build import motion_for


def said(capfd, *words, status=0):
    assert cli.main(["library", *words]) == status
    return capfd.readouterr()


def test_all_are_listed_and_words_find_some(capfd):
    lines = said(capfd).out.splitlines()
    assert lines[0].split()[:2] == ["name", "leads"]
    assert len(lines) == 1 + len(library().cards)
    found = said(capfd, "go2", "together", "--robot", "go2", "--json").out
    motions = json.loads(found)["motions"]
    assert motions
    assert {(motion["robot"], motion["type"]) for motion in motions} == {("go2", "together")}


def test_options_may_come_first_and_list_may_be_said(capfd):
    first = said(capfd, "--robot", "go2", "pirouette", "--json").out
    assert json.loads(first) == json.loads(said(capfd, "list", "go2", "pirouette", "--json").out)


def test_figures_are_in_degrees_and_metres(capfd):
    words = "--min-turn", "100", "--min-flight", "0.2", "--json"
    for motion in json.loads(said(capfd, *words).out)["motions"]:
        assert abs(motion["turn"]) > 1.74
        assert motion["flight_s"] >= 0.2


def test_nothing_found_is_said(capfd):
    out, err = said(capfd, "no such words")
    assert out == ""
    assert err == f"llsrbm: no motion of {len(library().cards)} is so\n"
    assert json.loads(said(capfd, "no such words", "--json").out) == {"count": 0, "motions": []}


def test_a_folder_without_a_library_is_refused(capfd, tmp_path):
    for words in ([], ["show", NAME], ["site", str(tmp_path / "site")]):
        err = said(capfd, *words, "--dir", str(tmp_path / "none"), status=2).err
        assert "none: no library is there; expected a folder that `llsrbm library build`" in err


def test_a_motion_is_shown_and_checked_again(capfd):
    assert "The certificate holds." in said(capfd, "show", NAME).out
    found = json.loads(said(capfd, "show", NAME, "--json").out)
    assert found["checked_again"]
    assert found["holds"]
    assert found["request"] == card().request.as_dict()
    stated = json.loads(said(capfd, "show", NAME, "--stated", "--json").out)
    assert not stated["checked_again"]
    assert stated["certificate"] == card().certificate


def test_it_is_exported(capfd, tmp_path):
    import llsrbm

    path = tmp_path / "x.npz"
    said(capfd, "export", NAME, "--format", "motion-npz", "--fps", "50", "--out", str(path))
    assert llsrbm.load_motion(path, "go2").fps == 50
    said(capfd, "export", NAME, "--format", "npz", "--out", str(path))
    loaded = llsrbm.load(path)
    assert loaded.certified
    assert loaded.feedback_gain is not None


def test_plans_are_added(capfd, tmp_path, monkeypatch):
    monkeypatch.setattr("llsrbm.library.attempt.simulated", lambda *_: Simulated(1, 1, 1))
    path, folder = tmp_path / "plan.npz", tmp_path / "library"
    plan().save(path)
    words = "add", str(path), "--out", str(folder), "--seeds", "1"
    assert json.loads(said(capfd, *words, "--json").out)["added"] == ["go2-together-0001"]
    assert (folder / "card.json").is_file()
    assert "is the motion of that request" in said(capfd, *words, status=1).err
    assert said(capfd, "--dir", str(folder)).out.count("go2-together-0001") == 1


def test_plans_that_are_not_strict_are_added_if_asked_for(capfd, tmp_path, monkeypatch):
    monkeypatch.setattr("llsrbm.library.attempt.simulated", lambda *_, **__: Simulated(2, 2, 1))
    path, folder = tmp_path / "plan.npz", tmp_path / "library"
    plan().save(path)
    words = "add", str(path), "--out", str(folder), "--seeds", "2"
    assert "did not land strictly" in said(capfd, *words, status=1).err
    said(capfd, *words, "--not-strict")
    assert "1 of 2" in said(capfd, "--dir", str(folder)).out


def test_it_is_built(capfd, tmp_path, monkeypatch):
    def run(request, seeds, limit):
        return Attempt(request, KEPT, motion_for(request))

    monkeypatch.setattr("llsrbm.library.build.run_attempt", run)
    words = "build", "--robots", "go2", "--count", "3", "--out", str(tmp_path / "a"), "--json"
    found = json.loads(said(capfd, *words).out)
    assert found["motions"] == 3
    assert found["tried"] == {"kept": 3}
    assert json.loads(said(capfd, *words).out)["tried"] == {}
    assert "3 motions of 1 robots" in (tmp_path / "a" / "README.md").read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("show none", 'no motion "none"'),
        ("export none --format npz --out x.npz", 'no motion "none"'),
        ("export go2-together-0001 --format none --out x.npz", 'no format "none"'),
        ("build --robots none --out x", 'no robot "none"'),
        ("build --workers 0 --out x", "--workers 0: expected 1 or more"),
        ("build --workers 2 --scheduler tcp://x --out x", "expected one of them"),
        ("show go2-together-0001 --dir none", "no library is there"),
        ("--min-turn nan", "min_turn: expected a finite number"),
    ],
)
def test_bad_input_is_one_line(refused, tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    assert message in refused("library", *words.split())
