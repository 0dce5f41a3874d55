"""Trains the command network on the written sentences in `scripts/understanding` and some sampled ones.

    python scripts/train_command_network.py embeddings.npz

`scripts/word_embeddings.py` makes the embeddings. Needs torch (in the `age` extra); takes ten minutes on one core.
The same sentences and embeddings give the same network on the same kind of processor.
"""

import random
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from train_command_model import SENTENCES, WEIGHTS, Example, read, sampled

from attune.dialogue.grammar.command_model import COMMANDS
from attune.dialogue.grammar.command_network import SEPARATOR, UNKNOWN, WIDTHS, CommandNetwork, encode
from attune.dialogue.grammar.network_words import words_about, words_of

DIMENSIONS, FILTERS, BRANCHES = 96, 128, 4
"""Each branch has filters and a head of its own and learns by itself from the same reduced embeddings."""
EPOCHS, BATCH, RATE, DECAY = 8, 32, 2e-3, 0.02
WORDS_DROPPED, DIMENSIONS_DROPPED, FILTERS_DROPPED = 0.05, 0.2, 0.4
SMOOTHING = 0.05
STEP = 0.03
"""The embeddings are stored in steps of this size."""

Coded = tuple[list[int], int]


class Embeddings:
    """The embeddings of the pieces of words, of mean 0 and deviation 1.

    Args:
        path: A file of `scripts/word_embeddings.py`.
    """

    def __init__(self, path: Path) -> None:
        data = np.load(path)
        self.known = {str(piece): number for number, piece in enumerate(data["pieces"])}
        vectors = data["vectors"].astype(np.float32)
        self.vectors = torch.from_numpy((vectors - vectors.mean(axis=0)) / vectors.std())


class _Network(nn.Module):
    def __init__(self, embeddings: Embeddings) -> None:
        super().__init__()
        self.separator = embeddings.known[SEPARATOR]
        self.embeddings = nn.Embedding.from_pretrained(embeddings.vectors, freeze=True)
        self.reduce = nn.Linear(embeddings.vectors.shape[1], DIMENSIONS)
        self.segments = nn.Embedding(2, DIMENSIONS)
        filters = BRANCHES * FILTERS
        self.filters = nn.ModuleList(nn.Conv1d(DIMENSIONS, filters, width, padding=width // 2) for width in WIDTHS)
        self.heads = nn.ModuleList(nn.Linear(len(WIDTHS) * FILTERS, len(COMMANDS)) for _ in range(BRANCHES))
        self.drop_dimensions = nn.Dropout(DIMENSIONS_DROPPED)
        self.drop_filters = nn.Dropout(FILTERS_DROPPED)

    def forward(self, numbers: Tensor, present: Tensor) -> Tensor:
        """Scores, shape (branches, sentences, commands)."""
        segment = ((numbers == self.separator).cumsum(1) > 0).long()
        values = torch.tanh(self.reduce(self.embeddings(numbers)) + self.segments(segment))
        values = (self.drop_dimensions(values) * present[..., None]).transpose(1, 2)
        absent = (present == 0)[:, None]
        strongest = [torch.relu(layer(values)).masked_fill(absent, 0).amax(2) for layer in self.filters]
        branches = torch.stack(strongest, 1).unflatten(2, (BRANCHES, FILTERS)).permute(2, 0, 1, 3).flatten(2)
        return torch.stack([head(self.drop_filters(one)) for head, one in zip(self.heads, branches, strict=True)])


def train(examples: Sequence[Example], embeddings: Embeddings, seed: int = 0) -> CommandNetwork:
    """The network that these sentences teach, as it is stored."""
    torch.manual_seed(seed)
    chance = random.Random(seed)
    coded = [
        (encode(words_of(one.sentence), words_about(one.context), embeddings.known), COMMANDS.index(one.command))
        for one in examples
    ]
    network = _Network(embeddings)
    optimizer = torch.optim.AdamW([p for p in network.parameters() if p.requires_grad], lr=RATE, weight_decay=DECAY)
    batches = -(-len(coded) // BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, total_steps=EPOCHS * batches)
    unknown = embeddings.known[UNKNOWN]
    network.train()
    for _ in range(EPOCHS):
        for numbers, present, commands in _batches(coded, chance):
            dropped = (torch.rand(numbers.shape) < WORDS_DROPPED) & (numbers != network.separator)
            scores = network(numbers.masked_fill(dropped, unknown), present)
            wanted = commands.repeat(BRANCHES)
            loss = nn.functional.cross_entropy(scores.flatten(0, 1), wanted, label_smoothing=SMOOTHING)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
    return _stored(network.eval(), embeddings)


def _batches(coded: Sequence[Coded], chance: random.Random) -> Iterator[tuple[Tensor, Tensor, Tensor]]:
    """Sentences of about the same length together, in a random order."""
    order = sorted(coded, key=lambda one: len(one[0]) + 10 * chance.random())
    starts = list(range(0, len(order), BATCH))
    chance.shuffle(starts)
    for start in starts:
        batch = order[start : start + BATCH]
        longest = max(len(numbers) for numbers, _ in batch)
        numbers = torch.tensor([one + [0] * (longest - len(one)) for one, _ in batch])
        present = torch.tensor([[1.0] * len(one) + [0.0] * (longest - len(one)) for one, _ in batch])
        yield numbers, present, torch.tensor([command for _, command in batch])


@torch.no_grad()
def _stored(network: _Network, embeddings: Embeddings) -> CommandNetwork:
    reduced = (network.reduce(embeddings.vectors) / STEP).round().clamp(-127, 127)
    filters = [(_array(layer.weight.permute(2, 1, 0).flatten(0, 1)), _array(layer.bias)) for layer in network.filters]
    weights = torch.stack([head.weight.unflatten(1, (len(WIDTHS), FILTERS)) for head in network.heads], 2)
    biases = torch.stack([head.bias for head in network.heads])
    head = _array(weights.flatten(1).T / BRANCHES), _array(biases.mean(0))
    segments = _array(network.segments.weight)
    return CommandNetwork(embeddings.known, reduced.numpy().astype(np.int8), STEP, segments, filters, head)


def _array(tensor: Tensor) -> NDArray[np.float32]:
    return tensor.contiguous().numpy().astype(np.float16).astype(np.float32)


def main() -> None:
    """Train on all sentences and write the weights."""
    torch.set_num_threads(1)
    examples = [*read(sorted(SENTENCES.glob("*.jsonl"))), *sampled()]
    target = WEIGHTS.with_name("command_network.npz")
    train(examples, Embeddings(Path(sys.argv[1]))).save(target)
    print(f"{len(examples)} sentences: {target.name}, {target.stat().st_size // 1024} kB")  # noqa: T201 - a script


if __name__ == "__main__":
    main()
