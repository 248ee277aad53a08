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
    component: Annotated[str, typer.Option(help="twist, forward, backward, lateral, up or down.")],
    requested: Mapping[str, Any],
    design: options.DesignOption = None,
    weight: options.Weights = None,
    limit: options.Limits = None,
    out: options.Out = None,
    as_json: options.AsJson = False,
) -> int:
    """Find how far, how high or by how much a robot jumps, and the limit that stops more.

    Everything else is as requested; the ranges of the robot's file do not bound the component.
    Each plan begins from the one before, and counts if its certificate holds. It takes seconds to
    minutes. The exit status is 1 where the request itself has no such plan.
    """
    del context  # of the options that only count where they are given
    with console.result_stream(as_json=as_json) as stdout:
        import llsrbm

        request = options.requested_design(design, requested)
        tuning = options.requested_tuning(request.tuning, weight, limit)
        found, failure = None, None
        try:
            found = llsrbm.largest(
                request.jump,
                component,
                weights=tuning.weights,
                limits=tuning.limits,
                progress=console.show_planning,
            )
        except NotConverged as error:
            failure = error
        if found is not None and out is not None:
            llsrbm.with_feedback(found.plan).save(out)
        summary: dict[str, Any] = {"robot": request.jump.robot, "component": component}
        if found is not None:
            plain = {"value": found.value, "unit": found.unit, "limit": found.limit}
            summary |= plain | {"request": found.plan.jump.as_dict()}
        elif failure is not None:
            summary |= {"value": None, "unit": None, "limit": failure.reason or str(failure)}
        lines = {} if found is None else _description(found)
        if as_json or lines:
            console.print_result(summary, lines, stdout, as_json=as_json)
        if failure is not None:
            console.print_error(str(failure))
    return console.DONE if failure is None else console.FAILED


def _description(found: Largest) -> dict[str, str]:
    from llsrbm.largest_jump import DIRECTIONS

    words = DIRECTIONS[found.component].in_words(found.value)
    return {
        "Request": options.in_words(found.plan.jump),
        "Largest": f"{found.component} {words}",
        "Limit": found.limit,
    }
