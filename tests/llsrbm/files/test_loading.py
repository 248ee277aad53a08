"""Opening what is no native file of this version: a line that says what it seems to be."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest

from llsrbm.errors import FileFormatError
from llsrbm.files import plan_file, rollout_file
from llsrbm.files.loading import load
from llsrbm.formats import export
from llsrbm.installed import package_version
from llsrbm.request.design import Design, dump_design
from llsrbm.request.jump import Jump
from llsrbm.robots.schema import robot_files
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

ACCEPTED = "expected an npz file that `--out`, `Plan.save` or `Rollout.save` wrote"


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
    schema = newer(plan, path, plan_file.SCHEMA, package_version="7.8.9", report=3)
    for read in (load, plan_file.load_plan):
        text = said(path, read)
        assert f'schema "{schema}", written by a newer llsrbm (7.8.9)' in text
        assert f"llsrbm {package_version()} reads {plan_file.SCHEMA}" in text
        assert "update llsrbm" in text


def test_a_newer_rollout(rollout, tmp_path):
    path = tmp_path / "x.npz"
    schema = newer(rollout, path, rollout_file.SCHEMA, package_version="7.8.9")
    for read in (load, rollout_file.load_rollout):
        text = said(path, read)
        assert f'schema "{schema}", written by a newer llsrbm (7.8.9)' in text
        assert rollout_file.SCHEMA in text
        assert "update llsrbm" in text


@pytest.mark.parametrize("meta", ["{", "[]", "3", "\x00", "[" * 100_000])
def test_a_newer_file_that_does_not_say_who_wrote_it(plan, tmp_path, meta):
    path = tmp_path / "x.npz"
    newer(plan, path, plan_file.SCHEMA)
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
    assert f'schema "{schema}"; expected "{plan_file.SCHEMA}"' in text


def test_a_plan_is_no_rollout(plan, rollout, tmp_path):
    plan.save(tmp_path / "plan.npz")
    rollout.save(tmp_path / "rollout.npz")
    assert f'expected "{plan_file.SCHEMA}"' in said(tmp_path / "rollout.npz", plan_file.load_plan)
    assert f'expected "{rollout_file.SCHEMA}"' in said(
        tmp_path / "plan.npz", rollout_file.load_rollout
    )


def test_what_it_seems_to_be(plan, tmp_path):
    path = tmp_path / "x"
    path.write_bytes(b"")
    assert "an empty file" in said(path)
    plan.save(path)
    path.write_bytes(path.read_bytes()[:5000])
    assert "a zip archive that is cut short or damaged" in said(path)
    path.write_bytes(pickle.dumps({"com": [1, 2]}))
    assert "a Python pickle, which is never opened" in said(path)
    path.write_text(dump_design(Design(Jump(twist=1.0))))
    assert "a design, of which `llsrbm plan --design FILE --out PLAN.npz` makes a plan" in said(
        path
    )
    path.write_text('{"a": 1}')
    assert "a JSON file" in said(path)
    path.write_text("hello")
    assert "a text file" in said(path)
    path.write_bytes(bytes(range(256)))
    assert "of no kind that is known" in said(path)
    np.save(tmp_path / "x.npy", np.zeros(3))
    assert "a single NumPy array" in said(tmp_path / "x.npy")
    export(plan, tmp_path / "x.csv", format="csv")
    text = said(tmp_path / "x.csv")
    assert "a table that `llsrbm export --format csv` wrote" in text
    assert "it is a folder" in said(tmp_path)
    for file in robot_files().values():
        assert "a robot file, which `llsrbm plan --robot FILE` takes" in said(file)
    for each in (path, tmp_path / "x.csv", tmp_path):
        assert said(each).endswith(ACCEPTED)


def test_text_that_ends_within_a_letter(tmp_path):
    """Only the beginning is looked at."""
    path = tmp_path / "x"
    for shift in range(4):
        path.write_text("a" * shift + "🤖" * 2000)
        assert "a text file" in said(path)


def test_an_archive_of_something_else(tmp_path):
    path = tmp_path / "x.npz"
    np.savez(path, fps=50.0, joint_pos=np.zeros((3, 12)))
    assert 'key "schema" is missing; the file holds fps, joint_pos; expected' in said(path)
