"""Words for whether a plan is certified, and why one is a draft."""

from llsrbm.certificate import stated
from llsrbm.motion.plan import Plan
from llsrbm.motion.solve_report import UNTRIED


def certificate_words(plan: Plan) -> str:
    """Whether the plan's certificate holds; if not, why the plan is a draft."""
    if not plan.solved:
        return "none: no plan was found"
    return "holds" if plan.certified else f"none that holds, a draft: {draft_reason(plan)}"


def draft_reason(plan: Plan) -> str:
    """Why a plan is not certified, in words; "" if it is."""
    found = stated(plan)
    if found is None:
        if plan.refined:
            return "it was not checked"
        if plan.jump.payload:
            return "it is of the robot without its payload"
        if plan.refinement is None:
            return "its drives were looked at in knots only"
        if plan.refinement.status == UNTRIED:
            return "no whole body's plan is made where a body that turns over lands on all feet"
        return "the whole body's plan was not found"
    unknown = [each for each in found if each.holds is None]
    names = ", ".join(each.name.replace("_", " ") for each in found.broken or unknown)
    if found.broken:
        return f"its certificate does not hold: {names}"
    return f"its certificate does not know: {names}" if unknown else ""
