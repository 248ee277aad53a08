"""Meshes: found from everywhere, and the same in collisions, pictures and MJCF."""

import logging

import numpy as np
import pytest
import trimesh

from llsrbm.cache import ENVIRONMENT_VARIABLE
from llsrbm.errors import RobotFileError
from llsrbm.look.visuals import link_visuals
from llsrbm.robots import build_robot, load_robot
from llsrbm.robots.description.mesh_paths import MeshPaths
from llsrbm.robots.feet import collision_shapes
from llsrbm.robots.mesh_files import read_meshes
from llsrbm.robots.shapes import link_shapes
from tests.llsrbm.robots.strange_urdf import URDF, robot_file


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory, monkeypatch):
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path_factory.mktemp("cache")))


@pytest.mark.parametrize(
    "name",
    [
        "package://quad_description/meshes/a b.stl",
        "package://quad_description/meshes/a%20b.stl",
        "package://by_its_xml/meshes/a b.stl",
        "package://sibling/a b.stl",
        "model://quad_description/meshes/a b.stl",
        "../meshes/a b.stl",
        "meshes/a b.stl",
        "file://../meshes/a b.stl",
        "file://{folder}/meshes/a%20b.stl",
        "{folder}/meshes/a b.stl",
    ],
)
def test_every_way_to_write_a_meshs_path(tmp_path, monkeypatch, name):
    folder = tmp_path / "quad_description"
    for place in (folder / "meshes", folder / "urdf", tmp_path / "sibling", tmp_path / "else"):
        place.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>by_its_xml</name></package>")
    for place in (folder / "meshes", tmp_path / "sibling"):
        (place / "a b.stl").write_bytes(trimesh.creation.box().export(file_type="stl"))
    monkeypatch.chdir(tmp_path / "else")
    found = MeshPaths(folder / "urdf" / "quad.urdf").find(name.format(folder=folder), "here")
    assert found.resolve().name == "a b.stl"


CUBE = trimesh.creation.box()
ASCII = CUBE.export(file_type="stl_ascii").encode()
COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="cm" meter="{unit}"/><up_axis>{up}</up_axis></asset>
<library_images>{images}</library_images>
<library_effects><effect id="e"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>picture</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="c"><lambert><diffuse><texture texture="t" texcoord="u"/></diffuse></lambert>
</technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#{effect}"/></material>
</library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 10 0 0 0 20 0 0 0 30</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4" material="m"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene">
<node><translate>{shift} 0 0</translate><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="m" target="#{material}"/></technique_common>
</bind_material></instance_geometry></node>
<node><translate>0 0 5</translate><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"""
WHOLE = {"unit": 0.01, "up": "Z_UP", "images": "", "effect": "e", "material": "m", "shift": 1}
PICTURE = '<image id="picture"><init_from>nowhere.png</init_from></image>'


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"up": "Y_UP"},
        {"images": PICTURE},
        {"images": '<image id="other"><init_from>nowhere.png</init_from></image>'},
        {"effect": "none"},
        {"material": "none"},
    ],
)
def test_a_fault_of_a_material_never_costs_faces(tmp_path, change):
    path = tmp_path / "part.dae"
    path.write_text(COLLADA.format(**WHOLE | change))
    meshes = read_meshes(path)
    assert sum(len(mesh.faces) for mesh in meshes) == 8
    bounds = trimesh.util.concatenate([m.copy() for m in meshes]).bounds
    np.testing.assert_allclose(bounds, [[0, 0, 0], [0.11, 0.2, 0.35]], atol=1e-9)


def test_blenders_broken_textures_are_mended(caplog):
    """ANYmal's foot names a surface that its file does not have; read as it is, it is empty."""
    foot = next(load_robot("anymal").urdf_path.parents[1].glob("meshes/foot/*.dae"))
    assert len(trimesh.load_scene(foot).geometry) == 0
    with caplog.at_level(logging.WARNING):
        meshes = read_meshes(foot)
    assert sum(len(mesh.faces) for mesh in meshes) > 1000
    assert any(mesh.visual.material.baseColorTexture is not None for mesh in meshes)
    assert not caplog.records


def part(suffix):
    """A wedge of several meshes on nodes that move them, as a file of that kind."""
    wedge = trimesh.Trimesh(
        [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    scene = trimesh.Scene()
    for x in (0.0, 2.0):
        scene.add_geometry(wedge, transform=trimesh.transformations.translation_matrix([x, 0, 1]))
    if suffix == "dae":
        return COLLADA.format(**WHOLE | {"unit": 0.1, "shift": 20}).encode()
    content = (scene if suffix in ("glb", "obj") else scene.to_mesh()).export(file_type=suffix)
    return content if isinstance(content, bytes) else content.encode()


@pytest.mark.parametrize("scale", ["1 1 1", "-0.5 0.5 2"])
@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "glb", "dae"])
def test_collisions_pictures_and_hulls_have_the_same_mesh(tmp_path, suffix, scale):
    (tmp_path / f"part.{suffix}").write_bytes(part(suffix))
    mesh = f'<mesh filename="part.{suffix}" scale="{scale}"/>'
    urdf = URDF.replace('<box size="0.2 0.3 0.2"/>', mesh)
    robot = build_robot(robot_file(tmp_path, urdf))
    factors = np.array([float(x) for x in scale.split()])
    corners = np.concatenate([m.vertices for m in read_meshes(tmp_path / f"part.{suffix}")])
    expected = corners * factors + [0, 0, 0.1]
    low, high = expected.min(axis=0), expected.max(axis=0)
    (solid,) = (shape for shape in collision_shapes(robot) if shape.joint == 1)
    (hull,) = (shape for shape in link_shapes(robot) if shape.joint == 1)
    seen = hull.points @ hull.rotation.T + hull.centre
    drawn = link_visuals(robot)[0].vertices + np.array([0, 0, 0.1])  # the visual has no origin
    for points in (solid.corners, seen, drawn):
        np.testing.assert_allclose(points.min(axis=0), low, atol=2e-4)
        np.testing.assert_allclose(points.max(axis=0), high, atol=2e-4)
    visual = link_visuals(robot)[0].mesh()
    assert trimesh.Trimesh(visual.vertices, visual.faces).volume > 0  # faces outwards


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("empty.stl", b"", "cannot be read|is empty"),
        ("flat.stl", trimesh.Trimesh().export(file_type="stl"), "is empty|cannot be read"),
        ("broken.dae", b"<COLLADA", "cannot be read"),
        ("part.step", b"", "cannot be read; expected a file .*stl"),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "corners that are no numbers|empty"),
        ("nan.stl", ASCII.replace(b"0.5", b"nan", 1), "corners that are no numbers"),
        ("leaf.stl", trimesh.creation.box((1, 1, 0)).export(file_type="stl"), '"trunk" is flat'),
        ("thin.stl", trimesh.creation.box((1, 1, 1e-9)).export(file_type="stl"), "is flat"),
        ("mm.stl", trimesh.creation.box((300, 1, 1)).export(file_type="stl"), '"trunk".* 150 m'),
        ("huge.stl", ASCII.replace(b"0.5", b"1e39", 1), "1e[+]39 m"),
        ("part.3mf", b"PK", "cannot be read; expected a file .*stl"),
        ("point.obj", b"v 1 1 1\nv 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\nf 2 3 4\n", "flat|empty"),
        (
            "LFS.stl",
            b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
            "git lfs pull",
        ),
    ],
)
def test_a_mesh_that_is_none_is_one_line(tmp_path, name, content, expected):
    (tmp_path / name).write_bytes(content)
    urdf = URDF.replace('<box size="0.2 0.3 0.2"/>', f'<mesh filename="{name}"/>')
    with pytest.raises(RobotFileError, match=expected) as caught:
        link_shapes(build_robot(robot_file(tmp_path, urdf)))
    assert "\n" not in str(caught.value)
    assert name in str(caught.value)
