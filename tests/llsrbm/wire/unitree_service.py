"""Messages of Unitree's services, declared as its own SDK does: typed classes of the package."""

from dataclasses import dataclass

from cyclonedds.idl import IdlStruct, types
from cyclonedds.idl import annotations as annotate

PACKAGE = "unitree_api.msg.dds_"


def message(declared):
    return annotate.final(annotate.autoid("sequential")(dataclass(declared)))


@message
class RequestIdentity_(IdlStruct, typename=f"{PACKAGE}.RequestIdentity_"):
    id: types.int64
    api_id: types.int64


@message
class RequestLease_(IdlStruct, typename=f"{PACKAGE}.RequestLease_"):
    id: types.int64


@message
class RequestPolicy_(IdlStruct, typename=f"{PACKAGE}.RequestPolicy_"):
    priority: types.int32
    noreply: bool


@message
class RequestHeader_(IdlStruct, typename=f"{PACKAGE}.RequestHeader_"):
    identity: RequestIdentity_
    lease: RequestLease_
    policy: RequestPolicy_


@message
class Request_(IdlStruct, typename=f"{PACKAGE}.Request_"):
    header: RequestHeader_
    parameter: str
    binary: types.sequence[types.uint8]


@message
class ResponseStatus_(IdlStruct, typename=f"{PACKAGE}.ResponseStatus_"):
    code: types.int32


@message
class ResponseHeader_(IdlStruct, typename=f"{PACKAGE}.ResponseHeader_"):
    identity: RequestIdentity_
    status: ResponseStatus_


@message
class Response_(IdlStruct, typename=f"{PACKAGE}.Response_"):
    header: ResponseHeader_
    data: str
    binary: types.sequence[types.uint8]
