"""Hearing is measured right: on recordings whose errors are known, and on little synthetic speech."""

import json
from pathlib import Path

import numpy as np
import pytest
import soundfile
from typer.testing import CliRunner

from attune.cli.main import app
from attune.evaluation.speakers import people
from attune.evaluation.speech import Ears, SpeechEvaluation, evaluate_speech
from attune.evaluation.speech_report import figures, to_data, to_markdown, write_report
from attune.evaluation.speech_samples import (
    ManifestError,
    Sample,
    SampleSet,
    held_out_speakers,
    read_samples,
    synthetic_set,
)
from attune.speech.sphinx import SphinxRecogniser

ANNA = people()[0]
ERIK = people()[4]
"""His voice, unlike Anna's breathy one, is the same in every process."""
SENTENCES = ["bring me a cup", "bring me the red bowl", "put it on the table", "stop", "please stop", "don't stop"] * 5
KEYWORDS = frozenset({"cup", "bowl", "red", "blue", "table"})


@pytest.fixture(scope="module")
def ears(tmp_path_factory: pytest.TempPathFactory) -> Ears:
    cache = tmp_path_factory.mktemp("models")
    return Ears(lambda: SphinxRecogniser(SENTENCES, cache))


@pytest.fixture(scope="module")
def evaluation(ears: Ears) -> SpeechEvaluation:
    """Three requests, one of which says the wrong thing, other talk, a stop and a negated one."""
    said = [
        Sample("Bring me a cup!", "anna", voice=ANNA),
        Sample("put it on the table", "anna", voice=ANNA),
        Sample("the weather forecast says it will rain tomorrow", "anna", "off_topic", voice=ANNA),
        Sample("stop", "anna", "stop", voice=ANNA),
        Sample("don't stop", "anna", "not_stop", voice=ANNA),
    ]
    return evaluate_speech(
        SampleSet("little", "synthetic speech, no human", "synthetic", tuple(said)), ears, (None, -10.0)
    )


def test_what_is_heard_right_has_no_errors(evaluation: SpeechEvaluation) -> None:
    row = figures(evaluation, KEYWORDS)["clean"]["espeak-ng"]
    assert row["sentences"] == 2
    assert row["word error rate [%]"] == row["character error rate [%]"] == row["incomplete or erroneous [%]"] == 0
    assert row["keywords heard [%]"] == row["acted on [%]"] == 100
    assert row["cut off [%]"] == 0
    assert 300 < row["endpoint delay, median [ms]"] < 900


def test_stops_other_talk_and_negated_stops_are_counted(evaluation: SpeechEvaluation) -> None:
    row = figures(evaluation, KEYWORDS)["clean"]["espeak-ng"]
    assert row["stops"] == 1
    assert row["stops not spotted [%]"] == 0
    assert row["stop spotted after the end of the word, median [ms]"] < 300
    assert row["off-topic speech acted on [%]"] == 0
    assert row["halted for good by them [%]"] == 0


def test_noise_louder_than_speech_makes_it_worse(evaluation: SpeechEvaluation) -> None:
    table = figures(evaluation, KEYWORDS)
    assert table["pink noise, -10 dB"]["espeak-ng"]["acted on [%]"] < table["clean"]["espeak-ng"]["acted on [%]"]


def test_errors_are_counted_as_jiwer_counts_them(ears: Ears, tmp_path: Path) -> None:
    """The list claims other words than those in the recordings: one of four is another, one of five is too many."""
    for name, text in (("a", "bring me a cup"), ("b", "bring me the red bowl")):
        soundfile.write(tmp_path / f"{name}.wav", np.concatenate([np.zeros(4000), ANNA.say(text)]), 16000)
    lines = [{"audio": "a.wav", "text": "bring me a bowl"}, {"audio": "b.wav", "text": "bring me the bowl"}]
    (tmp_path / "list.jsonl").write_text("\n".join(map(json.dumps, lines)))
    evaluation = evaluate_speech(read_samples(tmp_path / "list.jsonl"), ears)
    row = figures(evaluation, KEYWORDS)["clean"]["recordings"]
    assert row["word error rate [%]"] == 25.0
    assert row["incomplete or erroneous [%]"] == 100
    assert row["keywords heard [%]"] == 50
    assert row["acted on with a wrong or missing keyword [%]"] == 100


def test_the_report_says_on_what_it_was_measured(evaluation: SpeechEvaluation, tmp_path: Path) -> None:
    text = to_markdown(evaluation, KEYWORDS)
    assert "Measured on synthetic speech, no human." in text
    assert "Nobody human was heard" in text
    assert "14.84" not in text
    write_report(evaluation, KEYWORDS, tmp_path / "out")
    data = json.loads((tmp_path / "out" / "speech.json").read_text())
    assert data == json.loads(json.dumps(to_data(evaluation, KEYWORDS)))
    assert data["source"] == "synthetic"


def test_the_plot_is_drawn(evaluation: SpeechEvaluation, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="the extra `plots` is not installed")
    from attune.evaluation.speech_report import draw

    draw(evaluation, KEYWORDS, tmp_path / "speech.png")
    assert (tmp_path / "speech.png").read_bytes().startswith(b"\x89PNG")


def test_common_voice_is_read_and_compared_with_the_paper(ears: Ears, tmp_path: Path) -> None:
    (tmp_path / "clips").mkdir()
    soundfile.write(tmp_path / "clips" / "one.mp3", ANNA.say("bring me a cup"), 16000)
    (tmp_path / "test.tsv").write_text(
        "client_id\tpath\tsentence\tage\nabc\tone.mp3\tBring me a cup.\t\nabc\t../../etc/passwd\t\t\n"
    )
    samples = read_samples(tmp_path)
    assert [sample.path for sample in samples.samples] == [tmp_path / "clips" / "one.mp3"]
    evaluation = evaluate_speech(samples, ears)
    assert figures(evaluation, KEYWORDS)["clean"]["recordings"]["word error rate [%]"] == 0
    text = to_markdown(evaluation, KEYWORDS)
    assert "14.84 %" in text
    assert "5.20 %" in text
    assert "off-topic" not in text


def test_the_command_measures_a_list_of_recordings(tmp_path: Path) -> None:
    soundfile.write(tmp_path / "a.wav", ERIK.say("bring me a cup"), 16000)
    (tmp_path / "list.jsonl").write_text(json.dumps({"audio": "a.wav", "text": "bring me a cup"}))
    out = tmp_path / "out"
    result = CliRunner().invoke(
        app, ["eval", "speech", str(tmp_path / "list.jsonl"), "--asr", "sphinx", "--snr", "20", "--out", str(out)]
    )
    assert result.exit_code == 0, result.output
    found = json.loads((out / "speech.json").read_text())["figures"]
    assert list(found) == ["clean", "pink noise, 20 dB"]
    assert found["clean"]["recordings"]["word error rate [%]"] == 0


def test_a_bad_list_is_named_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "list.jsonl"
    for content, problem in (
        ('{"audio": "a.wav", "text": "a"}\n{"audio": 3}', "line 2"),
        ("no json", "line 1"),
        ("", "lists no recordings"),
        ('{"audio": "a.wav", "text": "a", "kind": "song"}', "line 1"),
    ):
        path.write_text(content)
        with pytest.raises(ManifestError, match=problem):
            read_samples(path)
    (tmp_path / "test.tsv").write_text("path\tage\n")
    for wrong, problem in ((tmp_path, "lacks the column sentence"), (tmp_path / "none.jsonl", "is not a file")):
        with pytest.raises(ManifestError, match=problem):
            read_samples(wrong)


def test_held_out_voices_and_sentences_are_not_those_of_the_demo() -> None:
    voices = [speaker.voice for speaker in held_out_speakers()]
    assert len(set(voices)) == len(voices)
    assert not {speaker.voice for speaker in people()[:8]} & set(voices)
    chosen = synthetic_set(held_out_speakers()[:1], most=3)
    assert len(chosen.samples) == 12
    assert "no human" in chosen.description
