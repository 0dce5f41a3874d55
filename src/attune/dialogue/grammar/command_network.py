"""A small convolutional network over word embeddings: what an utterance asks for, by what its words mean.

The log-linear model knows the words that it has seen. The network starts from embeddings that a language model has
learnt from much English text, so that a word nobody used in our sentences is like others that somebody did.
`scripts/train_command_network.py` trains it; `data/command_network.txt` says where the embeddings are from.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

Vectors = NDArray[np.float32]

UNKNOWN, SEPARATOR = "[UNK]", "[SEP]"
WIDTHS = (1, 3, 5)
LONGEST_UTTERANCE, LONGEST = 44, 64
"""Pieces of words."""
_MARGIN = max(WIDTHS) // 2


def pieces(word: str, known: Mapping[str, int]) -> list[str]:
    """A word as the longest known pieces, those within the word with a leading `##` (WordPiece, as BERT has it)."""
    found: list[str] = []
    start = 0
    while start < len(word):
        for end in range(len(word), start, -1):
            piece = ("##" if start else "") + word[start:end]
            if piece in known:
                found.append(piece)
                start = end
                break
        else:
            return [UNKNOWN]
    return found


def encode(words: Sequence[str], situation: Sequence[str], known: Mapping[str, int]) -> list[int]:
    """Both as numbers of pieces, with a separator between them."""
    uttered = list(_numbers(words, known))[:LONGEST_UTTERANCE]
    return [*uttered, known[SEPARATOR], *_numbers(situation, known)][:LONGEST]


def _numbers(words: Sequence[str], known: Mapping[str, int]) -> Iterator[int]:
    return (known[piece] for word in words for piece in pieces(word, known))


class CommandNetwork:
    """Judges words.

    Args:
        known: The number of each piece of a word.
        embeddings: One row for each piece, in steps of `step`, shape (pieces, dimensions).
        step: The size of such a step.
        segments: What is added to the embeddings of the utterance, and to those of the situation, shape
            (2, dimensions).
        filters: For each of `WIDTHS` weights of shape (width x dimensions, filters) and biases.
        head: Weights from all filters to commands, and biases.
    """

    def __init__(
        self, known: Mapping[str, int], embeddings: NDArray[np.int8], step: float, segments: Vectors,
        filters: Sequence[tuple[Vectors, Vectors]], head: tuple[Vectors, Vectors],
    ) -> None:  # fmt: skip
        self._known = known
        self._embeddings = embeddings
        self._step = np.float32(step)
        self._segments = segments
        self._filters = filters
        self._head = head

    def judge(self, words: Sequence[str], situation: Sequence[str]) -> Vectors:
        """The logarithms of the probabilities of the commands, in the order of `COMMANDS`."""
        numbers = encode(words, situation, self._known)
        about_situation = np.arange(len(numbers)) >= numbers.index(self._known[SEPARATOR])
        rows = self._embeddings[numbers] * self._step + self._segments[about_situation.astype(np.intp)]
        values = np.zeros((len(rows) + 2 * _MARGIN, rows.shape[1]), np.float32)
        values[_MARGIN:-_MARGIN] = np.tanh(rows)
        strongest = [_strongest(values, width, *layer) for width, layer in zip(WIDTHS, self._filters, strict=True)]
        scores = np.concatenate(strongest) @ self._head[0] + self._head[1]
        scores -= scores.max()
        return np.asarray(scores - np.log(np.exp(scores).sum()), np.float32)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read what `save` wrote."""
        with np.load(path) as data:
            names = bytes(data["pieces"]).decode("utf-8").split("\n")
            halves = {name: data[name].astype(np.float32) for name in data.files if data[name].dtype == np.float16}
            return cls(
                {name: number for number, name in enumerate(names)}, data["embeddings"], float(data["step"]),
                halves["segments"], [(halves[f"filters_{width}"], halves[f"bias_{width}"]) for width in WIDTHS],
                (halves["head"], halves["head_bias"]),
            )  # fmt: skip

    def save(self, path: Path) -> None:
        """Write it to a file, all but the embeddings with half precision."""
        pieces = np.frombuffer("\n".join(self._known).encode(), np.uint8)
        arrays = {"segments": self._segments, "head": self._head[0], "head_bias": self._head[1]}
        for width, (weights, bias) in zip(WIDTHS, self._filters, strict=True):
            arrays |= {f"filters_{width}": weights, f"bias_{width}": bias}
        halves: dict[str, Any] = {name: array.astype(np.float16) for name, array in arrays.items()}
        np.savez_compressed(path, pieces=pieces, embeddings=self._embeddings, step=self._step, **halves)


def _strongest(values: Vectors, width: int, weights: Vectors, bias: Vectors) -> Vectors:
    """The strongest response of each filter anywhere, none below 0."""
    beside = _MARGIN - width // 2
    length = len(values) - 2 * _MARGIN
    parts = weights.reshape(width, -1, weights.shape[1])
    responses = values[beside : beside + length] @ parts[0]
    for offset in range(1, width):
        responses += values[beside + offset : beside + offset + length] @ parts[offset]
    return np.asarray(np.maximum(responses.max(axis=0) + bias, 0), np.float32)


@cache
def load_command_network() -> CommandNetwork:
    """The network that comes with Attune."""
    with resources.as_file(resources.files("attune.data") / "command_network.npz") as path:
        return CommandNetwork.load(path)
