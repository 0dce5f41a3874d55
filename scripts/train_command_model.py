"""Makes the weights of the command model from the written sentences in `scripts/understanding` and some sampled ones.

    python scripts/train_command_model.py

Needs scipy (in the `dev` extra). Prints how often the model alone is right on sentences it has not seen (four folds).
"""

import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.sparse import csr_matrix

from attune.cli.understanding import LineContext
from attune.core.messages import ObjectSpec
from attune.core.scene import load_scene
from attune.dialogue.context import Context, TaskContext
from attune.dialogue.corpus import Sampler, scene_lexicon
from attune.dialogue.grammar.command_model import COMMANDS, features
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.interpreter import CommandIntent

SENTENCES = Path(__file__).parent / "understanding"
WEIGHTS = Path(__file__).parents[1] / "src/attune/data/command_model.npz"
FOLDS = 4
SAMPLED = 40
SEEN_AT_LEAST = 2
PENALTY = 1e-3
STEPS = 80

Matrix = NDArray[np.float64]
Scorer = Callable[[Sequence[frozenset[str]]], Matrix]


def read() -> tuple[list[frozenset[str]], NDArray[np.int64]]:
    """The features of each sentence, and the number of its command."""
    interpreter = GrammarInterpreter(scene_lexicon(load_scene()))
    seen, commands = [], []
    for path in sorted(SENTENCES.glob("*.jsonl")):
        for text in path.read_text("utf-8").splitlines():
            line: dict[str, Any] = json.loads(text)
            context = LineContext.model_validate(line["context"]).context()
            sentence, lexicon = interpreter.sentence(line["utterance"], context)
            seen.append(frozenset(features(sentence, context, lexicon)))
            commands.append(COMMANDS.index(line["expect"]["command"]))
    for text, context, command in _sampled():
        sentence, lexicon = interpreter.sentence(text, context)
        seen.append(frozenset(features(sentence, context, lexicon)))
        commands.append(COMMANDS.index(command))
    return seen, np.array(commands)


def _sampled() -> Iterator[tuple[str, Context, CommandIntent]]:
    """Plain sentences of the recogniser's grammar, of which people write few."""
    sampler = Sampler(scene_lexicon(load_scene()), seed=1)
    busy = Context(task=TaskContext(objects=(ObjectSpec(type="cup", color="red"),)))
    for intent in ("setting_breakfast", "stop", "dont_stop", "carry_on", "put_back", "style", "status"):
        command: CommandIntent = intent if intent in {"setting_breakfast", "stop"} else "other"  # type: ignore[assignment]
        for number in range(SAMPLED):
            yield sampler.sentence(intent), busy if number % 2 else Context(), command


def fit(seen: Sequence[frozenset[str]], commands: NDArray[np.int64]) -> tuple[list[str], Matrix, Matrix]:
    """Names, weights and bias of a multinomial logistic regression with an L2 penalty."""
    counts = Counter(feature for one in seen for feature in one)
    names = sorted(feature for feature, count in counts.items() if count >= SEEN_AT_LEAST)
    table = _table(seen, names)
    transposed = table.T.tocsr()
    right = np.eye(len(COMMANDS))[commands]

    def loss(flat: Matrix) -> tuple[float, Matrix]:
        weights, bias = flat[: -len(COMMANDS)].reshape(-1, len(COMMANDS)), flat[-len(COMMANDS) :]
        likely = _softmax(table @ weights + bias)
        value = -np.log(likely[np.arange(len(seen)), commands] + 1e-12).mean() + PENALTY * (weights**2).sum()
        error = (likely - right) / len(seen)
        slope = np.concatenate([(transposed @ error + 2 * PENALTY * weights).ravel(), error.sum(axis=0)])
        return float(value), slope

    flat = minimize(
        loss, np.zeros((len(names) + 1) * len(COMMANDS)), jac=True, method="L-BFGS-B", options={"maxiter": STEPS}
    ).x
    return names, flat[: -len(COMMANDS)].reshape(-1, len(COMMANDS)), flat[-len(COMMANDS) :]


def _table(seen: Sequence[frozenset[str]], names: Sequence[str]) -> csr_matrix:
    column = {name: number for number, name in enumerate(names)}
    cells = [(row, column[feature]) for row, one in enumerate(seen) for feature in one if feature in column]
    rows, columns = zip(*cells, strict=True)
    return csr_matrix((np.ones(len(cells)), (rows, columns)), shape=(len(seen), len(names)))


def _softmax(scores: Matrix) -> Matrix:
    likely = np.exp(scores - scores.max(axis=1, keepdims=True))
    return np.asarray(likely / likely.sum(axis=1, keepdims=True))


def accuracy_on_unseen(seen: Sequence[frozenset[str]], commands: NDArray[np.int64]) -> float:
    """How often the model is right on the fold that it was not trained with."""
    fold = np.random.default_rng(0).integers(0, FOLDS, len(seen))
    right = 0
    for number in range(FOLDS):
        inside, outside = np.flatnonzero(fold != number), np.flatnonzero(fold == number)
        names, weights, bias = fit([seen[i] for i in inside], commands[inside])
        scores = _table([seen[i] for i in outside], names) @ weights + bias
        right += int((scores.argmax(axis=1) == commands[outside]).sum())
    return right / len(seen)


def main() -> None:
    """Train on all sentences and write the weights."""
    seen, commands = read()
    if "--check" in sys.argv:
        print(f"{accuracy_on_unseen(seen, commands):.1%} of {len(seen)} right when not seen")  # noqa: T201 - a script
    names, weights, bias = fit(seen, commands)
    np.savez_compressed(
        WEIGHTS, features=np.frombuffer("\n".join(names).encode(), np.uint8),
        weights=weights.astype(np.float16), bias=bias.astype(np.float16),
    )  # fmt: skip
    print(f"{len(seen)} sentences, {len(names)} features: {WEIGHTS.name}, {WEIGHTS.stat().st_size // 1024} kB")  # noqa: T201


if __name__ == "__main__":
    main()
