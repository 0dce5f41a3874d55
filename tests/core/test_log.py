"""Logs are structured, and what people said stays out of them unless asked."""

import json
from pathlib import Path

import pytest

from attune.core.log import configure_logging, get_logger


@pytest.mark.parametrize("keep_speech", [False, True])
def test_speech_is_written_only_if_asked(tmp_path: Path, keep_speech: bool) -> None:
    file = tmp_path / "attune.log"
    configure_logging(level="info", file=file, keep_speech=keep_speech)
    get_logger("dialogue").info("understood", command="bring_me", speech="bring me my pills")
    configure_logging()
    entry = json.loads(file.read_text(encoding="utf-8"))
    assert entry["command"] == "bring_me"
    assert entry["module"] == "dialogue"
    assert ("pills" in file.read_text(encoding="utf-8")) is keep_speech
