"""Overlays, drawn besides the robot: classes, each with its box, its colours, its nodes.

`OVERLAYS` names them all. A new overlay is a class in a file here, and nothing else.
"""

from importlib import import_module
from pkgutil import iter_modules

from app.picture.drawing import Group, Overlay

__all__ = ["AT_FIRST", "OVERLAYS"]


def _found() -> list[type[Overlay]]:
    modules = [import_module(f"{__name__}.{each.name}") for each in iter_modules(__path__)]
    classes = [
        value
        for module in modules
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, Overlay)
        and value.__module__ == module.__name__
    ]
    order = list(Group)
    return sorted(classes, key=lambda overlay: (order.index(overlay.group), overlay.place))


OVERLAYS: dict[str, type[Overlay]] = {overlay.name: overlay for overlay in _found()}
"""By name, in the order of their boxes."""

AT_FIRST = frozenset(name for name, overlay in OVERLAYS.items() if overlay.at_first)
"""Names of those that are drawn when a page opens."""
