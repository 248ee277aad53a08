"""Regenerate the paper's results: `python -m benchmarks.paper [NAME ...]`, or `make paper`.

Figures go to `docs/paper/`, and `docs/paper.md` is written anew from what was measured.
"""

import argparse
import json
import time
from dataclasses import asdict
from importlib import import_module
from pathlib import Path

from benchmarks.paper.result import Result, Table

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
KEPT = ROOT / "build" / "paper"  # what each result came to, so that one alone can be renewed
NAMES = ("twist", "board", "forward", "biped", "solve_times")
HEAD = """# The paper's results, regenerated

Written by `make paper`; figures and sentences with numbers are from its last run. Simulations
begin from seeds that nothing was tuned on, with everything disturbed (`llsrbm/simulation`):
masses, friction, contacts, delays, noise. *Strict* is the strict success of the README.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[[], *NAMES])
    names = parser.parse_args().names or NAMES
    folder = DOCS / "paper"
    folder.mkdir(exist_ok=True)
    KEPT.mkdir(parents=True, exist_ok=True)
    for name in names:
        start = time.perf_counter()
        found = import_module(f"benchmarks.paper.{name}").result(folder)
        (KEPT / f"{name}.json").write_text(
            json.dumps(asdict(found), indent=1) + "\n", encoding="utf-8"
        )
        print(f"{name}: {found.verdict} ({time.perf_counter() - start:.0f} s)", flush=True)
    if missing := [name for name in NAMES if not (KEPT / f"{name}.json").exists()]:
        print(f"docs/paper.md stays as it is: {', '.join(missing)} not measured yet")
        return
    results = [_read(KEPT / f"{name}.json") for name in NAMES]
    summary = Table(
        ("result", "agreement"),
        [(f"[{r.title}](#{_anchor(r.title)})", r.verdict) for r in results],
    )
    parts = [HEAD.strip(), summary.markdown(), *(r.markdown() for r in results)]
    (DOCS / "paper.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _read(path: Path) -> Result:
    table = json.loads(path.read_text(encoding="utf-8"))
    table["tables"] = [Table(**inner) for inner in table["tables"]]
    return Result(**table)


def _anchor(title: str) -> str:
    kept = "".join(c for c in title.lower() if c.isalnum() or c in " -")
    return kept.replace(" ", "-")


if __name__ == "__main__":
    main()
