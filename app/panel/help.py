"""The help: topics, and a line on each term of the page that is no label of a control."""

from pathlib import Path

from app.panel.acts import Act, Button
from app.panel.status import MEANINGS

_TOPICS = Path(__file__).parents[1] / "static" / "help.md"


def topics() -> list[tuple[str, str]]:
    """Titles and texts; in a text, names of the page stand between asterisks."""
    paragraphs = _TOPICS.read_text(encoding="utf-8").strip().split("\n\n")
    parts = [paragraph.removeprefix("**").partition(".** ") for paragraph in paragraphs]
    return [(title, text) for title, _, text in parts]


def terms() -> dict[str, str]:
    """Figures and buttons, and what each means."""
    buttons = (act.value for act in Act if isinstance(act.value, Button))
    hints = {button.label: button.hint for button in buttons if button.hint}
    return {f"{word[0].upper()}{word[1:]}": text for word, text in (MEANINGS | hints).items()}
