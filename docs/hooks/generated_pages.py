"""Pages of formats, robots and jump types, made from the declarations that the commands print.

MkDocs calls `on_files` when it builds the site. The pages exist in the site alone, so a format, a
robot or a jump type that is added has its page without another file. In `mkdocs.yml` the entry of a
section names its index; the section's pages are put behind it.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from markdown_text import code, table
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))  # the declarations of this very checkout

from llsrbm.errors import InputError  # noqa: E402
from llsrbm.formats import FORMATS, Format, by_purpose  # noqa: E402
from llsrbm.formats.table import quantity_rows  # noqa: E402
from llsrbm.installed import assets_directory  # noqa: E402
from llsrbm.planning.problem.placement import limits_of, make_task  # noqa: E402
from llsrbm.request import jump_types  # noqa: E402
from llsrbm.request.design import examples  # noqa: E402
from llsrbm.request.jump import Jump  # noqa: E402
from llsrbm.request.jump_types import JumpType  # noqa: E402
from llsrbm.robots import load_robot, read_robot_file  # noqa: E402
from llsrbm.robots.schema import robot_files  # noqa: E402

ANGLES = ("twist", "roll", "pitch")
ROOM = 0.1  # m between an obstacle and the feet that land behind it


class Page(NamedTuple):
    """A page of the site."""

    path: str
    text: str


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages, and name them in the navigation."""
    for index, *pages in (format_pages(), robot_pages(), type_pages()):
        for page in (index, *pages):
            files.append(File.generated(config, page.path, content=page.text))
        config.nav = _with_pages(config.nav, index.path, [page.path for page in pages])
    return files


def _with_pages(nav: Any, index: str, pages: list[str]) -> Any:
    """The navigation with a section's pages behind its index, wherever that stands in it."""
    if isinstance(nav, list):
        return [_with_pages(entry, index, pages) for entry in nav]
    if isinstance(nav, dict):
        return {
            title: [index, *pages] if entry == index else _with_pages(entry, index, pages)
            for title, entry in nav.items()
        }
    return nav


# ---- formats


def format_pages() -> list[Page]:
    """The list of formats, and a page for each."""
    index = [
        "# File formats",
        "Written by `llsrbm export`, `llsrbm.export` and the page; listed by `llsrbm formats`.",
    ]
    for purpose, formats in by_purpose().items():
        rows = [(f"[`{each.name}`]({each.name}.md)", each.title) for each in formats]
        index += [f"## {purpose.value}", table(("format", "what it is"), rows)]
    return [
        _page("formats/index.md", index),
        *(_page(f"formats/{name}.md", _format(each)) for name, each in FORMATS.items()),
    ]


def _format(each: Format) -> Iterable[str]:
    """As `llsrbm formats --format NAME` has it."""
    opens = "no"
    if each.read is not None:
        opens = "yes" if each.name in ("npz", "design") else "yes, for looking and comparing"
    elif each.name == "design":
        opens = "yes"
    taken = [f"`{name}` (default `{getattr(each.defaults, name)}`)" for name in each.options]
    yield f"# {each.name}"
    yield f"{each.title[:1].upper()}{each.title[1:]}."
    yield table(
        ("", ""),
        [
            ("name ends in", f"`{each.suffix}`" if each.suffix else "(a folder)"),
            ("holds", "plan, rollout"),
            ("options", ", ".join(taken) or "none"),
            ("can be opened", opens),
            (
                "needs",
                f'`pip install "llsrbm[{each.extra.name}]"`'
                if each.extra
                else "no further package",
            ),
        ],
    )
    yield code("", f"llsrbm export rollout.npz --format {each.name} --out jump{each.suffix}")
    yield "## Frames, units, orders"
    yield each.conventions.strip()
    if each.name in ("npz", "csv"):
        yield "## Quantities"
        yield code("text", "\n".join(quantity_rows()).strip("\n"))


# ---- robots


def robot_pages() -> list[Page]:
    """The list of robots, and a page for each."""
    rows = [
        (f"[{read_robot_file(path).title}]({name}.md)", f"`--robot {name}`")
        for name, path in robot_files().items()
    ]
    index = [
        "# Robots",
        "Robots that come with the project. To use another: [add a robot](../add_a_robot.md).",
        table(("robot", "option"), rows),
    ]
    return [
        _page("robots/index.md", index),
        *(_page(f"robots/{name}.md", _robot(name, path)) for name, path in robot_files().items()),
    ]


def _robot(name: str, path: Path) -> Iterable[str]:
    robot = load_robot(name)
    file, task = robot.file, robot.file.task
    yield f"# {file.title}"
    yield _head_comment(path)
    yield code("", f"llsrbm plan --robot {name}")
    ranges = [
        (each, _interval(getattr(task, each), "rad" if each == "twist" else "m"))
        for each in ("twist", "forward", "lateral", "height")
    ]
    legs = ", ".join(f"`{leg.name}`" for leg in robot.legs)
    yield table(
        ("", ""),
        [
            ("mass", f"{robot.mass:.1f} kg"),
            ("legs", legs),
            ("joints", ", ".join(f"`{joint}`" for joint in robot.joint_names)),
            *ranges,
        ],
    )
    yield "## Jump types that it takes"
    yield table(
        ("type", ""),
        [
            (f"[`{kind}`](../types/{kind}.md)", each.summary)
            for kind, each in jump_types.names().items()
            if _takes(name, kind)
        ],
    )
    own = [(key, design) for key, design in examples().items() if design.jump.robot == name]
    if own:
        yield "## Examples"
        yield table(("`--design`", ""), [(f"`{key}`", design.title) for key, design in own])
    yield "## Limits"
    yield f"As `llsrbm tuning --robot {name}` lists them, with the weights."
    yield table(("limit", "value", "range", "unit", "what raising it does"), _limits(robot))
    yield "## Its file"
    yield code("toml", path.read_text("utf-8"))


def _limits(robot: Any) -> list[tuple[str, ...]]:
    rows = []
    for limit, value in limits_of(robot).values():
        scale, unit = (math.degrees(1), "deg") if limit.unit == "rad" else (1.0, limit.unit)
        accepted = f"{scale * limit.lowest:.4g} to {scale * limit.highest:.4g}"
        rows.append((f"`{limit.name}`", f"{scale * value:.4g}", accepted, unit, limit.effect))
    return rows


def _takes(robot: str, kind: str) -> bool:
    """Whether a request of that type is accepted."""
    try:
        jump = Jump(robot=robot, type=kind, forward=_beyond(jump_types.load_type(kind)))
        make_task(jump_types.with_defaults(jump), load_robot(robot), None, None)
    except InputError:
        return False
    return True


def _beyond(kind: JumpType) -> float:
    """How far to jump, m: with an obstacle the feet have to land behind it."""
    far = None if kind.passes or kind.obstacle is None else kind.obstacle.far
    return 0.0 if far is None else round(far + ROOM, 2)


# ---- jump types


def type_pages() -> list[Page]:
    """The list of jump types, and a page for each."""
    kinds = jump_types.names()
    rows = [(f"[`{name}`]({name}.md)", kind.summary) for name, kind in kinds.items()]
    index = [
        "# Jump types that there are",
        "Listed by `llsrbm types`. How to write one: [jump types](../jump_types.md).",
        table(("type", "what it is"), rows),
    ]
    return [
        _page("types/index.md", index),
        *(_page(f"types/{name}.md", _type(name, kind)) for name, kind in kinds.items()),
    ]


def _type(name: str, kind: JumpType) -> Iterable[str]:
    yield f"# {kind.title}"
    yield f"{kind.summary[:1].upper()}{kind.summary[1:]}."
    robots = [robot for robot in robot_files() if _takes(robot, name)]
    yield code("", f"llsrbm plan --robot {robots[0]} --type {name}{_asked(kind)}")
    yield table(
        ("phase", "feet that stand", "time", "again with each further hop"),
        [
            (row.name, _feet(row.feet), _time(row.time), "yes" if row.each_hop else "")
            for row in kind.phase
        ],
    )
    if kind.obstacle is not None:
        near, far, height = kind.obstacle.ends(kind.default_jump())
        what, size = ("gap", "deep") if height < 0 else ("bar", "high")
        ahead = "where feet have room beside it" if kind.passes else "the foremost contact point"
        place = f"from {near:g} to {far:g} m ahead of {ahead}"
        yield f"Jumps over a {what}, {abs(height):g} m {size}, {place}."
    links = ", ".join(f"[{load_robot(robot).file.title}](../robots/{robot}.md)" for robot in robots)
    yield f"Robots: {links}."
    yield "## Its file"
    path = assets_directory() / "jump_types" / f"{name}.toml"
    yield code("toml", path.read_text("utf-8"))


def _asked(kind: JumpType) -> str:
    """The type's own options with its defaults, as on a command line."""
    lands = kind.obstacle is not None and not kind.passes
    told = f" --forward {_beyond(kind):g}" if lands else ""
    for name, value in kind.defaults.items():
        shown = math.degrees(value) if name in ANGLES else value
        told += f" --{name.replace('_', '-')} {shown:g}"
    return told


def _feet(feet: str | Sequence[str]) -> str:
    return feet if isinstance(feet, str) else ", ".join(feet)


def _time(time: str | tuple[float, float]) -> str:
    if isinstance(time, str):
        return f"`{time}` of the robot's `[timing]`"
    return f"{time[0]:g} to {time[1]:g} s"


# ---- Markdown


def _page(path: str, parts: Iterable[str]) -> Page:
    return Page(path, "\n\n".join(parts) + "\n")


def _interval(ends: Sequence[float], unit: str) -> str:
    scale, unit = (math.degrees(1), "°") if unit == "rad" else (1.0, f" {unit}")
    return f"{scale * ends[0]:.3g} to {scale * ends[1]:.3g}{unit}"


def _head_comment(path: Path) -> str:
    """The comment with which a file begins: what it is."""
    lines = []
    for line in path.read_text("utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.removeprefix("#").strip())
    return " ".join(lines)
