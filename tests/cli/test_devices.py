"""`attune devices` shows how loud a microphone is, and says what is wrong where there is none."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from attune.cli.devices import show_levels
from attune.cli.main import app
from attune.core.clock import VirtualClock, run
from attune.core.errors import AttuneError
from attune.evaluation.speakers import noise
from attune.speech.audio import ArraySource


def test_each_second_of_sound_gives_a_line_and_each_problem_one_warning(capsys: pytest.CaptureFixture[str]) -> None:
    sound = np.concatenate([noise(48000, -30, np.random.default_rng(0), "white"), np.zeros(48000, np.float32)])
    clock = VirtualClock()
    run(lambda: show_levels(ArraySource(sound), clock, 6), clock)
    printed = capsys.readouterr()
    levels = [float(line.split(" dB")[0]) for line in printed.out.splitlines()]
    assert levels[:2] == pytest.approx([-30, -30], abs=0.5)
    assert min(levels) < -85
    assert printed.err.count("no sound at all") == 1


def test_json_has_level_peak_and_problems(capsys: pytest.CaptureFixture[str]) -> None:
    clock = VirtualClock()
    run(lambda: show_levels(ArraySource(np.zeros(32000, np.float32)), clock, 1, as_json=True), clock)
    line = json.loads(capsys.readouterr().out.splitlines()[0])
    assert line["problems"] == ["dead"]
    assert line["level"] == line["peak"] == -120


def test_a_microphone_that_is_not_there_is_named(tmp_path: Path) -> None:
    (tmp_path / "attune.toml").write_text('[speech]\nmicrophone = "no such thing"\n')
    result = CliRunner().invoke(app, ["devices", "--level", "1", "--config", str(tmp_path / "attune.toml")])
    assert isinstance(result.exception, AttuneError)
    assert "no such thing" in str(result.exception)
