"""The site of a library: pages whose links are there, and that ask for nothing."""

import base64
import json
import re

import pytest

from llsrbm.errors import InputError
from llsrbm.library import Library
from llsrbm.library.site import write_site
from tests.llsrbm.library.shipped_motions import library

NAMES = "go2-together-0001", "go2-hops-0001"


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    small = Library(tmp_path_factory.mktemp("library"))
    for name in NAMES:
        small.put(library().stored(name))
    small.packed()
    return small


@pytest.fixture(scope="module")
def site(own, tmp_path_factory):
    folder = tmp_path_factory.mktemp("site") / "site"
    counted = []
    write_site(own, folder, lambda *numbers: counted.append(numbers))
    assert counted == [(1, 2), (2, 2)]
    return folder


def test_every_link_of_every_page_is_there(site):
    pages = [site / "index.html", *(site / "motions").iterdir()]
    assert len(pages) == 3
    for page in pages:
        text = page.read_text("utf-8")
        assert "http:" not in text
        assert "https:" not in text
        for link in re.findall(r'(?:src|href)="([^"]+)"', text):
            assert (page.parent / link).is_file(), link


def test_the_list_has_every_motion(site):
    text = (site / "index.html").read_text("utf-8")
    (rows,) = re.findall(r'id="rows">(.*?)</script>', text)
    found = json.loads(rows)
    assert [row["name"] for row in found] == sorted(NAMES)
    for row in found:
        assert (site / "motions" / f"{row['name']}.html").is_file()
        figure = library().stick_figures()[row["name"]]
        assert base64.b64decode(row["figure"]["bytes"]) == figure.array.tobytes()
        assert figure.array.shape[1] == row["figure"]["points"]


def test_a_page_has_figures_and_certificate(site):
    text = (site / "motions" / "go2-hops-0001.html").read_text("utf-8")
    for words in ("peak power", "torque_at_speed", "dynamics", "holds", "llsrbm library export"):
        assert words in text


def test_its_library_opens(site, own):
    again = Library(site / "library")
    assert [card.name for card in again.cards] == [card.name for card in own.cards]
    assert again.open(NAMES[0]).certified


def test_it_is_written_again_and_nothing_else_is_lost(site, own, tmp_path):
    write_site(own, site)
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="folder with other things in it"):
        write_site(own, tmp_path)


def test_a_site_of_nothing_is_refused(tmp_path):
    with pytest.raises(InputError, match="there are no motions"):
        write_site(Library(tmp_path / "none"), tmp_path / "site")
