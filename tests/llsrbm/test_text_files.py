"""Every reader of text takes what editors and shells write, and refuses the rest in one line."""

import os

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import InputError
from llsrbm.installed import assets_directory
from llsrbm.request.design import load_design
from llsrbm.request.jump_types import load_type
from llsrbm.robots import read_robot_file
from llsrbm.sweep.spec import find_spec

ASSETS = assets_directory()
TABLE = "0,0,0.5,0,0,0,1" + ",0" * 12


def motion(path):
    return llsrbm.load_motion(path, robot="anymal", format="unitree-csv", fps=50).qpos.tolist()


def beside(path):
    table = path.with_name("x.csv")
    table.write_text("\n".join([TABLE] * 3))
    return motion(path.rename(path.with_name("x.csv.meta.json")).with_name("x.csv"))


READERS = {
    "design.json": (load_design, (ASSETS / "designs" / "12-anymal-slippery.jump.json").read_text()),
    "sweep.toml": (lambda path: find_spec(str(path)), (ASSETS / "sweeps/quick.toml").read_text()),
    "type.toml": (lambda path: load_type(str(path)), (ASSETS / "jump_types/flip.toml").read_text()),
    "robot.toml": (read_robot_file, (ASSETS / "robots" / "slider.toml").read_text()),
    "motion.csv": (motion, "\n".join([TABLE] * 3)),
    "beside.json": (beside, '{"fps": 60, "quaternion_order": "xyzw"}'),
}
WRITTEN = {
    "a mark": lambda text: b"\xef\xbb\xbf" + text.encode(),
    "UTF-16": lambda text: text.encode("utf-16"),
    "UTF-16, big end first": lambda text: b"\xfe\xff" + text.encode("utf-16-be"),
    "CRLF": lambda text: text.replace("\n", "\r\n").encode(),
}


@pytest.mark.parametrize("coding", WRITTEN)
@pytest.mark.parametrize("name", READERS)
def test_what_editors_write_is_read(tmp_path, name, coding):
    read, text = READERS[name]
    plain, other = tmp_path / name, tmp_path / "other" / name
    other.parent.mkdir()
    plain.write_text(text)
    other.write_bytes(WRITTEN[coding](text))
    assert repr(read(other)).replace(str(other), "") == repr(read(plain)).replace(str(plain), "")


@pytest.mark.parametrize("content", [b"", b" \n", "# \xe4\n".encode("latin-1"), os.urandom(4000)])
@pytest.mark.parametrize("name", READERS)
def test_what_is_no_text_is_one_line(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        READERS[name][0](path)
    assert str(caught.value).isprintable()
    assert name.partition(".")[0] in str(caught.value) or "x.csv" in str(caught.value)


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir])
@pytest.mark.parametrize("name", [name for name in READERS if name != "beside.json"])
def test_pipes_and_folders_are_not_waited_for(tmp_path, name, make):
    make(tmp_path / name)
    with pytest.raises(InputError, match=r"cannot be read \((it is a folder|not a regular file)\)"):
        READERS[name][0](tmp_path / name)


def test_a_table_of_one_endless_row_is_refused_before_it_is_parsed(tmp_path, monkeypatch):
    path = tmp_path / "wide.csv"
    path.write_text("0," * 1_000_000 + "0")
    monkeypatch.setattr(np, "array", None)
    with pytest.raises(InputError, match="row 1 has 1000001 columns"):
        motion(path)
