"""The pictures of the documentation show today's page, in full colour."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.app.labels import labels
from tests.app.shared_page import visit

DOCS = Path(__file__).parents[2] / "docs"
RECORD = json.loads((DOCS / "pictures.json").read_text(encoding="utf-8"))


def test_labels_are_those_that_the_pictures_were_taken_with(browser, designer):
    page = visit(browser, designer)  # its own, whose tabs have all been looked into afterwards
    assert labels(page) == RECORD["labels"], "python -m benchmarks.pictures"
    page.context.close()


def test_every_picture_that_is_shown_was_taken_with_them():
    texts = [
        path.read_text(encoding="utf-8") for path in (DOCS.parent / "README.md", *DOCS.glob("*.md"))
    ]
    shown = {name for text in texts for name in re.findall(r"\(?(?:docs/)?([a-z]+)\.webp\)", text)}
    assert shown == set(RECORD["pictures"])


@pytest.mark.parametrize("name", RECORD["pictures"])
def test_full_colour(name):
    """A picture cut to 256 colours has no more."""
    with Image.open(DOCS / f"{name}.webp") as image:
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
    assert len(np.unique(pixels, axis=0)) > 5000
