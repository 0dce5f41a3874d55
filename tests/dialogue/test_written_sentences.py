"""The sentences that the command model learnt from are understood, with their objects and places.

They were written without a look at the rules, each file by other imagined speakers. This shows that nothing is lost,
with every stop of each file and a third of the rest; how well unseen sentences are understood is measured by `attune
eval language` on its fresh part.
"""

import json
from pathlib import Path

import anyio
import pytest

from attune.cli.understanding import interpret_lines
from attune.core.scene import load_scene
from attune.dialogue.corpus import scene_lexicon
from attune.dialogue.grammar.interpreter import GrammarInterpreter

FILES = sorted((Path(__file__).parents[2] / "scripts/understanding").glob("*.jsonl"))
EMBEDDED = GrammarInterpreter(scene_lexicon(load_scene()))


@pytest.mark.parametrize("file", FILES, ids=[file.stem for file in FILES])
def test_written_sentences_are_understood_and_no_stop_is_missed(file: Path) -> None:
    every = [json.loads(line) for line in file.read_text("utf-8").splitlines()]
    assert len(every) >= 500
    lines = [line for number, line in enumerate(every) if number % 3 == 0 or line["expect"]["command"] == "stop"]
    written: list[str] = []
    anyio.run(interpret_lines, "\n".join(map(json.dumps, lines)).encode(), EMBEDDED, written.append)
    answers = [(line["utterance"], line["expect"], json.loads(got)) for line, got in zip(lines, written, strict=True)]
    wrong = [text for text, want, got in answers if got["command"] != want["command"]]
    incomplete = [text for text, want, got in answers if {key: got[key] for key in want} != want]
    assert len(wrong) <= 0.06 * len(lines), wrong
    assert len(incomplete) <= 0.09 * len(lines), incomplete
    assert [text for text, want, got in answers if want["command"] == "stop" and got["command"] != "stop"] == []
