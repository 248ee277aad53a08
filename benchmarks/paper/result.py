"""One of the paper's results as it came out here, and its text."""

from collections.abc import Sequence
from dataclasses import dataclass

AGREES, PARTLY, NOT = "agrees", "agrees in part", "does not agree"


@dataclass(frozen=True)
class Table:
    """Rows of figures under a heading."""

    heading: Sequence[str]
    rows: Sequence[Sequence[str]]

    def markdown(self) -> str:
        lines = [self.heading, ["---"] * len(self.heading), *self.rows]
        return "\n".join("| " + " | ".join(line) + " |" for line in lines)


@dataclass(frozen=True)
class Result:
    """One of the paper's results.

    Attributes:
        title: of its section.
        claim: what the paper says.
        tables: what was measured here.
        figures: file names in `docs/paper`, and what they show.
        verdict: `AGREES`, `PARTLY` or `NOT`.
        reason: the likely one, in full sentences; figures in it are filled in from the run.
    """

    title: str
    claim: str
    tables: Sequence[Table]
    figures: Sequence[tuple[str, str]]
    verdict: str
    reason: str

    def markdown(self) -> str:
        figures = [f"![{caption}](paper/{name})\n\n*{caption}*" for name, caption in self.figures]
        return "\n\n".join(
            (
                f"## {self.title}",
                f"**The paper:** {self.claim}",
                f"**Here:** {self.verdict}. {self.reason}",
                *(table.markdown() for table in self.tables),
                *figures,
            )
        )
