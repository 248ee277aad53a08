"""The help: topics with titles, and a line on each term."""

from app.panel.acts import Act
from app.panel.help import terms, topics
from app.tab.effects import ShowHelp
from tests.app.pure_tab import planned_tab


def test_topics_have_titles_and_their_names_stand_between_asterisks():
    found = topics()
    assert [title for title, _ in found][:3] == ["A jump", "Footholds", "Routes"]
    for title, text in found:
        assert title
        assert text.endswith(".")
        assert "**" not in text
        assert text.count("*") % 2 == 0, title


def test_every_figure_of_the_verdict_and_every_button_has_a_line():
    assert {
        "Yaw inertia Izz, flight",
        "Not strict",
        "Compare models",
        "Simulate 20 seeds",
    } <= terms().keys()


def test_the_button_shows_it():
    tab = planned_tab()
    assert tab.take(Act.HELP) == (ShowHelp(),)
