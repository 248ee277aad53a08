"""`llsrbm robot`: a first robot file from a URDF, and a robot's table of solved jumps."""

import os
import re
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from llsrbm.commands import console
from llsrbm.errors import InputError, RobotFileError

robot_app = typer.Typer(name="robot", rich_markup_mode=None)


@robot_app.callback()
def _robot() -> None:
    """Robot files: write a first one from a URDF; learn jumps that later ones begin from."""


@robot_app.command("new")
def new_command(
    urdf: Annotated[
        str,
        typer.Argument(
            metavar="URDF",
            help="A file, or PACKAGE:PATH of one in a package of robot data, such as "
            "example-robot-data:b1_description/urdf/b1.urdf.",
        ),
    ],
    name: Annotated[
        str | None, typer.Option(help="Short name, lower case; the URDF's file name if left out.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Where to write it; NAME.toml here if left out.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
) -> int:
    """Write a robot file: measured from the URDF, the rest guessed and marked so."""
    from llsrbm.robots import draft, read_robot_file
    from llsrbm.robots.drives.stated import known_in_words
    from llsrbm.robots.urdf import package_share

    package, colon, inside = urdf.partition(":")
    if colon and not Path(urdf).exists():
        path = package_share(package, Path(urdf)) / package / "robots" / inside
        table = {"package": package, "path": inside}
    else:
        path = Path(urdf).absolute()
        table = {}
    if not path.is_file():
        raise InputError(f"{urdf}: no such file; expected a URDF")
    name = name or re.sub(r"[^a-z0-9_-]+", "_", path.stem.lower()).strip("_-") or "robot"
    if not re.fullmatch(r"[a-z0-9][a-z0-9_-]*", name):
        raise InputError(f"--name {name}: expected lower case letters, digits, - and _")
    out = Path(f"{name}.toml") if out is None else out
    if out.exists() and not force:
        raise InputError(f"{out}: there is a file already; expected --force to replace it")
    anatomy = draft.read_anatomy(path)
    proposal = draft.propose(anatomy)
    table = table or draft.urdf_beside(path, out)
    _write_checked(out, draft.robot_file_text(name, table, anatomy, proposal))
    arms = f", {len(anatomy.arms)} arms of {len(anatomy.arms[0].joint_ids)}" if anatomy.arms else ""
    print(f"{out}: {len(anatomy.names)} legs of {len(anatomy.joint_ids[0])} joints{arms}")
    print(f"  feet {', '.join(anatomy.feet)}; hips {', '.join(anatomy.hips)}")
    if anatomy.held:
        first = ", ".join([*anatomy.held][:3]) + (", ..." if len(anatomy.held) > 3 else "")
        joints = "1 joint" if len(anatomy.held) == 1 else f"{len(anatomy.held)} joints"
        limb = "limb" if anatomy.arms else "leg"
        print(f"  guessed urdf.held: {joints} of no {limb} ({first})")
    if anatomy.frames:
        where = "in the middle of their soles" if anatomy.has_soles else "at the ends of shanks"
        print(f"  guessed urdf.frames: {', '.join(anatomy.frames)} {where}")
    print(f"  drives: {known_in_words(read_robot_file(out))}")
    for key, reason in proposal.guessed.items():
        print(f"  guessed {key}: {reason}")
    for key, reason in proposal.left_out.items():
        print(f"  left out {key}: {reason}")
    print(f"try it: llsrbm simulate --robot {out} --twist 45, and docs/add_a_robot.md")
    return console.DONE


@robot_app.command("learn")
def learn_command(
    robot: Annotated[str, typer.Argument(metavar="ROBOT", help="A robot's name, or its file.")],
    jumps: Annotated[int, typer.Option(min=16, help="Requests that are looked at.")] = 120,
    out: Annotated[
        Path | None, typer.Option(help="The table's file; the robot's in the cache if left out.")
    ] = None,
) -> int:
    """Solve jumps all over the robot's range, so that later ones begin from those nearby.

    The page's sliders show by them what can be planned, and its atlas shows them. The first time it
    takes some minutes; started again it goes on from what is there.
    """
    from llsrbm.analysis.learning import learn
    from llsrbm.robots import load_robot

    with console.counting("jumps") as show:
        path, table = learn(load_robot(robot), jumps, out, show)
    megabytes = path.stat().st_size / 1e6
    found = table.outcomes
    looked_at = len(found.requests) + len(found.refused)
    print(f"{path}: {len(found.requests)} of {looked_at} jumps, {megabytes:.1f} MB")
    return console.DONE


def _write_checked(out: Path, text: str) -> None:
    """Write a robot file that can be loaded; another one leaves `out` as it is."""
    from llsrbm.robots import load_robot

    try:
        handle, name = tempfile.mkstemp(dir=out.absolute().parent, suffix=".toml")
        os.close(handle)
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror})") from error
    draft = Path(name)
    try:
        draft.write_text(text, encoding="utf-8")
        load_robot(name)
        draft.chmod(0o644)
        draft.replace(out)
    except RobotFileError as error:
        raise RobotFileError(str(error).replace(name, str(out))) from error
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror})") from error
    finally:
        draft.unlink(missing_ok=True)
