"""Makes the weights of the command model from the written sentences in `scripts/understanding` and some sampled ones.

    python scripts/train_command_model.py [--check]

Needs scipy (in the `dev` extra). With `--check` it prints how often the model alone is right on sentences of authors
whom it has not seen.
"""

import json
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.sparse import csr_matrix, diags

from attune.cli.understanding import LineContext
from attune.core.messages import ObjectSpec
from attune.core.scene import load_scene
from attune.dialogue.context import Context, TaskContext
from attune.dialogue.corpus import Sampler, scene_lexicon
from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.command_model import COMMANDS, CommandModel, features, plain_words, share
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.interpreter import CommandIntent
from attune.dialogue.lexicon import Lexicon

SENTENCES = Path(__file__).parent / "understanding"
WEIGHTS = Path(__file__).parents[1] / "src/attune/data/command_model.npz"
SAMPLED = 40
SEEN_AT_LEAST = 3
FAMILIAR_FROM = 3
PENALTY = 1e-3
STEPS = 80

Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Example:
    """A sentence that somebody wrote, with what it asks for.

    Attributes:
        group: The authors; they share a manner, so a model is judged on groups that it has not seen.
    """

    group: str
    sentence: Sentence
    context: Context
    lexicon: Lexicon
    command: CommandIntent


def read(paths: Iterable[Path]) -> list[Example]:
    """The written sentences of these files."""
    interpreter = GrammarInterpreter(scene_lexicon(load_scene()))
    examples = []
    for path in paths:
        for text in path.read_text("utf-8").splitlines():
            line: dict[str, Any] = json.loads(text)
            context = LineContext.model_validate(line["context"]).context()
            sentence, lexicon = interpreter.sentence(line["utterance"], context)
            examples.append(Example(path.stem, sentence, context, lexicon, line["expect"]["command"]))
    return examples


def sampled() -> list[Example]:
    """Plain sentences of the recogniser's grammar, of which people write few."""
    interpreter = GrammarInterpreter(scene_lexicon(load_scene()))
    examples = []
    for text, context, command in _sampled():
        sentence, lexicon = interpreter.sentence(text, context)
        examples.append(Example("sampled", sentence, context, lexicon, command))
    return examples


def _sampled() -> Iterator[tuple[str, Context, CommandIntent]]:
    sampler = Sampler(scene_lexicon(load_scene()), seed=1)
    busy = Context(task=TaskContext(objects=(ObjectSpec(type="cup", color="red"),)))
    for intent in ("setting_breakfast", "stop", "dont_stop", "carry_on", "put_back", "style", "status"):
        command: CommandIntent = intent if intent in {"setting_breakfast", "stop"} else "other"  # type: ignore[assignment]
        for number in range(SAMPLED):
            yield sampler.sentence(intent), busy if number % 2 else Context(), command


def train(examples: Sequence[Example]) -> CommandModel:
    """The model that these sentences teach.

    The words that count as familiar to a sentence are those of commands by other authors, as for a stranger's sentence.
    """
    counts = {group: _words_of_commands(examples, group) for group in {example.group for example in examples}}
    total: Counter[str] = sum(counts.values(), Counter())
    known = {group: _often(total - own) for group, own in counts.items()}
    seen = [frozenset(features(e.sentence, e.context, e.lexicon, known[e.group])) for e in examples]
    names, weights, bias = fit(seen, np.array([COMMANDS.index(example.command) for example in examples]))
    return CommandModel(names, weights.astype(np.float32), bias.astype(np.float32), _often(total))


def _words_of_commands(examples: Iterable[Example], group: str) -> Counter[str]:
    return Counter(
        word
        for example in examples
        if example.group == group and example.command != "other"
        for word in set(plain_words(example.sentence))
    )


def _often(counts: Counter[str]) -> frozenset[str]:
    return frozenset(word for word, count in counts.items() if count >= FAMILIAR_FROM)


def fit(seen: Sequence[frozenset[str]], commands: NDArray[np.int64]) -> tuple[list[str], Matrix, Matrix]:
    """Names, weights and bias of a multinomial logistic regression with an L2 penalty, milder for rare features."""
    counts = Counter(feature for one in seen for feature in one)
    names = sorted(feature for feature, count in counts.items() if count >= SEEN_AT_LEAST)
    prior = np.sqrt(np.log(len(seen) / np.array([counts[name] for name in names])))
    table = _table(seen, names) @ diags(prior)
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
    return names, flat[: -len(COMMANDS)].reshape(-1, len(COMMANDS)) * prior[:, None], flat[-len(COMMANDS) :]


def _table(seen: Sequence[frozenset[str]], names: Sequence[str]) -> csr_matrix:
    column = {name: number for number, name in enumerate(names)}
    known = [[column[feature] for feature in one if feature in column] for one in seen]
    cells = [(share(len(one)), row, feature) for row, one in enumerate(known) for feature in one]
    values, rows, columns = zip(*cells, strict=True)
    return csr_matrix((values, (rows, columns)), shape=(len(seen), len(names)))


def _softmax(scores: Matrix) -> Matrix:
    likely = np.exp(scores - scores.max(axis=1, keepdims=True))
    return np.asarray(likely / likely.sum(axis=1, keepdims=True))


def accuracy_on_unseen(examples: Sequence[Example]) -> float:
    """How often the model alone is right on sentences of authors whom it was not trained with."""
    right = 0
    for group in sorted({example.group for example in examples} - {"sampled"}):
        model = train([example for example in examples if example.group != group])
        for example in examples:
            if example.group == group:
                judged = model.judge(example.sentence, example.context, example.lexicon)
                right += max(judged, key=judged.__getitem__) == example.command
    return right / sum(example.group != "sampled" for example in examples)


def main() -> None:
    """Train on all sentences and write the weights."""
    examples = [*read(sorted(SENTENCES.glob("*.jsonl"))), *sampled()]
    if "--check" in sys.argv:
        print(f"{accuracy_on_unseen(examples):.1%} right of authors whom the model has not seen")  # noqa: T201 - a script
    train(examples).save(WEIGHTS)
    print(f"{len(examples)} sentences: {WEIGHTS.name}, {WEIGHTS.stat().st_size // 1024} kB")  # noqa: T201


if __name__ == "__main__":
    main()
