"""The command line: exit status, one line for what is wrong, one JSON object when asked."""

import os
import signal
import subprocess
import sys
import time
from importlib.metadata import EntryPoint

import pytest

from llsrbm import cli
from tests.llsrbm.processes import assert_spares, run
from tests.llsrbm.synthetic import synthetic_plan


class TestBadInput:
    def test_in_a_process(self, tmp_path):
        """Where a traceback or a stray print would show."""
        process = run("plan", "--forward", "50", "--json", cwd=tmp_path)
        assert (process.returncode, process.stdout) == (2, "")
        assert process.stderr.startswith("llsrbm: ")
        assert process.stderr.count("\n") == 1
        assert "50 m is out of range" in process.stderr
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            (
                ["nosuch"],
                'no command "nosuch"; the commands are plan, simulate, export, replay, robots',
            ),
            (["plan", "--twist", "nan"], "finite number"),
            (["plan", "--twist", "abc"], "--twist"),
            (["plan", "--robot", "nosuch"], "anymal"),
            (["plan", "--model", "nosuch"], "srbm, llsrbm, llsrbm-plus"),
            (["plan", "--solver", "nosuch"], "fatrop"),
            (["plan", "--twist", "900"], "900 deg is out of range"),
            (["plan", "--nosuch"], "--nosuch"),
            (["plan", "extra"], "extra"),
            (["export"], "FILE.npz"),
            (["simulate", "nosuch.npz"], "nosuch.npz: cannot be read: No such file"),
            (["simulate", "--half-board"], "half board: expected the board's thickness"),
            (["simulate", "--seed", "1.5"], "--seed"),
            (["export", "nosuch.npz", "--format", "csv", "--out", "x"], "No such file"),
        ],
    )
    def test_is_one_line_and_exit_2(self, arguments, said, refused, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        assert said in refused(*arguments)
        assert list(tmp_path.iterdir()) == []


class TestLists:
    def test_help_imports_nothing_heavy(self):
        program = "from llsrbm import cli; cli.main(['--help'])"
        assert_spares(program, "casadi", "pinocchio", "mujoco", "viser", "numpy")

    def test_help_without_arguments(self, capsys):
        assert cli.main([]) == 0
        out = capsys.readouterr().out
        assert all(word in out for word in ("plan", "simulate", "export", "robots", "formats"))

    def test_robots_models_formats(self, capsys):
        for command, first in (("robots", "a1"), ("models", "srbm"), ("formats", "npz")):
            assert cli.main([command]) == 0
            lines = capsys.readouterr().out.splitlines()
            assert lines[0].split()[0] == first
            assert all("(drives: " in line for line in lines) == (command == "robots")


class TestStreams:
    """Whatever a shell makes of them, nothing is a traceback and lost output is no success."""

    def shell(self, command, redirected, **env):
        return subprocess.run(
            [
                "bash",
                "-o",
                "pipefail",
                "-c",
                f"{sys.executable} -m llsrbm.cli {command} {redirected}",
            ],
            capture_output=True,
            text=True,
            timeout=100,
            env=os.environ | env,
        )

    @pytest.mark.parametrize(
        ("command", "redirected", "lines"),
        [
            ("--help", ">&-", ["llsrbm: stdout: cannot be written: Bad file descriptor"]),
            (
                "compare {} --json",
                ">/dev/full",
                ["llsrbm: stdout: cannot be written: No space left on device"],
            ),
            ("--help", ">&- 2>&-", []),
            ("--help", "<&- | sleep 0", []),
        ],
    )
    def test_output_that_is_lost(self, tmp_path, command, redirected, lines):
        synthetic_plan().save(tmp_path / "x.npz")
        process = self.shell(command.format(tmp_path / "x.npz"), redirected)
        assert process.returncode == 1
        assert process.stderr.splitlines() == lines
        assert process.stdout == ""

    def test_errors_that_nobody_can_read(self):
        """The exit status is there all the same."""
        assert self.shell("plan --robot nosuch --json", "2>/dev/full").returncode == 2
        assert self.shell("models", "0<&- 2>&-").stdout.startswith("srbm")

    def test_letters_that_an_encoding_lacks(self):
        process = self.shell("formats --format motion-npz", "", PYTHONIOENCODING="ascii")
        assert (process.returncode, process.stderr) == (0, "")


# As the script that pip makes; the first line stands for the last instruction before ours.
SCRIPT = """
import sys
sys.stdout.write("begun"), sys.stdout.flush()
from llsrbm.cli import main
sys.exit(main())
"""


@pytest.mark.parametrize(
    ("command", "after", "number"),
    [
        ("serve --port 0 --no-browser", 0.15, signal.SIGTERM),
        ("serve --port 0 --no-browser", 0.9, signal.SIGINT),
        ("serve --port 0 --no-browser", 1.2, signal.SIGINT),  # its processes begin
        ("plan --robot go2", 0.03, signal.SIGINT),
        ("plan --robot go2", 0.4, signal.SIGTERM),
    ],
)
def test_a_signal_ends_a_command_that_still_begins_without_a_word(command, after, number):
    """As Ctrl-C sends it, to all processes of the terminal."""
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, *command.split()],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        # Otherwise MuJoCo imports glfw, which has a process of its own tell its version for 15 ms.
        env=os.environ | {"MUJOCO_GL": "disable"},
    )
    assert process.stdout.read(5) == b"begun"
    time.sleep(after)
    os.killpg(process.pid, number)
    _, err = process.communicate(timeout=60)
    # On a quick machine the server has begun by then, and says at what.
    assert [line for line in err.splitlines() if not line.endswith(b" ...")] == []
    assert process.returncode in ((130, 0) if number == signal.SIGINT else (-number, 0))


class TestCommandsOfOtherPackages:
    def register(self, monkeypatch, value):
        point = EntryPoint(name="greet", value=value, group="llsrbm.commands")
        monkeypatch.setattr("llsrbm.commands.program.entry_points", lambda group: (point,))

    def test_are_found_and_get_their_options(self, monkeypatch, capsys):
        self.register(monkeypatch, "tests.llsrbm.plugin:greet")
        assert cli.main(["greet", "--name", "Anna"]) == 0
        assert capsys.readouterr().out == "hello Anna\n"
        assert cli.main(["--help"]) == 0
        assert "Say hello." in capsys.readouterr().out

    def test_their_mistakes_are_one_line_too(self, monkeypatch, refused):
        self.register(monkeypatch, "tests.llsrbm.plugin:greet")
        assert "--times" in refused("greet", "--times", "x")
        assert refused("greet", "--name", "nobody") == "nobody is not somebody\n"

    def test_that_cannot_be_loaded(self, monkeypatch, capsys):
        self.register(monkeypatch, "tests.llsrbm.nosuch:greet")
        assert cli.main(["greet"]) == 1
        assert 'command "greet" (tests.llsrbm.nosuch:greet)' in capsys.readouterr().err
