"""All commands, `llsrbm plan | simulate | export | ...`, and those that other packages add.

Exit status: 0 done, 1 it ran and failed, 2 bad input with one line on stderr.
"""

import errno
import sys
from importlib.metadata import EntryPoint, entry_points
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from llsrbm.commands.atlas import atlas_command
from llsrbm.commands.check import check_command
from llsrbm.commands.compare import compare_command
from llsrbm.commands.console import BAD_INPUT, DONE, FAILED, INTERRUPTED, print_error
from llsrbm.commands.deploy import deploy_command
from llsrbm.commands.export import export_command, formats_command, replay_command
from llsrbm.commands.identify import identify_command
from llsrbm.commands.largest import largest_command
from llsrbm.commands.library import library_app
from llsrbm.commands.listing import (
    designs_command,
    models_command,
    robots_command,
    tuning_command,
    types_command,
)
from llsrbm.commands.plan import plan_command
from llsrbm.commands.repair import repair_command
from llsrbm.commands.robot import robot_app
from llsrbm.commands.robot_sim import robot_sim_command
from llsrbm.commands.simulate import simulate_command
from llsrbm.commands.streams import OutputLost, usable_streams
from llsrbm.commands.sweep import dataset_command, sweep_command
from llsrbm.errors import Error, InputError, printable

_OF_NAMES = (errno.ENAMETOOLONG, errno.ELOOP)  # of paths that nobody can have meant
_LONGEST_PATH = 300  # characters in a message
_PLUGINS = "llsrbm.commands"  # entry points that add commands, e.g. `serve` of the application


class _Commands(TyperGroup):
    """The project's commands, and those of other packages, loaded when they are used."""

    def list_commands(self, ctx: Any) -> list[str]:
        return [*super().list_commands(ctx), *(name for name in _plugins())]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        command = super().get_command(ctx, cmd_name)
        if command is None and cmd_name in _plugins():
            command = _load(_plugins()[cmd_name])
        if command is None:
            names = ", ".join(self.list_commands(ctx))
            raise InputError(f'no command "{cmd_name}"; the commands are {names}')
        return command


app = typer.Typer(
    name="llsrbm",
    cls=_Commands,
    help="Jumps of legged robots with lump-leg single rigid body models: plan and simulate them.",
    epilog="Exit status: 0 done, 1 it ran and failed, 2 bad input.",
    add_completion=False,
    invoke_without_command=True,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def _llsrbm(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        from llsrbm.installed import package_version

        print(package_version())
        raise typer.Exit(DONE)
    if context.invoked_subcommand is None:
        print(context.get_help())


app.add_typer(robot_app)
app.add_typer(library_app)
for _command in (
    *(plan_command, simulate_command, export_command, replay_command, robots_command),
    *(models_command, types_command, tuning_command, formats_command, designs_command),
    *(
        check_command,
        repair_command,
        compare_command,
        largest_command,
        sweep_command,
        atlas_command,
    ),
    *(dataset_command, robot_sim_command, deploy_command, identify_command),
):
    app.command(_command.__name__.removesuffix("_command").replace("_", "-"))(_command)


def run(arguments: list[str] | None) -> int:
    """Run one command line and return its exit status; None: the process's own arguments."""
    with usable_streams():
        return _run(arguments)


def _run(arguments: list[str] | None) -> int:
    command = typer.main.get_command(app)
    try:
        status = command.main(args=arguments, prog_name="llsrbm", standalone_mode=False)
        sys.stdout.flush()
    except typer.TyperException as error:  # about options and arguments
        print_error(error.format_message())
        return error.exit_code
    except InputError as error:
        print_error(str(error))
        return BAD_INPUT
    except Error as error:
        print_error(str(error))
        return FAILED
    except (KeyboardInterrupt, typer.Abort):
        return INTERRUPTED
    except OutputLost as error:
        if error.reason:
            print_error(f"stdout: cannot be written: {error.reason}")
        return FAILED
    except OSError as error:
        name = printable(str(error.filename or "a file"), _LONGEST_PATH)
        print_error(f"{name}: {error.strerror or error}")
        return BAD_INPUT if error.errno in _OF_NAMES else FAILED
    return status if isinstance(status, int) else DONE


def _plugins() -> dict[str, EntryPoint]:
    return {point.name: point for point in sorted(entry_points(group=_PLUGINS))}


def _load(point: EntryPoint) -> Any:
    """The command that another package registered: a function as typer takes them."""
    try:
        function = point.load()
    except (ImportError, AttributeError) as error:
        raise Error(f'command "{point.name}" ({point.value}) cannot be loaded: {error}') from error
    single = typer.Typer(
        add_completion=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    single.command(point.name)(function)
    return typer.main.get_command(single)
