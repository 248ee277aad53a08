from dataclasses import dataclass
from html import escape


@dataclass(frozen=True)
class Column:
    title: str
    colour: tuple
    figures: object


def comparison_table(columns):
    return "<div>" + ", ".join(escape(c.title) for c in columns) + "</div>"
