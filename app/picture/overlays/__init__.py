"""Overlays, drawn besides the robot, one file each; `OVERLAYS` names them for the page's boxes.

A new overlay is a class in a file of its own and its place in `OVERLAYS`.
"""

from __future__ import annotations

from app.picture.drawing import Overlay
from app.picture.overlays.angular_momentum import AngularMomentum
from app.picture.overlays.centre_of_mass import CentreOfMass
from app.picture.overlays.centre_of_pressure import CentreOfPressure
from app.picture.overlays.collision_shapes import CollisionShapes
from app.picture.overlays.forces import Forces
from app.picture.overlays.friction_pyramids import FrictionPyramids
from app.picture.overlays.ghosts import Ghosts
from app.picture.overlays.inertia_ellipsoids import InertiaEllipsoids
from app.picture.overlays.landing_marks import LandingMarks
from app.picture.overlays.landing_region import LandingRegion
from app.picture.overlays.link_frames import LinkFrames
from app.picture.overlays.new_plans import NewPlans
from app.picture.overlays.pushes import Pushes
from app.picture.overlays.reach import FeetReach
from app.picture.overlays.support_polygon import SupportPolygon
from app.picture.overlays.trails import Trails

__all__ = ["AT_FIRST", "OVERLAYS"]

OVERLAYS: dict[str, type[Overlay]] = {
    overlay.name: overlay
    for overlay in (
        InertiaEllipsoids,
        CentreOfMass,
        Forces,
        Trails,
        Ghosts,
        LandingMarks,
        Pushes,
        NewPlans,
        LandingRegion,
        FrictionPyramids,
        SupportPolygon,
        CentreOfPressure,
        AngularMomentum,
        FeetReach,
        LinkFrames,
        CollisionShapes,
    )
}
"""By name, in the order of their boxes."""

AT_FIRST = frozenset(name for name, overlay in OVERLAYS.items() if overlay.at_first)
"""Names of those that are drawn when a page opens."""
