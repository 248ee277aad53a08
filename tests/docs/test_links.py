"""Every link, anchor, picture and path of the pages leads somewhere."""

import re

import pytest

from tests.docs.pages import PAGES, ROOT, anchors, inline_code, links, name_of

FOLDERS = ("app", "assets", "benchmarks", "docs", "llsrbm", "tests")
PATH = re.compile(rf"(?:{'|'.join(FOLDERS)})/[\w./-]*")


@pytest.fixture(params=PAGES, ids=name_of)
def page(request):
    return request.param


def test_links_and_pictures_resolve(page):
    wrong = []
    for target, line in links(page):
        if re.match(r"[a-z]+:", target):
            assert target.startswith(("https://", "http://127.0.0.1")), target
            continue
        path, _, anchor = target.partition("#")
        there = (page.parent / path).resolve() if path else page
        if not there.exists() or not there.is_relative_to(ROOT):
            wrong.append(f"line {line}: {target}: no such file")
        elif anchor and anchor not in anchors(there):
            wrong.append(f"line {line}: {target}: no such heading")
    assert not wrong, "\n".join(wrong)


def test_paths_in_the_text_exist(page):
    missing = [
        f"line {line}: {text}"
        for text, line in inline_code(page)
        if PATH.fullmatch(text) and not (ROOT / text).exists() and not _is_package(text)
    ]
    assert not missing, "\n".join(missing)


def _is_package(text):
    """Such as `llsrbm/1`, a version of a file's layout, or `app/static` inside of a package."""
    return any(ROOT.glob(f"{text.partition('/')[0]}/*/{text.partition('/')[2]}"))


def test_every_page_can_be_reached():
    """From the README or from another page."""
    reached = {
        (page.parent / target.partition("#")[0]).resolve()
        for page in PAGES
        for target, _ in links(page)
    }
    assert [name_of(page) for page in PAGES[1:] if page not in reached] == []


def test_every_picture_is_shown():
    shown = {(page.parent / target).resolve() for page in PAGES for target, _ in links(page)}
    pictures = [
        *(ROOT / "docs").glob("*.webp"),
        *(ROOT / "docs").glob("*.png"),
        *(ROOT / "docs").glob("*.gif"),
    ]
    assert len(pictures) > 5
    assert [name_of(picture) for picture in pictures if picture not in shown] == []
