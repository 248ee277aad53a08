"""What the page says of its controls: each that has a label says what it means."""

KINDS = ("Slider", "Number", "Dropdown", "Checkbox", "Button")


def test_every_control_has_a_meaning(tab, session):
    hints = session._rendering.panel.hints
    without = {
        message["props"]["label"]
        for uuid, message in tab.controls.items()
        if message["props"].get("label")  # what the page's scripts alone use has none
        and any(kind in message["type"] for kind in KINDS)
        and not hints.get(uuid, ("", ""))[1]
    }
    assert without == set()
