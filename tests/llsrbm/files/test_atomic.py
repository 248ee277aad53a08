"""Writing: under a name stands what was there before or all of what is new, nothing between."""

import json
import os
import resource
import signal
import stat
import subprocess
import sys
import threading
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.files.atomic import MARK, staged
from llsrbm.files.npz import write_archive

NOBODY = 65534


def write(path, content=b"new"):
    with staged(path) as draft:
        draft.write_bytes(content)


def write_folder(path, content="new", mark=True):
    with staged(path) as draft:
        draft.mkdir()
        (draft / "data").mkdir()
        (draft / "data" / "x.txt").write_text(content)
        if mark:
            (draft / MARK).write_text(json.dumps({"package_version": "1", "content": content}))


def fail(path, error):
    """Half of a file or, where there is one, of a folder."""
    with staged(path) as draft:
        draft.mkdir() if path.is_dir() else draft.write_bytes(b"new")
        raise error


def refusal(path, how=write):
    with pytest.raises(InputError) as caught:
        how(path)
    said = str(caught.value)
    assert said.startswith(f"cannot write {path}: ")
    assert "expected a path in a directory that exists" in said
    assert "\n" not in said
    return said


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@contextmanager
def umask(mask):
    before = os.umask(mask)
    try:
        yield
    finally:
        os.umask(before)


def in_a_fork(function):
    """What a function says in a process of its own, which may be changed for good."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            said = str(function() or "done")
        except Exception as error:  # noqa: BLE001  # told to the parent
            said = f"{type(error).__name__}: {error}"
        os.write(writing, said.encode()[:4000])
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        said = pipe.read().decode()
    os.waitpid(child, 0)
    return said


class TestFiles:
    def test_new_and_replaced(self, tmp_path):
        write(tmp_path / "x", b"one")
        write(tmp_path / "x", b"two")
        assert (tmp_path / "x").read_bytes() == b"two"
        assert names(tmp_path) == ["x"]

    def test_nothing_is_seen_before_the_end(self, tmp_path):
        write(tmp_path / "x", b"old")
        with staged(tmp_path / "x") as draft:
            assert draft.name == "x"
            draft.write_bytes(b"new")
            assert (tmp_path / "x").read_bytes() == b"old"
            assert all(name == "x" or name.startswith(".llsrbm-") for name in names(tmp_path))
        assert (tmp_path / "x").read_bytes() == b"new"

    def test_what_stands_beside_comes_along(self, tmp_path):
        with staged(tmp_path / "x.csv") as draft:
            draft.write_bytes(b"1")
            draft.with_name("x.csv.meta.json").write_bytes(b"{}")
        assert names(tmp_path) == ["x.csv", "x.csv.meta.json"]

    def test_nothing_is_replaced_if_what_stands_beside_cannot_be(self, tmp_path):
        (tmp_path / "x.csv.meta.json").mkdir()
        (tmp_path / "x.csv").write_bytes(b"old")

        def both(path):
            with staged(path) as draft:
                draft.write_bytes(b"new")
                draft.with_name("x.csv.meta.json").write_bytes(b"{}")

        assert "it is a directory" in refusal(tmp_path / "x.csv", both)
        assert (tmp_path / "x.csv").read_bytes() == b"old"

    def test_names_that_no_file_can_have(self, tmp_path):
        assert "File name too long" in refusal(tmp_path / ("x" * 256))
        assert "null" in refusal(f"{tmp_path}/a\0b")
        assert names(tmp_path) == []

    def test_a_folder_that_is_not_there(self, tmp_path):
        assert f"no such directory as {tmp_path / 'none'}" in refusal(tmp_path / "none" / "x")
        (tmp_path / "file").touch()
        assert "directory" in refusal(tmp_path / "file" / "x")
        assert names(tmp_path) == ["file"]

    def test_links_are_followed(self, tmp_path):
        (tmp_path / "real").mkdir()
        (tmp_path / "link").symlink_to("real/x")
        write(tmp_path / "link", b"one")
        write(tmp_path / "link", b"two")
        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "real" / "x").read_bytes() == b"two"
        assert names(tmp_path) == ["link", "real"]
        (tmp_path / "folder").symlink_to("real")
        write(tmp_path / "folder" / "y")
        assert names(tmp_path / "real") == ["x", "y"]
        (tmp_path / "round").symlink_to("round")
        assert refusal(tmp_path / "round")

    @pytest.mark.parametrize("mask", [0o022, 0o077])
    def test_permissions_are_those_of_any_new_file_and_folder(self, tmp_path, mask):
        with umask(mask):
            write(tmp_path / "file")
            write_folder(tmp_path / "folder")
        folders = [tmp_path / "folder", tmp_path / "folder" / "data"]
        files = [tmp_path / "file", tmp_path / "folder" / MARK]
        assert {stat.S_IMODE(path.stat().st_mode) for path in files} == {0o666 & ~mask}
        assert {stat.S_IMODE(path.stat().st_mode) for path in folders} == {0o777 & ~mask}


class TestDevices:
    def test_a_device(self):
        write(os.devnull)
        assert stat.S_ISCHR(Path(os.devnull).stat().st_mode)

    def test_a_named_pipe(self, tmp_path):
        os.mkfifo(tmp_path / "pipe")
        got = []
        reader = threading.Thread(target=lambda: got.append((tmp_path / "pipe").read_bytes()))
        reader.start()
        write(tmp_path / "pipe", b"x" * 200_000)
        reader.join(timeout=20)
        assert got == [b"x" * 200_000]
        assert names(tmp_path) == ["pipe"]
        assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)

    def test_a_folder_cannot_be_sent(self):
        assert "a folder would be written" in refusal(os.devnull, write_folder)


class TestFolders:
    def test_new_and_replaced(self, tmp_path):
        write_folder(tmp_path / "x", "one")
        write_folder(tmp_path / "x", "two")
        assert (tmp_path / "x" / "data" / "x.txt").read_text() == "two"
        assert names(tmp_path) == ["x"]
        assert names(tmp_path / "x") == ["data", MARK]

    @pytest.mark.parametrize(
        "mark", [None, "{}", "[]", "no JSON", '{"name": "theirs"}', "[" * 9999]
    )
    def test_a_folder_with_other_things_is_not_lost(self, tmp_path, mark):
        (tmp_path / "x").mkdir()
        (tmp_path / "x" / "thesis.tex").touch()
        if mark is not None:
            (tmp_path / "x" / MARK).write_text(mark)
        before = names(tmp_path / "x")
        assert "with other things in it" in refusal(tmp_path / "x", write_folder)
        assert names(tmp_path / "x") == before
        assert names(tmp_path) == ["x"]
        with pytest.raises(InputError, match="with other things"), staged(tmp_path / "x"):
            pytest.fail("what would be lost is worked for")

    def test_an_error_within_leaves_what_was_there(self, tmp_path):
        write_folder(tmp_path / "x", "one")
        with pytest.raises(ValueError, match="half"):
            fail(tmp_path / "x", ValueError("half a folder"))
        assert (tmp_path / "x" / "data" / "x.txt").read_text() == "one"
        assert names(tmp_path) == ["x"]


class TestWhatGoesWrong:
    def test_a_full_disk(self, tmp_path):
        """As a limit on the size of files, which fails in the same place."""
        write(tmp_path / "x", b"old")

        def full():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))
            noise = np.random.default_rng(1).normal(size=10_000)
            write_archive(tmp_path / "x", {"noise": noise})

        assert in_a_fork(full).startswith(f"InputError: cannot write {tmp_path / 'x'}: File too la")
        assert (tmp_path / "x").read_bytes() == b"old"
        assert names(tmp_path) == ["x"]

    @pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody else")
    def test_no_permission(self, tmp_path):
        path = tmp_path / "theirs"
        path.mkdir()
        for parent in (path, *path.parents[:3]):
            parent.chmod(0o755)

        def as_nobody():
            os.setgid(NOBODY)
            os.setuid(NOBODY)
            write(path / "x")

        said = in_a_fork(as_nobody)
        assert said.startswith(f"InputError: cannot write {path / 'x'}: Permission denied")
        assert names(path) == []

    def test_killed_in_the_middle(self, tmp_path):
        """The old file stays; a hidden folder is left, which nothing takes for a file of ours."""
        write(tmp_path / "x", b"old")
        program = (
            "import os, signal, sys\n"
            "from llsrbm.files.atomic import staged\n"
            "with staged(sys.argv[1]) as draft:\n"
            "    draft.write_bytes(b'half')\n"
            "    os.kill(os.getpid(), signal.SIGKILL)\n"
        )
        killed = subprocess.run([sys.executable, "-c", program, str(tmp_path / "x")], check=False)
        assert killed.returncode == -signal.SIGKILL
        assert (tmp_path / "x").read_bytes() == b"old"
        assert [name for name in names(tmp_path) if not name.startswith(".llsrbm-")] == ["x"]
        write(tmp_path / "x", b"new")
        assert (tmp_path / "x").read_bytes() == b"new"

    def test_many_write_the_same_file(self, tmp_path):
        contents = [bytes([i]) * 50_000 for i in range(8)]
        seen, errors = set(), []

        def writer(content):
            try:
                for _ in range(10):
                    write(tmp_path / "x", content)
            except InputError as error:
                errors.append(error)

        threads = [threading.Thread(target=writer, args=(content,)) for content in contents]
        write(tmp_path / "x", contents[0])
        for thread in threads:
            thread.start()
        while any(thread.is_alive() for thread in threads):
            seen.add((tmp_path / "x").read_bytes())
        assert not errors
        assert seen <= set(contents)
        assert names(tmp_path) == ["x"]
