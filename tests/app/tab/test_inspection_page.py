"""The verdict in a browser opens the certificate, and a finding goes to its instant."""

import re

from tests.app.chromium import press, status


def test_the_verdict_opens_the_certificate_and_a_finding_its_instant(page):
    status(page, "Feasible")
    page.locator(".llsrbm-status b button").click()
    finding = page.locator(".llsrbm-certificate button").first
    finding.wait_for()
    assert page.get_by_role("tab", name="Results").get_attribute("aria-selected") == "true"
    instant = finding.get_attribute("data-seek")
    finding.click()
    page.wait_for_function(f"Math.abs(window.llsrbm.player.time - {instant}) < 1e-3")
    press(page, "Simulate")
    status(page, "Landed")
    # It was of the plan; the simulation's is made when it is asked for.
    page.locator(".llsrbm-certificate").wait_for(state="detached")
    press(page, "Check the motion")
    page.get_by_text(re.compile("checks? of the simulation")).wait_for()
