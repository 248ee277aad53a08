"""One meaning a colour, the same in every picture, plot, timeline and legend.

A colour says what a thing is, never which model made it: models differ by the style of a line, or
by a tint (`paler`).
"""

Rgb = tuple[int, int, int]

PLANNED: Rgb = (44, 123, 229)
SIMULATED: Rgb = (222, 96, 16)
REFERENCE: Rgb = (120, 128, 138)  # to compare with: limits, SRBM's constant inertia, the start
FORCE: Rgb = (196, 28, 140)  # of the ground and of pushes
COM: Rgb = (90, 60, 180)
FOOT: Rgb = (148, 130, 206)  # path of a foot: a tint of the CoM's
REPLANNED: Rgb = (118, 168, 0)  # a plan made in flight
TARGET: Rgb = (40, 160, 90)
BLOCK: Rgb = (150, 104, 60)
INFEASIBLE: Rgb = (220, 40, 40)

# Phases are tints, so that no phase is taken for a plan or a simulation; darker with the feet down.
TAKE_OFF: Rgb = (171, 183, 204)
FLIGHT: Rgb = (229, 234, 240)
LANDING: Rgb = (166, 198, 187)
REBOUND: Rgb = (168, 190, 196)  # between two flights: a landing and a take-off at once
STANDING: Rgb = (206, 211, 217)
GROUND: Rgb = (206, 211, 217)


def paler(colour: Rgb, share: float) -> Rgb:
    """A colour that far on its way to white, 0 to 1."""
    red, green, blue = (round(part + share * (255 - part)) for part in colour)
    return red, green, blue


def css(colour: Rgb, opacity: float = 1.0) -> str:
    """As style sheets write it."""
    return f"rgba({colour[0]},{colour[1]},{colour[2]},{opacity:g})"
