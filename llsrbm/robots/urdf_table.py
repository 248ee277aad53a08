"""The robot file's [urdf]: where the URDF is, and what is changed in it."""

from __future__ import annotations

from typing import Any, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from llsrbm.request.tables import Table, Vector, fault


class AddedFrame(Table):
    """A massless link that is added to the URDF, such as the middle of a sole on the ground.

    Attributes:
        link: of the URDF, which carries it.
        xyz, rpy: its origin, m, and its roll, pitch and yaw, rad, in that link's frame.
    """

    link: str
    xyz: Vector
    rpy: Vector = (0.0, 0.0, 0.0)


class UrdfSource(Table):
    """Where the URDF is, and what is changed in it before anything reads it.

    Attributes:
        package, path: name of the package, for example "example-robot-data", and the URDF inside
            its robots folder.
        file: the URDF relative to the robot file; instead of the other two.
        held: joint name -> angle, rad (sliding: m), at which the joint is fixed: arms, a waist, a
            neck. What it carries becomes part of the body that it hangs on.
        frames: name -> frame that is added to a link.
    """

    package: str | None = None
    path: str | None = None
    file: str | None = None
    held: dict[str, float] = Field(default_factory=dict)
    frames: dict[str, AddedFrame] = Field(default_factory=dict)

    @model_serializer(mode="wrap")
    def _without_empty_tables(self, serialise: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Files without `held` and `frames` are written as before there were such keys.

        Cached leg maps and plan files are known by this.
        """
        table: dict[str, Any] = serialise(self)
        return {
            key: value
            for key, value in table.items()
            if key not in ("held", "frames") or value != {}
        }

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        given = (self.package is not None, self.path is not None, self.file is not None)
        if given not in ((True, True, False), (False, False, True)):
            raise fault('expected either "package" and "path", or "file"')
        return self

    def installed(self) -> tuple[str, str]:
        """Package and path; only where `file` is None."""
        if self.package is None or self.path is None:
            raise ValueError("the URDF lies beside the robot file")
        return self.package, self.path
