"""First robot files of URDFs that come with a package, each written once a run."""

import io
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from llsrbm.cli import main
from llsrbm.robots import Robot, load_robot

PACKAGE = "example-robot-data"
URDFS = {
    "a1": "a1_description/urdf/a1.urdf",
    "anymal_c": "anymal_c_simple_description/urdf/anymal.urdf",
    "go1": "go1_description/urdf/go1.urdf",
    "g1": "g1_description/urdf/g1_29dof_rev_1_0.urdf",
    "solo12": "solo_description/robots/solo12.urdf",
    "talos": "talos_data/robots/talos_reduced.urdf",
}
_FOLDER = TemporaryDirectory(prefix="first-files-")


@dataclass(frozen=True)
class FirstFile:
    robot: Robot
    text: str
    said: str


@cache
def first_file(name: str) -> FirstFile:
    """What `llsrbm robot new` writes and prints of a robot's URDF."""
    return written(Path(_FOLDER.name) / f"{name}.toml", f"{PACKAGE}:{URDFS[name]}")


def written(path: Path, urdf: str) -> FirstFile:
    said = io.StringIO()
    with redirect_stdout(said):
        assert main(["robot", "new", urdf, "--name", path.stem, "--out", str(path)]) == 0
    return FirstFile(load_robot(str(path)), path.read_text(), said.getvalue())
