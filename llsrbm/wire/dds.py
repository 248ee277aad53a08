"""A robot's topics over DDS (Eclipse Cyclone DDS): the player's end, and a simulated robot's.

Types are made from the layouts, which also serialise the samples in the package's place.
"""

import socket
import time
from collections import deque
from functools import cache
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from cyclonedds.core import (
    DDSException,
    InstanceState,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import annotations as annotate
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.errors import Error, InputError
from llsrbm.robots import Robot
from llsrbm.wire.layout import Layout, Record
from llsrbm.wire.link import Link
from llsrbm.wire.motion_switcher import MotionSwitcher, SimulatedSwitcher
from llsrbm.wire.unitree import UnitreeMessages
from llsrbm.wire.unitree_layouts import COMMAND_TOPIC, STATE_TOPIC, STRUCTURES

# What this system calls it; everywhere `lo` may be asked for.
LOOPBACK = next((name for _, name in socket.if_nameindex() if name in ("lo", "lo0")), "lo")
ROBOT_DOMAIN, SIMULATOR_DOMAIN = 0, 1  # of the maker's robots, and of its simulator
# Samples that a reader keeps until they are taken, a second's: one that keeps the last alone and is
# late now and then loses 4 %.
_KEPT = 500
_LISTENS_FOR = 0.3  # s: a controller writes every 2 ms
_TYPES: dict[str, Any] = {
    "u1": types.uint8,
    "u2": types.uint16,
    "u4": types.uint32,
    "i2": types.int16,
    "i4": types.int32,
    "f4": types.float32,
}
_array: Any = types.array
_CDR = Policy.DataRepresentation(use_cdrv0_representation=True)  # version 1, as `Layout` has it


# Whatever a robot's writers promise, readers ask for less; they hear nothing of their own end.
_HEARS = Qos(
    _CDR,
    Policy.History.KeepLast(_KEPT),
    Policy.Reliability.BestEffort,
    Policy.IgnoreLocal.Participant,
)


@cache
def sample_type(layout: Layout) -> Any:
    """The package's type of a layout: the names, types and order that DDS compares.

    Its samples hold a record; the layout takes the place of the package's own serialiser.
    """
    made = _structure(layout.type_name, layout.dtype)

    def keep(sample: Any, record: Record) -> None:
        sample.record = record

    def serialize(sample: Any, **_: Any) -> bytes:
        return layout.to_wire(sample.record)

    def deserialize(of: type[Any], /, data: bytes, **_: Any) -> Any:
        return of(layout.from_wire(data))

    def no_key(of: type[Any], /, data: bytes, **_: Any) -> None:
        """Key of the sample that marks a writer's end: these types have none."""

    made.__init__, made.serialize, made.deserialize = keep, serialize, classmethod(deserialize)
    made.deserialize_key = classmethod(no_key)
    return made


def _structure(type_name: str, dtype: np.dtype[Any]) -> Any:
    package, _, name = type_name.rpartition(".")
    fields: dict[str, Any] = {}
    for field in dtype.names or ():
        one = dtype[field]
        shape = one.subdtype[1][0] if one.subdtype else 0
        one = one.subdtype[0] if one.subdtype else one
        if one.fields is None:
            kind = _TYPES[one.str[1:]]
        else:
            kind = _structure(f"{package}.{STRUCTURES[field]}", one)
        fields[field] = _array[kind, shape] if shape else kind
    made: Any = make_idl_struct(name, type_name, fields)
    annotate.final(made)
    annotate.autoid("sequential")(made)
    return made


def default_domain(interface: str) -> int:
    """The domain where one expects a robot on an interface: on `LOOPBACK` there are simulators."""
    return SIMULATOR_DOMAIN if interface == LOOPBACK else ROBOT_DOMAIN


# Domains live as long as the process: each can be configured once in it.
_domains: dict[int, tuple[str, Domain]] = {}


def _participant(interface: str, domain: int) -> DomainParticipant:
    """A member of a domain on one network interface.

    Raises `InputError`: there is no such interface, or the process uses another one.
    """
    names = [name for _, name in socket.if_nameindex()]
    if interface not in names:
        raise InputError(f'interface: expected one of {", ".join(names)}, got "{interface}"')
    if not 0 <= domain <= 230:
        raise InputError(f"domain: expected 0 to 230, got {domain}")
    if domain not in _domains:
        _domains[domain] = interface, _configured(interface, domain)
    known, _ = _domains[domain]
    if known != interface:
        raise InputError(f"interface: domain {domain} is on {known} in this process already")
    return DomainParticipant(domain)


def _configured(interface: str, domain: int) -> Domain:
    """The domain on that interface, by the package's defaults as the maker's own programs have it.

    On the loopback other processes are looked for port by port, too: it may have no multicast.
    """
    general = f"<Interfaces><NetworkInterface name={quoteattr(interface)}/></Interfaces>"
    discovery = ""
    if interface == LOOPBACK:
        general += "<AllowMulticast>spdp</AllowMulticast>"  # to be found by, and for nothing else
        discovery = (
            "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
            '<Peers><Peer Address="127.0.0.1"/></Peers></Discovery>'
        )
    inside = f"<General>{general}</General>{discovery}"
    return Domain(domain, f"<CycloneDDS><Domain>{inside}</Domain></CycloneDDS>")


class _Ends:
    """A writer of one topic and a reader of another, on one interface; see `DdsLink`."""

    def __init__(
        self,
        interface: str,
        domain: int | None,
        written: tuple[str, Layout],
        read: tuple[str, Layout],
    ) -> None:
        interface = LOOPBACK if interface == "lo" else interface
        domain = default_domain(interface) if domain is None else domain
        self.place = f"interface {interface}, domain {domain}"
        self.on_loopback = interface == LOOPBACK
        try:
            participant = _participant(interface, domain)
            topics = [Topic(participant, name, sample_type(made)) for name, made in (written, read)]
            self._writer = DataWriter(participant, topics[0], Qos(_CDR))
            self._reader = DataReader(participant, topics[1], _HEARS)
            # Of the written topic, what others write.
            self._beside = DataReader(participant, topics[0], _HEARS)
        except DDSException as error:
            raise Error(f"{self.place}: {error}") from error
        self._type = sample_type(written[1])
        unread = ReadCondition(
            self._reader, ViewState.Any | InstanceState.Any | SampleState.NotRead
        )
        self._waiting = WaitSet(participant)
        self._waiting.attach(unread)
        self.participant, self._unread = participant, unread

    def write(self, record: Record) -> None:
        self._writer.write(self._type(record))

    def taken(self, timeout: float) -> list[Record]:
        """All that has arrived and was not taken yet, or arrives first within `timeout` s."""
        samples = self._reader.take(_KEPT)
        if not samples and self._waiting.wait(duration(seconds=timeout)) > 0:
            samples = self._reader.take(_KEPT)
        return [sample.record for sample in samples if hasattr(sample, "record")]

    def others(self) -> int:
        """The samples that others have written to the same topic since the last call."""
        return len(self._beside.take(_KEPT))

    def matched(self) -> bool:
        """True if somebody reads what is written."""
        return len(self._writer.get_matched_subscriptions()) > 0

    def close(self) -> None:
        del self._waiting, self._unread, self._beside, self._reader, self._writer, self.participant


class DdsLink(Link):
    """The player's end of a Unitree robot's wire, real or simulated.

    `interface`: the network interface towards it; `domain`: None for that of `default_domain`.
    Raises `InputError`: no such interface, or no such messages of this robot; `Error`: DDS fails.
    """

    def __init__(self, robot: Robot, interface: str, domain: int | None = None) -> None:
        self._messages = UnitreeMessages(robot)
        self._ends = _Ends(
            interface,
            domain,
            (COMMAND_TOPIC, self._messages.command_layout),
            (STATE_TOPIC, self._messages.state_layout),
        )
        self._arrived: deque[Record] = deque()

    def take_over(self, *, released: bool = False) -> str:
        """Have the robot's own controller end, and make sure that nobody else commands the motors.

        `released`: it was ended by hand; else a robot's motion switcher has to answer, on the
        loopback one that is there. Returns what was done, one line.

        Raises `Error`: no answer, a controller that does not end, or commands of others.
        """
        switcher = MotionSwitcher(self._ends.participant)
        mode = switcher.mode()
        done = "the robot runs no controller of its own"
        if mode:
            switcher.release()
            done = f'the robot\'s own controller "{mode}" was released'
        elif mode is None and not released and not self._ends.on_loopback:
            raise Error(
                f"{self._ends.place}: no motion switcher of the robot answers, so its own "
                "controller may still command the motors; expected an answer, or --released after "
                "it was ended by hand"
            )
        elif mode is None:
            done = "no motion switcher answers"
        self.others()
        time.sleep(_LISTENS_FOR)
        heard = self.others()
        if heard:
            raise Error(
                f"{self._ends.place}: another program writes {COMMAND_TOPIC} ({heard} commands in "
                f"{_LISTENS_FOR:g} s); expected none: two would fight for the motors"
            )
        return f"{done}; nobody else commands the motors"

    def others(self) -> int:
        """See `Link`."""
        return self._ends.others()

    def send(self, command: MotorCommand) -> None:
        """Send a command; it holds until the next one."""
        self._ends.write(self._messages.pack_command(command))

    def receive(self, timeout: float) -> Readings | None:
        """The next reading that was not received yet; None if none arrives within `timeout` s."""
        if not self._arrived:
            self._arrived.extend(self._ends.taken(timeout))
        if not self._arrived:
            return None
        record = self._arrived.popleft()
        self.health = self._messages.health(record)
        return self._messages.readings(record)

    def close(self) -> None:
        """Stop sending and receiving."""
        self._ends.close()


class DdsRobot:
    """The robot's end of the same wire, for a simulated one; arguments and errors as `DdsLink`.

    `refused`: commands with a wrong checksum, which robots do not follow; `place`: where it is.
    `held_by`: name of a controller of the robot's own, which writes commands until the robot's
    motion switcher is told to release it; "" for none.
    """

    def __init__(
        self, robot: Robot, interface: str, domain: int | None = None, held_by: str = ""
    ) -> None:
        self._messages = UnitreeMessages(robot)
        self._ends = _Ends(
            interface,
            domain,
            (STATE_TOPIC, self._messages.state_layout),
            (COMMAND_TOPIC, self._messages.command_layout),
        )
        self.refused, self.place = 0, self._ends.place
        participant = self._ends.participant
        self._switcher = SimulatedSwitcher(participant, held_by)
        topic = Topic(participant, COMMAND_TOPIC, sample_type(self._messages.command_layout))
        self._own = DataWriter(participant, topic, Qos(_CDR))
        still = np.zeros(len(robot.joint_names))
        stands = MotorCommand(robot.posture[7:], still, still, still, still)
        self._holds = sample_type(self._messages.command_layout)(
            self._messages.pack_command(stands)
        )

    def publish(self, readings: Readings, voltage: float) -> None:
        """Send readings; `voltage`: share of the battery's."""
        self._ends.write(self._messages.pack_state(readings, voltage))
        self._switcher.serve()
        if self._switcher.mode:
            self._own.write(self._holds)

    def commands(self, timeout: float) -> list[MotorCommand]:
        """The commands that have arrived, or arrive within `timeout` s: the first ends the wait."""
        commands = [self._messages.command(record) for record in self._ends.taken(timeout)]
        self.refused += commands.count(None)
        return [command for command in commands if command is not None]

    def close(self) -> None:
        """Stop sending and receiving."""
        del self._own, self._switcher
        self._ends.close()
