"""The evaluation, through the commands that people type."""

import json
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from attune.cli.eval_age import eval_age
from attune.cli.train_age import train_age
from attune.core.errors import AttuneError
from attune.evaluation.age import EvaluationError, choose_clips

from .conftest import Trained


def run(command, *arguments: object):  # type: ignore[no-untyped-def]
    app = typer.Typer()
    app.command()(command)
    return CliRunner().invoke(app, [str(argument) for argument in arguments], catch_exceptions=False)


def test_eval_age_reports_beside_the_paper_with_table_and_picture(
    trained: Trained, corpus: Path, tmp_path: Path
) -> None:
    result = run(
        eval_age, "--common-voice", corpus, "--model", trained.model, "--part", "held-out", "--out", tmp_path, "--json"
    )
    data = json.loads(result.stdout)
    assert data == json.loads((tmp_path / "age.json").read_text())
    assert data["all"]["count"] == sum(map(sum, data["confusion"])) == 65
    assert data["skipped"] == 1
    assert data["all"]["binary_accuracy"] > 0.85
    assert sum(part["count"] for part in data["parts"]["gender"].values()) == 65
    text = (tmp_path / "age.md").read_text()
    assert "| 97.8% |" in text
    assert "59.5%" in text
    assert (tmp_path / "confusion.png").read_bytes().startswith(b"\x89PNG")


def test_held_out_clips_need_the_corpus_of_the_training(trained: Trained, corpus: Path, tmp_path: Path) -> None:
    (tmp_path / "clips").mkdir()
    rows = (corpus / "train.tsv").read_text().splitlines(keepends=True)
    (tmp_path / "train.tsv").write_text("".join(rows))
    (tmp_path / "dev.tsv").write_text(rows[0])
    with pytest.raises(EvaluationError, match="not the corpus"):
        choose_clips(tmp_path, "held-out", trained.model)


def test_a_model_that_does_not_say_what_it_held_out_is_measured_on_test(paper_folder: Path, corpus: Path) -> None:
    with pytest.raises(EvaluationError, match="--part test"):
        choose_clips(corpus, "held-out", paper_folder)


def test_train_age_writes_both_forms_and_the_fast_one_can_be_measured(
    trained: Trained, corpus: Path, tmp_path: Path
) -> None:
    assert "commonest" in trained.printed
    assert "2 damaged clips were skipped" in trained.printed
    assert {path.name for path in trained.model.parent.iterdir()} == {"model", "onnx", "runs", "cache"}
    fast = run(eval_age, "--common-voice", corpus, "--model", trained.onnx, "--part", "held-out",
               "--training", trained.model, "--limit", 8, "--out", tmp_path)  # fmt: skip
    assert fast.exit_code == 0
    assert "of the part held-out" in fast.stdout


def test_an_unknown_group_is_answered_with_the_known_ones(corpus: Path, paper_folder: Path) -> None:
    with pytest.raises(AttuneError, match="fourties"):
        run(eval_age, "--common-voice", corpus, "--model", paper_folder, "--older-from", "old")


def test_a_missing_column_is_told_before_anything_is_computed(
    corpus: Path, whisper_folder: Path, tmp_path: Path
) -> None:
    (tmp_path / "clips").mkdir()
    for name in ("train.tsv", "dev.tsv"):
        (tmp_path / name).write_text((corpus / name).read_text().replace("\tage\t", "\tyears\t", 1))
    with pytest.raises(AttuneError, match="lacks the column age"):
        run(train_age, "--common-voice", tmp_path, "--encoder", whisper_folder, "--out", tmp_path / "out")
    assert not (tmp_path / "out" / "cache").exists()
