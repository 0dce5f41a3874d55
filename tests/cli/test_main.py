"""The command line: quick, helpful, and one clear line when something is wrong."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

COMMANDS = ("demo", "live", "say", "understand", "listen", "devices", "doctor")


def attune(
    *arguments: str, cwd: Path, text: str = "", env: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "attune", *arguments],
        input=text,
        capture_output=True,
        text=True,
        cwd=cwd,
        env=os.environ | (env or {}),
        timeout=120,
        check=False,
    )


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_explains_itself_with_an_example(command: str, tmp_path: Path) -> None:
    result = attune(command, "--help", cwd=tmp_path)
    assert result.returncode == 0
    assert f"attune {command}" in result.stdout
    assert "Example" in result.stdout


def test_help_loads_nothing_heavy(tmp_path: Path) -> None:
    heavy = ("mujoco", "numpy", "scipy", "pocketsphinx", "torch", "sounddevice", "pydantic")
    code = f"import sys; import attune.cli.main; print([name for name in {heavy} if name in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, check=True)
    assert result.stdout.strip() == "[]"


def test_doctor_finds_what_comes_with_the_package(tmp_path: Path) -> None:
    result = attune("doctor", "--json", cwd=tmp_path)
    findings = {finding["part"]: finding for finding in json.loads(result.stdout)}
    assert result.returncode == 0
    for part in ("simulation", "voice activity", "recogniser", "voice", "configuration"):
        assert findings[part]["state"] == "ok", findings[part]
    for finding in findings.values():
        assert finding["state"] == "ok" or finding["remedy"]


@pytest.mark.parametrize(
    ("arguments", "config", "named"),
    [
        (("doctor", "--loudly"), "", "--loudly"),
        (("demo", "dinner"), "", "dinner"),
        (("demo", "--fast", "--text"), "[planner]\nbreakfst = []\n", "planner.breakfst"),
        (("live", "--text"), "[robot]\nscene = 'nowhere.toml'\n", "nowhere.toml"),
        (("live", "--text"), "[robot\n", "not valid TOML"),
        (("live", "--age", "ancient"), "", "ancient"),
        (("say", " "), "", "nothing to say"),
        (("say", "hello", "--socket", "nowhere.sock"), "", "attune live"),
    ],
)
def test_bad_input_gives_one_clear_line_and_no_traceback(
    arguments: tuple[str, ...], config: str, named: str, tmp_path: Path
) -> None:
    if config:
        (tmp_path / "attune.toml").write_text(config, encoding="utf-8")
    result = attune(*arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert named in result.stderr
    assert "Traceback" not in result.stderr


def test_live_takes_lines_from_a_pipe_and_lets_the_robot_finish(tmp_path: Path) -> None:
    result = attune("live", "--text", "--robot", "symbolic", cwd=tmp_path, text="bring me a cup\nstop\n")
    assert result.returncode == 0, result.stderr
    assert "bring_me cup" in result.stdout
    assert "stopped" in result.stdout
