import gzip
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import viser

from app.page_template import HEAD, SCRIPTS, page_gzip, page_html, script_file


def test_it_has_a_title_of_its_own():
    assert re.findall(rb"<title>(.*?)</title>", page_html()) == [b"Jump designer"]


def test_every_script_is_there_and_they_run_before_visers():
    page = page_html().decode()
    begins = [found.end() for found in re.finditer(r"<script[^>]*>\n?", page)]
    for name, begin in zip(SCRIPTS, begins, strict=False):
        assert page.startswith(script_file(name).read_text("utf-8"), begin), name
    assert len(begins) > len(SCRIPTS)


def test_the_rest_is_visers_page():
    served = page_html().decode().replace(HEAD, "<title>Viser</title>")
    for name in SCRIPTS:
        script = script_file(name).read_text("utf-8")
        served = served.replace(f"<script>\n{script}</script>\n", "", 1)
    visers = Path(viser.__file__).parent / "client" / "build" / "index.html"
    assert served == visers.read_text("utf-8")


@pytest.mark.parametrize("name", SCRIPTS)
def test_no_script_ends_its_element_or_asks_another_host(name):
    script = script_file(name).read_text("utf-8")
    assert "</script" not in script
    assert "<!--" not in script
    assert "://" not in script


def test_compressed_it_is_the_same():
    assert gzip.decompress(page_gzip()) == page_html()
    # viser's page holds most of itself compressed already.
    assert len(page_gzip()) < 0.9 * len(page_html())


@pytest.mark.skipif(shutil.which("node") is None, reason="no node")
@pytest.mark.parametrize("name", SCRIPTS)
def test_scripts_parse(name):
    assert subprocess.run(["node", "--check", str(script_file(name))], check=False).returncode == 0
