"""A second opinion on what an utterance asks for: a log-linear model of the command, learnt from written sentences.

The rules of the grammar miss unusual ways to ask ("my tea is ready but I have nothing to put it in, so a cup, please").
The model has seen some thousand sentences as skeletons, in which all objects look alike, and so it knows a request by
its words whatever is asked for. `scripts/train_command_model.py` makes its weights.
"""

import math
import re
from collections.abc import Container, Iterable, Iterator, Sequence
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attune.dialogue.context import Context
from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.evidence import abstract, signs
from attune.dialogue.interpreter import CommandIntent
from attune.dialogue.lexicon import Lexicon

COMMANDS: tuple[CommandIntent, ...] = (
    "bring_me", "setting_breakfast", "replace_object", "change_location", "stop", "other",
)  # fmt: skip
_LONGEST_ACTION = 4
_USUAL_COUNT = 120


class CommandModel:
    """Judges skeletons.

    Args:
        features: What the rows of `weights` are about.
        weights: One row for each feature, one column for each of `COMMANDS`, shape (features, 6).
        bias: Shape (6,).
        familiar: The words that people use in commands.
    """

    def __init__(
        self, features: Sequence[str], weights: NDArray[np.float32], bias: NDArray[np.float32], familiar: frozenset[str]
    ) -> None:
        self._rows = {feature: row for row, feature in enumerate(features)}
        self._weights = weights
        self._bias = bias
        self._familiar = familiar

    def knows(self, word: str) -> bool:
        """Whether a word occurred in what the model learnt from."""
        return f"w {word}" in self._rows

    def judge(self, sentence: Sentence, context: Context, lexicon: Lexicon) -> dict[CommandIntent, float]:
        """The probability of each command."""
        seen = set(features(sentence, context, lexicon, self._familiar))
        rows = [row for row in map(self._rows.get, seen) if row is not None]
        scores = self._weights[rows].sum(axis=0) * share(len(rows)) + self._bias
        likelihoods = np.exp(scores - scores.max())
        return dict(zip(COMMANDS, (likelihoods / likelihoods.sum()).tolist(), strict=True))

    def save(self, path: Path) -> None:
        """Write it to a file, with weights of half precision."""
        np.savez_compressed(
            path, features=_as_bytes(self._rows), familiar=_as_bytes(sorted(self._familiar)),
            weights=self._weights.astype(np.float16), bias=self._bias.astype(np.float16),
        )  # fmt: skip


def _as_bytes(words: Iterable[str]) -> NDArray[np.uint8]:
    return np.frombuffer("\n".join(words).encode(), np.uint8)


@cache
def load_command_model() -> CommandModel:
    """The model that comes with Attune."""
    with (resources.files("attune.data") / "command_model.npz").open("rb") as file, np.load(file) as data:
        names = bytes(data["features"]).decode("utf-8").split("\n")
        familiar = frozenset(bytes(data["familiar"]).decode("utf-8").split("\n"))
        return CommandModel(names, data["weights"].astype(np.float32), data["bias"].astype(np.float32), familiar)


def features(sentence: Sentence, context: Context, lexicon: Lexicon, familiar: Container[str]) -> Iterator[str]:
    """What the model looks at: runs of words, of kinds of words, and how they go with the situation."""
    plain = plain_words(sentence)
    kinds = _kinds(sentence, lexicon)
    situation = "busy" if context.task else "done" if context.delivered else "idle"
    yield from _runs("w", plain, 2)
    yield from _runs("k", kinds, 3)
    yield from _runs("a", abstract(kinds, familiar), 4)
    yield f"situation {situation}"
    for kind in kinds:
        yield f"{situation} {kind}"
    if context.pending_question:
        yield "asked"
        yield from (f"asked {kind}" for kind in kinds[:4])
    about = {spec.type for spec in context.recent}
    named = [thing.spec.type for thing in sentence.things if thing.head == "noun"]
    yield f"names what it is about {any(type_ in about for type_ in named)}"
    yield f"names something new {any(type_ not in about for type_ in named)} {situation}"
    yield f"length {min(len(plain) // 4, 5)}"
    yield f"things {min(len(sentence.things), 3)} {situation}"
    yield f"places {min(len(sentence.spots), 2)} {situation}"
    yield f"called {sentence.called}"
    yield f"called {sentence.called} {situation}"
    yield from signs(plain, kinds, familiar)


def share(count: int) -> float:
    """How much each of the features of a sentence weighs: a long sentence is not surer than a short one."""
    return math.sqrt(_USUAL_COUNT / max(count, 1))


def plain_words(sentence: Sentence) -> list[str]:
    """The words of the skeleton, with all things and all places alike."""
    return re.sub(r"\b([TP])\d+\b", r"\1", sentence.skeleton).split()


def _runs(name: str, words: Sequence[str], longest: int) -> Iterator[str]:
    padded = ["<", *words, ">"]
    for length in range(1, longest + 1):
        for start in range(len(padded) - length + 1):
            yield f"{name} {' '.join(padded[start : start + length])}"
    for before, after in zip(padded, padded[2:], strict=False):
        yield f"{name} {before} _ {after}"


def _kinds(sentence: Sentence, lexicon: Lexicon) -> list[str]:
    """The words, with all verbs of one kind, all names, and all things of one kind alike."""
    words = [_placeholder(word, sentence) for word in sentence.skeleton.split()]
    kinds: list[str] = []
    at = 0
    while at < len(words):
        for length in range(min(_LONGEST_ACTION, len(words) - at), 0, -1):
            action = lexicon.actions.get(" ".join(words[at : at + length]))
            if action:
                kinds.append(action.upper())
                at += length
                break
        else:
            word = words[at]
            kinds.append("NAME" if word in lexicon.names else "PERSON" if word in lexicon.people else word)
            at += 1
    return kinds


def _placeholder(word: str, sentence: Sentence) -> str:
    if re.fullmatch(r"T\d+", word):
        thing = sentence.things[int(word[1:])]
        return "UNKNOWN" if thing.unknown else "THING" if thing.head == "noun" else "ONE"
    if re.fullmatch(r"P\d+", word):
        return f"PLACE{sentence.spots[int(word[1:])].role}"
    return word
