"""axe-core in a page: what keeps people from using it, serious or critical."""

from importlib.resources import files

import pytest

_RUN = """async (within) => {
  const found = await axe.run(within ?? document, {
    runOnly: ["wcag2a", "wcag2aa"], resultTypes: ["violations"],
  });
  return found.violations
    .filter(({ id, impact }) => ["serious", "critical"].includes(impact))
    .flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary: why }) =>
      `${id}: ${html.slice(0, 300)} | ${why.slice(0, 300)}`));
}"""


def findings(page, within=None):
    """Violations in a page, or in what a selector names; skips the test where axe is missing."""
    if not page.evaluate("'axe' in window"):
        package = pytest.importorskip("axe_playwright_python")
        page.evaluate((files(package) / "axe.min.js").read_text("utf-8"))
    return page.evaluate(_RUN, within)
