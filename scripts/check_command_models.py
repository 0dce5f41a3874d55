"""Measures how sentences of authors are understood whom neither the command model nor the network has seen.

    python scripts/check_command_models.py embeddings.npz

Leaves groups of authors out of the training in turn, and counts what the whole interpreter makes of their sentences:
commands right, commands made from what was none, stops missed. Takes about an hour on one core.
"""

import json
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import anyio
import torch
import train_command_model
import train_command_network
from train_command_model import SENTENCES, read, sampled
from train_command_network import Embeddings

from attune.cli.understanding import interpret_lines
from attune.core.scene import load_scene
from attune.dialogue.corpus import scene_lexicon
from attune.dialogue.grammar.command_judge import CommandJudge
from attune.dialogue.grammar.interpreter import GrammarInterpreter

LEFT_OUT = (
    ("round_19", "round_25", "round_28", "round_31"), ("round_6", "round_14", "round_20", "round_24"),
    ("round_7", "round_15", "round_21", "round_26"), ("round_8", "round_12", "round_22", "round_27"),
    ("round_9", "round_13", "round_23", "round_29"), ("round_10", "round_16", "round_18", "round_30"),
    ("rounds_1_to_5", "round_17", "round_32"),
)  # fmt: skip


def judge_without(groups: Iterable[str], embeddings: Embeddings) -> CommandJudge:
    """Trained on all other groups."""
    examples = [*read(path for path in sorted(SENTENCES.glob("*.jsonl")) if path.stem not in set(groups)), *sampled()]
    return CommandJudge(train_command_model.train(examples), train_command_network.train(examples, embeddings))


def count(path: Path, interpreter: GrammarInterpreter) -> Counter[str]:
    """What becomes of the sentences of one group."""
    counts: Counter[str] = Counter()
    answers: list[str] = []
    anyio.run(interpret_lines, path.read_bytes(), interpreter, answers.append)
    for line, answer in zip(path.read_text("utf-8").splitlines(), answers, strict=True):
        got, want = json.loads(answer)["command"], json.loads(line)["expect"]["command"]
        counts["others" if want == "other" else "commands"] += 1
        counts["right"] += want != "other" and got == want
        counts["false"] += want == "other" and got != want
        counts["stops"] += want == "stop"
        counts["missed"] += want == "stop" and got != want
    return counts


def main() -> None:
    """Leave out, train, count, print."""
    torch.set_num_threads(1)
    embeddings = Embeddings(Path(sys.argv[1]))
    lexicon = scene_lexicon(load_scene())
    total: Counter[str] = Counter()
    for groups in LEFT_OUT:
        interpreter = GrammarInterpreter(lexicon, judge_without(groups, embeddings))
        for group in groups:
            counts = count(SENTENCES / f"{group}.jsonl", interpreter)
            total += counts
            report(group, counts)
    report("all", total)


def report(name: str, counts: Counter[str]) -> None:
    """One line."""
    print(  # noqa: T201 - a script
        f"{name}: {counts['right']} of {counts['commands']} commands right, {counts['false']} false of "
        f"{counts['others']}, {counts['missed']} of {counts['stops']} stops missed",
        flush=True,
    )


if __name__ == "__main__":
    main()
