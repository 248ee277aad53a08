"""What the site's hooks make of links to code and of formulas."""

import pytest

from docs.hooks.formulas import on_page_content
from docs.hooks.source_links import paths_of_links


@pytest.mark.parametrize(
    ("markdown", "made"),
    [
        ("[planning](../llsrbm/planning)", "planning (`llsrbm/planning`)"),
        ("[`llsrbm/formats`](../llsrbm/formats)", "`llsrbm/formats`"),
        ("[rows](../llsrbm/sweep/rows.py#L3)", "rows (`llsrbm/sweep/rows.py`)"),
        ("[hook](hooks/formulas.py)", "hook (`docs/hooks/formulas.py`)"),
    ],
)
def test_links_to_code_become_paths(markdown, made):
    assert paths_of_links(markdown, "files.md") == made


@pytest.mark.parametrize(
    "markdown",
    [
        "[maths](maths.md#drives)",
        "[below](#figures)",
        "[Dask](https://distributed.dask.org)",
        "![picture](designer.webp)",
    ],
)
def test_other_links_stay(markdown):
    assert paths_of_links(markdown, "files.md") == markdown


def test_a_link_to_nothing_is_a_warning(caplog):
    """On which the strict build fails."""
    link = "[gone](../llsrbm/no_such_module.py)"
    assert paths_of_links(link, "files.md") == link
    assert "files.md: ../llsrbm/no_such_module.py: no such file" in caplog.text


@pytest.mark.parametrize(
    ("marked", "display"),
    [
        (r'<span class="arithmatex">\(x_i &lt; 1\)</span>', "inline"),
        (r'<div class="arithmatex">\[\dot r = H/m\]</div>', "block"),
    ],
)
def test_formulas_become_mathml(marked, display):
    made = on_page_content(f"<p>{marked}</p>")
    assert f'display="{display}"' in made
    assert "arithmatex" not in made
    assert "\\" not in made
