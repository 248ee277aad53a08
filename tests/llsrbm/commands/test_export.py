"""`llsrbm export` and `llsrbm formats`: what cannot be done is one line, and nothing is left."""

from dataclasses import replace

import pytest

from llsrbm import cli
from llsrbm.formats import FORMATS, Format
from llsrbm.formats.base import Extra, Options, Purpose
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
        purpose=Purpose.LOOKING,
        suffix=".pic",
        write=write,
        conventions="None.",
        options=("size", "camera"),
    )
    monkeypatch.setitem(FORMATS, "picture", format_)
    return asked


@pytest.fixture
def unexported(refused, tmp_path):
    """What `llsrbm export` says; it leaves the folder as it was."""

    def line_of(*arguments):
        before = sorted(tmp_path.rglob("*"))
        said = refused("export", *map(str, arguments))
        assert sorted(tmp_path.rglob("*")) == before
        return said

    return line_of


def test_no_format_or_no_place(saved, tmp_path, unexported):
    assert "--format" in unexported(saved, "--out", tmp_path / "x")
    assert "--out" in unexported(saved, "--format", "csv")


def test_several_formats_in_one_file(saved, tmp_path, unexported):
    both = ("--format", "csv", "--format", "npz")
    said = unexported(saved, "--out", tmp_path / "x.csv", *both)
    assert "2 formats do not fit into one file; expected a path that ends in .zip" in said


def test_packages_that_are_missing(saved, picture, tmp_path, unexported, capfd, monkeypatch):
    extra = Extra("pictures", ("no_such_module_anywhere",))
    monkeypatch.setitem(FORMATS, "picture", replace(FORMATS["picture"], extra=extra))
    said = unexported(saved, "--out", tmp_path / "x", "--format", "picture")
    assert 'pip install "llsrbm[pictures]"' in said
    assert cli.main(["formats"]) == 0
    line = capfd.readouterr().out.splitlines()[-1]
    assert 'a picture (not installed: pip install "llsrbm[pictures]")' in line


@pytest.mark.parametrize(
    "option", [("--packed",), ("--pad", "1"), ("--order", "depth-first"), ("--size", "2x2")]
)
def test_an_option_that_the_format_does_not_take(saved, tmp_path, unexported, option):
    said = unexported(saved, "--out", tmp_path / "x", "--format", "csv", *option)
    assert f'{option[0][2:]}: is not for format "csv"; its options are fps' in said
    said = unexported(saved, "--out", tmp_path / "x", "--format", "npz", *option)
    assert "it has no options" in said


@pytest.mark.parametrize("fps", ["0", "nan", "20000", "fast"])
def test_a_rate_that_makes_no_sense(saved, tmp_path, unexported, fps):
    out = tmp_path / "x.csv"
    said = unexported(saved, "--out", out, "--format", "csv", "--fps", fps)
    assert "fps" in said


@pytest.mark.parametrize(
    "given",
    [
        *(f"size={size}" for size in ("", "960x", "1x2x3", "0x10", "1.5x2", "nanx1", "1e9x1")),
        *(f"camera={camera}" for camera in ("", "1,2", "a,b,c", "1,2,0", "nan,0,1")),
    ],
)
def test_a_size_or_a_camera_that_makes_no_sense(saved, picture, tmp_path, unexported, given):
    arguments = ("--out", tmp_path / "x.pic", "--format", "picture", f"--{given}")
    assert given.partition("=")[0] in unexported(saved, *arguments)
    assert not picture


def test_a_size_and_a_camera(saved, picture, tmp_path):
    out = tmp_path / "x.pic"
    arguments = ["export", str(saved), "--out", str(out), "--format", "picture"]
    assert cli.main([*arguments, "--size", "64x48", "--camera=-90,10.5,2"]) == 0
    assert picture == [Options(size=(64, 48), camera=(-90.0, 10.5, 2.0))]
    assert cli.main(arguments) == 0
    assert picture[1:] == [Options()]


def test_formats_are_listed(capfd):
    assert cli.main(["formats"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    assert [line.split()[0] for line in out.splitlines()] == list(FORMATS)
    for line, format_ in zip(out.splitlines(), FORMATS.values()):
        assert f"{format_.purpose.value}: {format_.title}" in line


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


@pytest.mark.parametrize("command", [["export"], ["library", "export"]])
def test_its_help_promises_no_rate_of_all_formats(command, capsys):
    assert cli.main([*command, "--help"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "Frames per second. [default: (the format's)]" in shown
