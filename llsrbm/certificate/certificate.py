"""The certificate: all findings of a motion."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from llsrbm.certificate.contacts import ContactForce, Friction, Slip
from llsrbm.certificate.distances import Clearance, SelfDistance
from llsrbm.certificate.dynamics import Dynamics
from llsrbm.certificate.finding import Check, Finding, Profile
from llsrbm.certificate.joints import JointPosition, JointSpeed, JointTorque, TorqueAtSpeed
from llsrbm.certificate.power import (
    BatteryCurrent,
    DrivePower,
    PowerForecast,
    Regeneration,
    WindingHeat,
)
from llsrbm.certificate.sampled_motion import AnyMotion, SampledMotion, sampled
from llsrbm.errors import InputError, RobotFileError
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.messages import check_kind, look_up
from llsrbm.robots.robot import Robot

_Own = TypeVar("_Own", bound=Plan | Rollout)

CHECKS: tuple[type[Check], ...] = (
    *(JointPosition, JointSpeed, JointTorque, TorqueAtSpeed),
    *(Regeneration, BatteryCurrent, WindingHeat),
    *(Friction, ContactForce, Slip),
    *(SelfDistance, Clearance),
    Dynamics,
)


@dataclass(frozen=True)
class Certificate:
    """Findings of all checks, in the order of `CHECKS`; `certificate["friction"]` is one.

    `power`: what the motion asks of drives and battery, where it was sampled for it; `profiles`:
    check -> what it finds along the motion, where that is known.
    """

    findings: tuple[Finding, ...]
    power: PowerForecast = field(default_factory=PowerForecast)
    profiles: Mapping[str, Profile] = field(default_factory=dict, compare=False)

    def __iter__(self) -> Iterator[Finding]:
        return iter(self.findings)

    def __getitem__(self, name: str) -> Finding:
        return look_up("check", name, {found.name: found for found in self.findings})

    @property
    def holds(self) -> bool | None:
        """False if a check does not hold; None if none of that kind, but some are not known."""
        held = [found.holds for found in self.findings]
        if False in held:
            return False
        return None if None in held else True

    @property
    def broken(self) -> tuple[Finding, ...]:
        """Findings that do not hold."""
        return tuple(found for found in self.findings if found.holds is False)

    def as_dict(self) -> dict[str, Any]:
        """Check -> its finding as plain data; SI units, null for what is not known."""
        return {found.name: found.as_dict() for found in self.findings}


def certify(motion: AnyMotion, robot: Robot | None = None) -> Certificate:
    """Check a plan, a rollout or another tool's motion at 1 kHz on the robot's plain URDF.

    Args:
        motion: what is checked.
        robot: the one that a plan names, with other drives; None: as its file has it.

    Raises:
        InputError: the robot has other joints by now than the motion; it is no motion.
        RobotFileError: the robot is not there.
    """
    return certify_stretches(sampled(motion, robot))


def certify_stretches(stretches: Iterable[SampledMotion]) -> Certificate:
    """Check a motion that comes in stretches, each from the last instant of the one before."""
    checks, forecast = [check() for check in CHECKS], PowerForecast()
    for stretch in stretches:
        for check in checks:
            check.take(stretch)
        power = DrivePower.of(stretch)
        if power is not None:
            forecast = forecast.then(power.forecast())
    return Certificate(
        tuple(check.finding for check in checks),
        forecast,
        {check.name: profile for check in checks if (profile := check.profile) is not None},
    )


def certified(motion: _Own, robot: Robot | None = None) -> _Own:
    """The plan or rollout with its certificate, which its file and exports then carry.

    `robot`: of `certify`.

    As it is if it has one; a plan that failed, or whose robot is not there or has other joints by
    now, stays without.

    Raises:
        InputError: it is neither.
    """
    check_kind("motion", motion, Plan | Rollout, "a Plan or a Rollout")
    if motion.certificate is not None or (isinstance(motion, Plan) and not motion.solved):
        return motion
    try:
        return replace(motion, certificate=certify(motion, robot).as_dict())
    except (InputError, RobotFileError):
        return motion


def stated(motion: Plan | Rollout) -> Certificate | None:
    """The certificate that a plan or a rollout carries; None: none."""
    if motion.certificate is None:
        return None
    found = motion.certificate.items()
    return Certificate(tuple(Finding(name=name, **values) for name, values in found))
