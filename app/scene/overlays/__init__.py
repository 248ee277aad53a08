"""Overlays, drawn besides the robot, one file each; `OVERLAYS` names them for the page's boxes.

A new overlay is a class in a file of its own and its place in `OVERLAYS`.
"""

from __future__ import annotations

from app.scene.drawing import Overlay
from app.scene.overlays.angular_momentum import AngularMomentum
from app.scene.overlays.centre_of_mass import CentreOfMass
from app.scene.overlays.centre_of_pressure import CentreOfPressure
from app.scene.overlays.collision_shapes import CollisionShapes
from app.scene.overlays.forces import Forces
from app.scene.overlays.friction_pyramids import FrictionPyramids
from app.scene.overlays.ghosts import Ghosts
from app.scene.overlays.inertia_ellipsoids import InertiaEllipsoids
from app.scene.overlays.landing_marks import LandingMarks
from app.scene.overlays.landing_region import LandingRegion
from app.scene.overlays.link_frames import LinkFrames
from app.scene.overlays.new_plans import NewPlans
from app.scene.overlays.pushes import Pushes
from app.scene.overlays.reach import FeetReach
from app.scene.overlays.support_polygon import SupportPolygon
from app.scene.overlays.trails import Trails

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
