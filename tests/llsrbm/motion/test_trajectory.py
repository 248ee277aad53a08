"""Opening what is no native file of this version: a line that says what it seems to be."""

import json
import pickle

import numpy as np
import pytest

from llsrbm.errors import FileFormatError
from llsrbm.installed import package_version
from llsrbm.motion.plan import SCHEMA as PLAN_SCHEMA
from llsrbm.motion.plan import load_plan
from llsrbm.motion.trajectory import load
from llsrbm.request.design import Design, dump_design
from llsrbm.request.jump import Jump
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

ACCEPTED = "expected an npz file that the page exported, or --out or a save() wrote"


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(intervals=3)


@pytest.fixture(scope="module")
def rollout():
    return synthetic_rollout()


def said(path, read=load):
    with pytest.raises(FileFormatError) as caught:
        read(path)
    text = str(caught.value)
    assert text.isprintable()
    assert text.startswith(f"{path}: ")
    return text


def newer(trajectory, path, schema, **meta):
    """A file as a later version may write it: other keys, another schema."""
    trajectory.save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    kind, _, number = schema.partition("/")
    arrays["schema"] = np.array(f"{kind}/{int(number) + 1}")
    arrays["meta"] = np.array(json.dumps(json.loads(str(arrays["meta"])) | meta))
    del arrays["com"]
    np.savez_compressed(path, **arrays)
    return str(arrays["schema"])


def test_a_newer_plan(plan, tmp_path):
    path = tmp_path / "x.npz"
    schema = newer(plan, path, PLAN_SCHEMA, package_version="7.8.9", report=3)
    for read in (load, load_plan):
        text = said(path, read)
        assert f'schema "{schema}", written by a newer llsrbm (7.8.9)' in text
        assert f"llsrbm {package_version()} reads {PLAN_SCHEMA}" in text
        assert "update llsrbm" in text


@pytest.mark.parametrize("meta", ["{", "[]", "3", "\x00", "[" * 100_000])
def test_a_newer_file_that_does_not_say_who_wrote_it(plan, tmp_path, meta):
    path = tmp_path / "x.npz"
    newer(plan, path, PLAN_SCHEMA)
    with np.load(path) as archive:
        arrays = dict(archive)
    np.savez(path, **arrays | {"meta": np.array(meta)})
    assert "written by a newer llsrbm; llsrbm " in said(path)
    del arrays["meta"]
    np.savez(path, **arrays)
    assert "written by a newer llsrbm; llsrbm " in said(path)


@pytest.mark.parametrize("schema", ["llsrbm.plan/0", "llsrbm.plan/x", "llsrbm.plan/٣", "another"])
def test_schemas_that_are_not_newer(plan, tmp_path, schema):
    path = tmp_path / "x.npz"
    plan.save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    np.savez(path, **arrays | {"schema": np.array(schema)})
    text = said(path)
    assert f'schema "{schema}"; expected "{PLAN_SCHEMA}"' in text


def test_what_it_seems_to_be(plan, tmp_path):
    path = tmp_path / "x"
    plan.save(path)
    for content, seems in (
        (b"", "an empty file"),
        (path.read_bytes()[:5000], "a zip archive that is cut short or damaged"),
        (pickle.dumps({"com": [1, 2]}), "a Python pickle, which is never opened"),
        (dump_design(Design(Jump(twist=1.0))).encode(), "`llsrbm plan --design FILE`"),
        (b"\x93NUMPY", "a single NumPy array"),
        (b"time [s],com/x [m]\n", "tables cannot be read back"),
        (bytes(range(256)), "one of an unknown kind"),
    ):
        path.write_bytes(content)
        assert seems in said(path)
        assert said(path).endswith(ACCEPTED)
    assert "it is a folder" in said(tmp_path)


def test_an_archive_of_something_else(tmp_path):
    path = tmp_path / "x.npz"
    np.savez(path, fps=50.0, joint_pos=np.zeros((3, 12)))
    assert 'key "schema" is missing; the file holds fps, joint_pos; expected' in said(path)
