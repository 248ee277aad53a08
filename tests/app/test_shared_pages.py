"""Replays that share player and meshes: put together again they are what they were."""

import base64
import gzip
import json
import re

import pytest
import zstandard

from app.shared_pages import PLAYER, SHARED, SharedPages
from llsrbm.errors import Error, InputError
from llsrbm.formats import export, export_many
from tests.llsrbm.formats.pictures.shown import motion_of

NAMES = "first", "second"


@pytest.fixture(scope="module")
def plan():
    return motion_of("slider").plan


@pytest.fixture(scope="module")
def folder(plan, tmp_path_factory):
    path = tmp_path_factory.mktemp("pages") / "players"
    export_many([(name, plan) for name in NAMES], path, "html", fps=20)
    return path


def unpacked(text):
    return gzip.decompress(base64.b64decode(text))


def assigned(text, name):
    (found,) = re.findall(rf"window\.{name} = (.*?);(?:\n|</script>)", text)
    return json.loads(found)


def test_what_is_alike_is_there_once(folder):
    shared = sorted(path.name for path in (folder / SHARED).iterdir())
    assert len(shared) == 2
    assert PLAYER in shared
    for name in NAMES:
        assert (folder / f"{name}.html").stat().st_size < 200_000


def test_put_together_it_is_the_page_of_one_file(folder, plan, tmp_path):
    export(plan, tmp_path / "one.html", format="html", fps=20)
    whole = (tmp_path / "one.html").read_text("utf-8")
    page = (folder / "first.html").read_text("utf-8")
    motion = assigned(page, "llsrbmMotion")
    (facts,) = re.findall(r'id="facts">(.*?)</script>', whole, re.DOTALL)
    assert json.loads(unpacked(motion["facts"])) == json.loads(facts)
    (key,) = re.findall(rf'src="{SHARED}/(\w+)\.js"></script><script src="{SHARED}/{PLAYER}"', page)
    meshes = unpacked(assigned((folder / SHARED / f"{key}.js").read_text(), "llsrbmMeshes"))
    own, joined, at = unpacked(motion["own"]), b"", 0
    for length, start, end in motion["pieces"]:
        joined += own[at : at + length] + meshes[start:end]
        at += length
    (scene,) = re.findall(r'__VISER_EMBED_DATA__="([^"]*)"', whole)
    raw = base64.b64decode(scene)
    size = int.from_bytes(raw[:8], "little")
    assert len(joined) == size
    there = zstandard.ZstdDecompressor().decompress(raw[8:], max_output_size=size)
    assert len(there) == len(joined)
    scripts = assigned((folder / SHARED / PLAYER).read_text("utf-8"), "llsrbmScripts")
    assert all(script["text"] in whole for script in scripts)


def test_it_asks_for_nothing(folder):
    for name in NAMES:
        page = (folder / f"{name}.html").read_text("utf-8")
        assert "default-src 'none'" in page
        assert not re.findall(r'src="(?!shared/)', page)


def test_it_plays_from_disk(folder, browser):
    tab = browser.new_page()
    wrong = []
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.goto((folder / "second.html").as_uri())
    tab.wait_for_function("() => window.llsrbm?.replay?.time > 0", timeout=120_000)
    assert tab.locator("h1").inner_text()
    assert not wrong
    tab.close()


def test_a_page_that_is_built_otherwise_is_refused(tmp_path):
    with pytest.raises(Error, match="no place for its motion"):
        SharedPages(tmp_path).add("x", "<html><body></body></html>")


def test_formats_that_share_nothing_say_so(plan, tmp_path):
    with pytest.raises(InputError, match="nothing in common; expected html"):
        export_many([("x", plan)], tmp_path, "csv")
