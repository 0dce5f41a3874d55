"""`attune understand`: the file format of DESIGN.md, bad input included."""

import json
from pathlib import Path

from typer.testing import CliRunner

from attune.cli.main import app

KEYS = ["id", "command", "add", "remove", "destination", "reply", "confidence", "reason"]


def understand(*arguments: str, lines: str = "") -> tuple[int, list[dict[str, object]]]:
    result = CliRunner().invoke(app, ["understand", *arguments], input=lines)
    return result.exit_code, [json.loads(line) for line in result.stdout.splitlines()]


def test_each_line_gives_one_result_with_exactly_the_keys_in_order() -> None:
    lines = '{"id": "a", "utterance": "bring me the red cup", "context": {}}\n{"id": 7, "utterance": "thanks"}\n'
    code, results = understand(lines=lines)
    assert code == 0
    assert [list(result) for result in results] == [KEYS, KEYS]
    assert [result["id"] for result in results] == ["a", 7]
    assert results[0]["add"] == [{"type": "cup", "color": "red", "size": "", "location": ""}]
    assert results[1]["command"] == "other"


def test_a_bad_line_names_its_number_and_the_run_goes_on() -> None:
    lines = (
        'no json\n\n[1]\n{"id": 1}\n{"id": 2, "utterance": 5}\n{"id": 3, "utterance": "stop", "context": {"task": 4}}\n'
    )
    code, results = understand(lines=lines + '{"id": 4, "utterance": "stop"}\n')
    assert code == 0
    assert [result.get("line") for result in results] == [1, 3, 4, 5, 6, None]
    assert all(result["error"] for result in results[:-1])
    assert results[-1]["command"] == "stop"


def test_the_output_file_is_written_whole(tmp_path: Path) -> None:
    source, target = tmp_path / "in.jsonl", tmp_path / "out.jsonl"
    source.write_text(
        '{"id": 1, "utterance": "put it on the table", "context": {"task": null, "scene": []}}\n', "utf-8"
    )
    code, _ = understand("--in", str(source), "--out", str(target))
    assert code == 0
    assert json.loads(target.read_text("utf-8"))["destination"] == "table"
    assert {path.name for path in tmp_path.iterdir()} == {"in.jsonl", "out.jsonl"}


def test_text_that_is_not_utf_8_is_a_bad_line_and_not_the_end(tmp_path: Path) -> None:
    source = tmp_path / "in.jsonl"
    source.write_bytes(b'\xff\xfe\n{"id": 1, "utterance": "halt"}\n')
    code, results = understand("--in", str(source))
    assert code == 0
    assert results[0]["line"] == 1
    assert results[1]["command"] == "stop"


def test_a_missing_file_is_an_error_with_its_name(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["understand", "--in", str(tmp_path / "none.jsonl")])
    assert result.exit_code != 0
    assert "none.jsonl" in str(result.exception)
