"""The motion switcher of Unitree's robots: which controller of their own runs, and how it is ended.

A service of Go2, B2, H1 and G1 over DDS: a request names an operation by its number, the response
has the request's identity, a status and JSON. While a controller of the robot's own runs it writes
the topic of motor commands, too.
"""

import json
import time
from typing import Any

from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import annotations as annotate
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from llsrbm.errors import Error

CHECK_MODE, RELEASE_MODE = 1001, 1003  # numbers of operations
UNKNOWN_OPERATION = 3203  # status, as the maker's servers have it
FOUND_WITHIN = 2.0  # s until which a service has to be found
_ANSWERS_WITHIN, _ATTEMPTS = 1.0, 3  # s; a request or its response may be lost
_ENDS_WITHIN = 10.0  # s until a released controller has ended
_POLL = 0.02  # s

_SERVICE = "rt/api/motion_switcher/"
_SHARED = (
    Policy.DataRepresentation(use_cdrv0_representation=True),
    Policy.History.KeepLast(16),
)
_WRITES = Qos(*_SHARED, Policy.Reliability.Reliable(1_000_000_000))
_HEARS = Qos(*_SHARED, Policy.Reliability.BestEffort)  # whatever the other end promises


def _structure(name: str, **fields: Any) -> Any:
    made: Any = make_idl_struct(name, f"unitree_api.msg.dds_.{name}", fields)
    annotate.final(made)
    annotate.autoid("sequential")(made)
    return made


_sequence: Any = types.sequence
_bytes = _sequence[types.uint8]
_Identity = _structure("RequestIdentity_", id=types.int64, api_id=types.int64)
_Lease = _structure("RequestLease_", id=types.int64)
_Policy = _structure("RequestPolicy_", priority=types.int32, noreply=bool)
_Status = _structure("ResponseStatus_", code=types.int32)
_RequestHeader = _structure("RequestHeader_", identity=_Identity, lease=_Lease, policy=_Policy)
_ResponseHeader = _structure("ResponseHeader_", identity=_Identity, status=_Status)
Request = _structure("Request_", header=_RequestHeader, parameter=str, binary=_bytes)
Response = _structure("Response_", header=_ResponseHeader, data=str, binary=_bytes)


class MotionSwitcher:
    """The service, asked by a member of the robot's domain."""

    def __init__(self, participant: DomainParticipant) -> None:
        requests = Topic(participant, f"{_SERVICE}request", Request)
        responses = Topic(participant, f"{_SERVICE}response", Response)
        self._writer = DataWriter(participant, requests, _WRITES)
        self._reader = DataReader(participant, responses, _HEARS)

    def mode(self) -> str | None:
        """Name of the controller of its own that the robot runs, "" for none; None: no service
        answers. Raises `Error`: it refuses.
        """
        answer = self._call(CHECK_MODE)
        if answer is None:
            return None
        try:
            return str(json.loads(answer)["name"])
        except (ValueError, LookupError, TypeError) as error:
            raise Error(
                "the robot's motion switcher answers what cannot be read; expected JSON with the "
                f"name of a mode, got {answer!r:.80}"
            ) from error

    def release(self) -> None:
        """Have that controller end, and wait until it has. Raises `Error`: it does not."""
        until = time.monotonic() + _ENDS_WITHIN
        while time.monotonic() < until:
            self._call(RELEASE_MODE)
            if self.mode() == "":
                return
            time.sleep(0.2)
        raise Error(
            f"the robot's own controller has not ended {_ENDS_WITHIN:.0f} s after it was released; "
            "expected the robot lying, and its remote control at hand"
        )

    def _call(self, operation: int) -> str | None:
        """The data of a response; None: there is none."""
        found_until = time.monotonic() + FOUND_WITHIN
        while not self._writer.get_matched_subscriptions():
            if time.monotonic() > found_until:
                return None
            time.sleep(_POLL)
        for _ in range(_ATTEMPTS):
            number = time.monotonic_ns()
            header = _RequestHeader(_Identity(number, operation), _Lease(0), _Policy(0, False))
            self._writer.write(Request(header, "{}", []))
            until = time.monotonic() + _ANSWERS_WITHIN
            while time.monotonic() < until:
                for response in self._reader.take(16):
                    if isinstance(response, Response) and response.header.identity.id == number:
                        return _data(response)
                time.sleep(_POLL)
        return None


def _data(response: Any) -> str:
    code = response.header.status.code
    if code:
        raise Error(f"the robot's motion switcher refuses with status {code}; expected 0")
    return str(response.data)


class SimulatedSwitcher:
    """The service of a simulated robot; `mode`: the controller of its own that it runs, or ""."""

    def __init__(self, participant: DomainParticipant, mode: str) -> None:
        self.mode = mode
        requests = Topic(participant, f"{_SERVICE}request", Request)
        responses = Topic(participant, f"{_SERVICE}response", Response)
        self._reader = DataReader(participant, requests, _HEARS)
        self._writer = DataWriter(participant, responses, _WRITES)

    def serve(self) -> None:
        """Answer all requests that have arrived."""
        for request in self._reader.take(16):
            if not isinstance(request, Request):  # the end of somebody who asked
                continue
            identity, data, code = request.header.identity, "", 0
            match identity.api_id:
                case operation if operation == CHECK_MODE:
                    data = json.dumps({"form": "0", "name": self.mode})
                case operation if operation == RELEASE_MODE:
                    self.mode = ""
                case _:
                    code = UNKNOWN_OPERATION
            self._writer.write(Response(_ResponseHeader(identity, _Status(code)), data, []))
