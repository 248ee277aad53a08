"""The MJCF of a robot in its surroundings: what our simulation runs, to look at and to simulate."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.cluster.hierarchy import fcluster, linkage

from llsrbm.arrays import Array, IntArray
from llsrbm.look.visuals import LinkVisual, link_visuals
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots import Robot
from llsrbm.simulation.scene import compiled, joints_in_model_order, moving_bodies, scene_spec

MESHES = "meshes"  # folder beside the MJCF
_LOOKS, _TOUCHES = 2, 3  # geom groups, as is usual: MuJoCo's viewer shows 0 to 2
_ALIKE = 48.0  # of 255: colours of a robot that are that close become one
_OWN = ("world", "trunk", "foot")  # what names of ours begin with, before a slash
_HORIZON, _ZENITH, _TILE = [0.914, 0.929, 0.949], [0.8, 0.85, 0.9], [0.93, 0.94, 0.952]
_LAMP = np.array([-0.29, 0.46, -0.84])  # the way its light goes
_WOOD = (0.65, 0.5, 0.35, 1.0)

_STL_HEADER = 80  # bytes
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


Keyframes = Mapping[str, Mapping[str, ArrayLike]]
"""Name -> attribute of MJCF's `key` -> its numbers, as in the model."""


def write_scene(
    path: Path,
    robot: Robot,
    surroundings: Surroundings,
    disturbance: Disturbance,
    timestep: float,
    keyframes: Keyframes,
    seen: tuple[Array, float],
) -> None:
    """Write the MJCF at `path` and the robot's meshes in the folder `MESHES` beside it.

    Motors are in the order of the joints. Blocks are mocap bodies, put where the last keyframe has
    them. `timestep`: s; `seen`: centre (3,) m and size, m, of what a viewer shows at first. Raises
    `RobotFileError`: the robot cannot be simulated, or has no meshes where its URDF names them.
    """
    spec = scene_spec(robot, surroundings, disturbance, timestep, joints_in_model_order(robot))
    spec.modelname = robot.name
    spec.compiler.discardvisual = False  # which is otherwise so of what was once a URDF
    _set_limits(spec, robot)
    _dress_world(spec, *seen)
    files = _add_visuals(spec, robot)
    *_, last = keyframes.values()
    mocaps = [body for body in spec.bodies if body.mocap]
    for body, place in zip(mocaps, np.asarray(last["mpos"]), strict=True):
        body.pos = place
    spec.meshdir = MESHES
    spec.assets = {f"{MESHES}/{name}": content for name, content in files.items()}
    model = compiled(spec, robot)
    root = ET.fromstring(spec.to_xml())  # noqa: S314  our own
    _restore_digits(root, model)
    _for_others(root)
    section = ET.SubElement(root, "keyframe")
    for name, values in keyframes.items():
        known = {key: _text(value) for key, value in values.items() if np.size(value)}
        ET.SubElement(section, "key", {"name": name, **known})
    ET.indent(root)
    path.write_text(ET.tostring(root, encoding="unicode") + "\n", encoding="utf-8")
    folder = path.parent / MESHES
    folder.mkdir()
    for name, content in files.items():
        (folder / name).write_bytes(content)


def _set_limits(spec: mujoco.MjSpec, robot: Robot) -> None:
    """The robot file's torque limits; our own simulation has limits that depend on the speed."""
    for motor in spec.actuators:
        limit = float(robot.torque_limit[robot.joint_names.index(motor.target)])
        motor.ctrlrange = motor.forcerange = [-limit, limit]
        motor.ctrllimited = motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        # The URDF's, which our simulation does not heed.
        spec.joint(motor.target).actfrcrange = [0.0, 0.0]
        spec.joint(motor.target).actfrclimited = mujoco.mjtLimited.mjLIMITED_AUTO


def _dress_world(spec: mujoco.MjSpec, centre: Array, size: float) -> None:
    spec.stat.center, spec.stat.extent = centre, size
    light = spec.visual.headlight
    light.ambient, light.diffuse, light.specular = [0.42] * 3, [0.32] * 3, [0.05] * 3
    spec.worldbody.add_light(
        name="lamp",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=centre - 2 * size * _LAMP,
        dir=_LAMP,
        diffuse=[0.55] * 3,
        specular=[0.15] * 3,
        castshadow=True,
    )
    spec.visual.rgba.haze = [*_HORIZON, 1.0]
    kinds, made = mujoco.mjtTexture, mujoco.mjtBuiltin
    sky = {"type": kinds.mjTEXTURE_SKYBOX, "builtin": made.mjBUILTIN_GRADIENT, "width": 64}
    spec.add_texture(name="sky", rgb1=_HORIZON, rgb2=_ZENITH, height=384, **sky)
    tiles = {"type": kinds.mjTEXTURE_2D, "builtin": made.mjBUILTIN_FLAT, "width": 256}
    lines = {"mark": mujoco.mjtMark.mjMARK_EDGE, "markrgb": [0.66, 0.7, 0.76]}
    spec.add_texture(name="ground", rgb1=_TILE, rgb2=_TILE, height=256, **tiles, **lines)
    ground = spec.add_material(name="ground", texrepeat=[2, 2], texuniform=True)
    ground.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "ground"
    for geom in spec.geoms:
        kind, _, name = geom.name.partition("/")
        if kind != "world":
            geom.group = _TOUCHES
        elif name == "ground":
            geom.material = "ground"
        else:
            geom.rgba = _WOOD


def _add_visuals(spec: mujoco.MjSpec, robot: Robot) -> dict[str, bytes]:
    """Add a mesh a body and colour, which collides with nothing; returns the STL files."""
    visuals = link_visuals(robot)
    if not visuals:
        return {}
    rgb, colour_of = _palette(visuals)
    for number, colour in enumerate(rgb):
        spec.add_material(name=f"colour-{number}", rgba=[*colour, 1.0])
    look = spec.add_default("visual", spec.default)
    look.geom.type = mujoco.mjtGeom.mjGEOM_MESH
    look.geom.contype = look.geom.conaffinity = 0
    look.geom.group = _LOOKS
    bodies, files = moving_bodies(spec, robot), {}
    for visual, colours in zip(visuals, colour_of, strict=True):
        for number in np.unique(colours):
            name = f"{visual.joint_id:02d}-{number}"
            files[f"{name}.stl"] = _stl(visual.vertices[visual.faces[colours == number]])
            # Flat ones have no volume, which MuJoCo would ask of a solid.
            inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
            spec.add_mesh(name=name, file=f"{name}.stl", inertia=inertia)
            bodies[visual.joint_id].add_geom(look, meshname=name, material=f"colour-{number}")
    return files


def _palette(visuals: Sequence[LinkVisual]) -> tuple[Array, list[IntArray]]:
    """A robot's few colours (C, 3), 0 to 1, and for each of its meshes the colour of each face.

    MuJoCo has no colours of vertices, so every colour is a mesh of its own; photographs have been
    many colours that are almost the same.
    """
    rgb = np.vstack([visual.rgb[visual.faces[:, 0]] for visual in visuals]).astype(float)
    corners = np.vstack([visual.vertices[visual.faces] for visual in visuals])
    sides = corners[:, 1:] - corners[:, :1]
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    colours, which = np.unique(rgb, axis=0, return_inverse=True)
    group = np.zeros(len(colours), dtype=np.int64)
    if len(colours) > 1:
        group = fcluster(linkage(colours, "complete"), _ALIKE, "distance").astype(np.int64) - 1
    of_face = group[which.reshape(-1)]
    # A colour that has no area still needs one.
    weight = area + 1e-12
    total = np.bincount(of_face, weight)
    mean = np.stack([np.bincount(of_face, weight * rgb[:, i]) / total for i in range(3)], axis=1)
    ends = np.cumsum([len(visual.faces) for visual in visuals])
    return mean / 255, np.split(of_face, ends[:-1])


def _stl(corners: NDArray[np.float32]) -> bytes:
    triangles = np.zeros(len(corners), dtype=_STL_TRIANGLE)
    triangles["corners"] = corners
    return (
        bytes(_STL_HEADER) + np.uint32(len(corners)).astype("<u4").tobytes() + triangles.tobytes()
    )


def _restore_digits(root: ET.Element, model: mujoco.MjModel) -> None:
    """Places and inertias of bodies, and joints' drives, with all digits: MuJoCo writes six."""
    for body in root.iter("body"):
        number = model.body(body.get("name")).id
        for key, value, default in (
            ("pos", model.body_pos[number], [0, 0, 0]),
            ("quat", model.body_quat[number], [1, 0, 0, 0]),
        ):
            body.attrib.pop(key, None)
            if (value != default).any():
                body.set(key, _text(value))
        inertial = body.find("inertial")
        if inertial is not None:
            inertial.attrib.clear()
            inertial.set("mass", _text([model.body_mass[number]]))
            inertial.set("pos", _text(model.body_ipos[number]))
            inertial.set("quat", _text(model.body_iquat[number]))
            inertial.set("diaginertia", _text(model.body_inertia[number]))
        for joint in body.findall("joint[@name]"):  # the root's has none
            dof = model.joint(joint.get("name")).dofadr
            for key, values in (
                ("armature", model.dof_armature),
                ("frictionloss", model.dof_frictionloss),
                ("damping", model.dof_damping),
            ):
                joint.set(key, _text(values[dof]))


def exported_name(name: str) -> str:
    """Name without the slash of the simulation's "world/box", which dm_control reserves."""
    return name.replace("/", "-")


def _for_others(root: ET.Element) -> None:
    """Names and attributes that older versions and other readers of MJCF take."""
    for texture in root.iter("texture"):
        texture.attrib.pop("colorspace", None)
    for mesh in root.iter("mesh"):
        mesh.attrib.pop("content_type", None)
    for element in root.iter():
        for key in ("name", "mesh"):
            if element.get(key, "").partition("/")[0] in _OWN:
                element.set(key, exported_name(element.get(key, "")))


def _text(values: ArrayLike) -> str:
    return " ".join(repr(value) for value in np.ravel(np.asarray(values, dtype=float)).tolist())
