"""The site builds, and without a warning: a page, a link or a docstring that is wrong is one."""

import re
import subprocess
import sys

import pytest

import llsrbm
from llsrbm.formats import FORMATS
from llsrbm.request import jump_types
from llsrbm.robots import names
from tests.docs.pages import ROOT

pytestmark = pytest.mark.nightly  # half a minute to build

ELSEWHERE = re.compile(r"""<(?:script|link|img|iframe)\b[^>]*?(?:src|href)=["']?(?:https?:)?//""")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    built = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", folder],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=200,
    )
    assert built.returncode == 0, built.stderr
    return folder


def test_what_is_declared_has_a_page(site):
    declared = {"formats": FORMATS, "robots": names(), "types": jump_types.names()}
    for folder, known in declared.items():
        pages = {path.stem for path in (site / folder).glob("*.html")}
        assert pages == {"index", *known}


def test_the_api_has_every_public_name(site):
    page = (site / "api.html").read_text("utf-8")
    assert [name for name in llsrbm.__all__ if f'id="llsrbm.{name}"' not in page] == []


def test_formulas_are_drawn_without_a_script(site):
    page = (site / "maths.html").read_text("utf-8")
    assert page.count("<math") > 20
    assert "arithmatex" not in page


def test_pages_take_nothing_from_elsewhere(site):
    for path in site.rglob("*.html"):
        assert not ELSEWHERE.search(path.read_text("utf-8")), path
