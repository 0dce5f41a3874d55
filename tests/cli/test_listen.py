"""`attune listen` prints what is in recordings, and one clear line for each that it cannot use."""

import json
from pathlib import Path

import numpy as np
import pytest
import soundfile
from typer.testing import CliRunner

from attune.cli.main import app
from attune.evaluation.speakers import noise, people

KEYS = {"file", "start", "end", "text", "alternatives", "confidence", "in_domain", "age"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    def quiet(seconds: float) -> np.ndarray:
        return noise(int(16000 * seconds), -65, np.random.default_rng(0))

    anna, dan = people()[0], people()[3]
    cup = np.concatenate([quiet(0.5), anna.say("bring me a cup"), quiet(1.5), dan.say("stop"), quiet(1)])
    soundfile.write(tmp_path / "a.wav", cup, 16000)
    soundfile.write(tmp_path / "b.flac", noise(48000, -25, np.random.default_rng(0)), 16000)
    (tmp_path / "c.wav").write_text("this is no sound")
    (tmp_path / "notes.txt").write_text("not for listening")
    return tmp_path


def test_each_utterance_is_a_line_and_bad_recordings_do_not_end_the_run(folder: Path) -> None:
    result = CliRunner().invoke(app, ["listen", str(folder / "missing.wav"), str(folder)])
    assert result.exit_code == 1
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    utterances = [line for line in lines if "text" in line]
    assert [line["text"] for line in utterances] == ["bring me a cup", "stop"]
    assert all(set(line) == KEYS and line["file"] == str(folder / "a.wav") for line in utterances)
    assert 0.4 < utterances[0]["start"] < utterances[0]["end"] < 2.0
    stops = [line for line in lines if "stop_at" in line]
    assert len(stops) == 1
    assert utterances[1]["start"] < stops[0]["stop_at"] < utterances[1]["end"] + 0.2
    assert all(line.startswith("attune: ") for line in result.stderr.splitlines())
    for problem in (
        "missing.wav is not a file",
        "b.flac: no speech that could be understood",
        "c.wav is no recording in a known format",
    ):
        assert problem in result.stderr


def test_telephone_sound_is_refused_with_the_rate_it_should_have(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "phone.wav", people()[0].say("bring me a cup")[::2], 8000)
    result = CliRunner().invoke(app, ["listen", str(tmp_path / "phone.wav")])
    assert result.exit_code == 1
    assert "phone.wav has 8000 samples per second" in result.stderr
    assert "16000" in result.stderr


def test_good_recordings_give_exit_status_0(folder: Path) -> None:
    result = CliRunner().invoke(app, ["listen", str(folder / "a.wav"), "--asr", "sphinx"])
    assert result.exit_code == 0
    assert result.stderr == ""


def test_a_folder_without_recordings_is_named(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["listen", str(tmp_path)])
    assert result.exit_code == 1
    assert f"{tmp_path} has no recordings" in result.stderr


def test_a_clipped_recording_is_warned_about_on_standard_error_or_as_a_line(tmp_path: Path) -> None:
    loud = np.clip(20 * people()[0].say("bring me a cup and a bowl from the table please"), -1, 1)
    soundfile.write(tmp_path / "loud.wav", np.concatenate([np.zeros(8000), loud, np.zeros(16000)]), 16000)
    plain = CliRunner().invoke(app, ["listen", str(tmp_path / "loud.wav")])
    assert plain.stderr.count("too loud") == 1
    assert all({"text", "stop_at"} & set(json.loads(line)) for line in plain.stdout.splitlines())
    as_json = CliRunner().invoke(app, ["listen", str(tmp_path / "loud.wav"), "--json"])
    assert "too loud" not in as_json.stderr
    warned = [line for line in map(json.loads, as_json.stdout.splitlines()) if "warning" in line]
    assert [set(line) for line in warned] == [{"file", "at", "warning"}]
