"""`llsrbm largest`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import NotConverged

if TYPE_CHECKING:
    from llsrbm.largest_jump import Largest


@options.with_jump_options
def largest_command(
    context: typer.Context,
    component: Annotated[
        str,
        typer.Option(
            help="twist or lateral (left), twist-right, lateral-right, forward, backward, up, down."
        ),
    ],
    requested: Mapping[str, Any],
    design: options.DesignOption = None,
    weight: options.Weights = None,
    limit: options.Limits = None,
    out: options.Out = None,
    as_json: options.AsJson = False,
) -> int:
    """Find how far, how high or by how much a robot jumps, and the limit that stops more.

    Everything else is as requested.
    Each plan begins from the one before, and counts if its certificate holds. It takes seconds to
    minutes. The exit status is 1 where the request itself has no such plan.
    """
    del context  # of the options that only count where they are given
    with console.result_stream(as_json=as_json) as stdout:
        import llsrbm
        from llsrbm.largest_jump import DIRECTIONS

        request = options.requested_design(design, requested)
        tuning = options.requested_tuning(request.tuning, weight, limit)
        summary: dict[str, Any] = {"robot": request.jump.robot, "component": component}
        try:
            found = llsrbm.largest(
                request.jump,
                component,
                weights=tuning.weights,
                limits=tuning.limits,
                progress=console.show_planning,
            )
        except NotConverged as error:
            none = {"value": None, "unit": DIRECTIONS[component].unit}
            if as_json:
                summary |= none | {"limit": error.reason or str(error)}
                console.print_result(summary, {}, stdout, as_json=True)
            raise  # one line, exit status 1
        if out is not None:
            llsrbm.with_feedback(found.plan).save(out)
        summary |= {"value": found.value, "unit": found.unit, "limit": found.limit}
        summary |= {"request": found.plan.jump.as_dict()}
        lines = {} if as_json else _description(found)
        console.print_result(summary, lines, stdout, as_json=as_json)
    return console.DONE


def _description(found: Largest) -> dict[str, str]:
    from llsrbm.largest_jump import DIRECTIONS

    words = DIRECTIONS[found.component].in_words(found.value)
    return {
        "Request": options.in_words(found.plan.jump),
        "Largest": f"{found.component} {words}",
        "Limit": found.limit,
    }
