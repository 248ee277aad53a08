"""`llsrbm export` and `llsrbm formats`: what cannot be done is one line, and nothing is left."""

from __future__ import annotations

import json
import pickle
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from llsrbm import cli
from llsrbm.formats import FORMATS, Format
from llsrbm.formats.base import Extra, Options
from tests.llsrbm.commands.process import run
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def rollout(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "rollout.npz"
    synthetic_rollout().save(path)
    return path


@pytest.fixture
def picture(monkeypatch):
    """A format of plans only, that takes a size and a camera and writes them down."""
    asked = []

    def write(trajectory, path, options):
        asked.append(options)
        path.write_text("a picture")

    format_ = Format(
        name="picture",
        title="a picture",
        suffix=".pic",
        write=write,
        conventions="None.",
        options=("size", "camera"),
        holds=("plan",),
    )
    monkeypatch.setitem(FORMATS, "picture", format_)
    return asked


def refused(capfd, folder, *arguments):
    """What `llsrbm export` says; a folder that it leaves as it was."""
    before = sorted(folder.rglob("*"))
    assert cli.main(["export", *map(str, arguments)]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("llsrbm: ")
    assert err.count("\n") == 1
    assert sorted(folder.rglob("*")) == before
    return err


def test_several_in_a_zip(saved, tmp_path, capfd):
    out = tmp_path / "x.zip"
    both = ("--format", "csv", "--format", "npz")
    assert cli.main(["export", str(saved), "--out", str(out), *both]) == 0
    with zipfile.ZipFile(out) as archive:
        assert {name.rpartition(".")[2] for name in archive.namelist()} == {"csv", "npz", "json"}


def test_an_unknown_format(saved, tmp_path, capfd):
    said = refused(capfd, tmp_path, saved, "--out", tmp_path / "x", "--format", "bvh")
    assert 'no format "bvh"; valid: npz, csv' in said


def test_no_format_or_no_place(saved, tmp_path, capfd):
    assert "--format" in refused(capfd, tmp_path, saved, "--out", tmp_path / "x")
    assert "--out" in refused(capfd, tmp_path, saved, "--format", "csv")


@pytest.mark.parametrize("format_", ["csv", "npz"])
def test_a_path_that_cannot_be_written(saved, tmp_path, capfd, format_):
    for out, why in (
        (tmp_path / "none" / "x", "no such directory"),
        (tmp_path, "it is a directory"),
        ("/dev/full", "No space left"),
        (tmp_path / ("x" * 300), "File name too long"),
    ):
        said = refused(capfd, tmp_path, saved, "--out", out, "--format", format_)
        assert f"cannot write {out}: " in said
        assert why in said


def test_several_formats_in_one_file(saved, tmp_path, capfd):
    both = ("--format", "csv", "--format", "npz")
    said = refused(capfd, tmp_path, saved, "--out", tmp_path / "x.csv", *both)
    assert "2 formats do not fit into one file; expected a path that ends in .zip" in said


def test_a_format_that_cannot_hold_it(rollout, picture, tmp_path, capfd):
    said = refused(capfd, tmp_path, rollout, "--out", tmp_path / "x", "--format", "picture")
    assert 'format "picture" cannot hold a rollout; expected a plan' in said


def test_packages_that_are_missing(saved, picture, tmp_path, capfd, monkeypatch):
    extra = Extra("pictures", ("no_such_module_anywhere",))
    monkeypatch.setitem(FORMATS, "picture", replace(FORMATS["picture"], extra=extra))
    said = refused(capfd, tmp_path, saved, "--out", tmp_path / "x", "--format", "picture")
    assert 'pip install "llsrbm[pictures]"' in said
    assert cli.main(["formats"]) == 0
    line = capfd.readouterr().out.splitlines()[-1]
    assert 'a picture (not installed: pip install "llsrbm[pictures]")' in line


@pytest.mark.parametrize("option", [("--pad", "1"), ("--order", "depth-first"), ("--size", "2x2")])
def test_an_option_that_the_format_does_not_take(saved, tmp_path, capfd, option):
    said = refused(capfd, tmp_path, saved, "--out", tmp_path / "x", "--format", "csv", *option)
    assert f'{option[0][2:]}: is not for format "csv"; its options are fps' in said
    said = refused(capfd, tmp_path, saved, "--out", tmp_path / "x", "--format", "npz", *option)
    assert "it has no options" in said


@pytest.mark.parametrize("fps", ["0", "nan", "20000", "fast"])
def test_a_rate_that_makes_no_sense(saved, tmp_path, capfd, fps):
    out = tmp_path / "x.csv"
    said = refused(capfd, tmp_path, saved, "--out", out, "--format", "csv", "--fps", fps)
    assert "fps" in said


def test_an_order_that_makes_no_sense(saved, tmp_path, capfd):
    out = tmp_path / "x.npz"
    said = refused(capfd, tmp_path, saved, "--out", out, "--format", "motion-npz", "--order", "any")
    assert "order: expected depth-first or breadth-first, got 'any'" in said


@pytest.mark.parametrize(
    "given",
    [
        *(f"size={size}" for size in ("", "960x", "1x2x3", "0x10", "1.5x2", "nanx1", "1e9x1")),
        *(f"camera={camera}" for camera in ("", "1,2", "a,b,c", "1,2,0", "nan,0,1")),
    ],
)
def test_a_size_or_a_camera_that_makes_no_sense(saved, picture, tmp_path, capfd, given):
    arguments = ("--out", tmp_path / "x.pic", "--format", "picture", f"--{given}")
    assert given.partition("=")[0] in refused(capfd, tmp_path, saved, *arguments)
    assert not picture


def test_a_size_and_a_camera(saved, picture, tmp_path):
    out = tmp_path / "x.pic"
    arguments = ["export", str(saved), "--out", str(out), "--format", "picture"]
    assert cli.main([*arguments, "--size", "64x48", "--camera=-90,10.5,2"]) == 0
    assert picture == [Options(size=(64, 48), camera=(-90.0, 10.5, 2.0))]
    assert cli.main(arguments) == 0
    assert picture[1:] == [Options()]


class TestFilesThatAreNone:
    def said(self, capfd, path):
        out = path.with_name("out.csv")
        return refused(capfd, path.parent, path, "--out", out, "--format", "csv")

    def test_newer(self, saved, tmp_path, capfd):
        with np.load(saved) as archive:
            arrays = dict(archive)
        path = tmp_path / "x.npz"
        meta = json.loads(str(arrays["meta"])) | {"package_version": "7.8.9"}
        changes = {"schema": np.array("llsrbm.plan/99"), "meta": np.array(json.dumps(meta))}
        np.savez(path, **arrays | changes)
        assert "written by a newer llsrbm (7.8.9)" in self.said(capfd, path)

    def test_cut_short(self, saved, tmp_path, capfd):
        path = tmp_path / "x.npz"
        path.write_bytes(saved.read_bytes()[:-100])
        assert "cut short" in self.said(capfd, path)

    def test_pickled(self, saved, tmp_path, capfd):
        path = tmp_path / "x.npz"
        path.write_bytes(pickle.dumps(3))
        assert "a Python pickle, which is never opened" in self.said(capfd, path)
        np.savez(path, schema=np.array("llsrbm.plan/2"), com=np.array([{}], dtype=object))
        assert "a pickle of Python objects, which is never opened" in self.said(capfd, path)

    def test_others(self, tmp_path, capfd):
        assert "No such file" in self.said(capfd, tmp_path / "none.npz")
        (tmp_path / "x.json").write_text('{"schema": "llsrbm.design/1"}')
        assert "llsrbm plan --design" in self.said(capfd, tmp_path / "x.json")
        (tmp_path / "folder").mkdir()
        assert "it is a folder" in self.said(capfd, tmp_path / "folder")


def test_in_a_process_of_its_own(saved, tmp_path):
    """A pipe to somebody else, and the one line where a traceback might be."""
    done = run("export", saved, "--out", tmp_path / "x.zip", "--format", "npz")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    (tmp_path / "x.npz").write_bytes(b"PK" + bytes(100))
    done = run("export", tmp_path / "x.npz", "--out", tmp_path / "y", "--format", "csv")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "Traceback" not in done.stderr


def test_formats_are_listed(capfd):
    assert cli.main(["formats"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    assert [line.split()[0] for line in out.splitlines()] == list(FORMATS)
    for line, format_ in zip(out.splitlines(), FORMATS.values()):
        assert format_.title in line


@pytest.mark.parametrize("name", FORMATS)
def test_the_conventions_of_one(capfd, name):
    assert cli.main(["formats", "--format", name]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    format_ = FORMATS[name]
    assert format_.conventions.strip() in out
    assert f"name ends in  {format_.suffix or '(a folder)'}\n" in out
    for option in format_.options:
        assert f"{option} (default " in out
    assert max(map(len, format_.conventions.splitlines())) <= 100
