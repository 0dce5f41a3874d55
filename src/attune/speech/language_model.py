"""A trigram language model from example sentences, in the ARPA format that recognisers read.

Witten-Bell smoothing, interpolated [1, 2]: with c(h, w) the count of word w after history h, c(h) the count of h, T(h)
the number of different words seen after h, and h' the history without its first word,

    P(w | h) = (c(h, w) + T(h) P(w | h')) / (c(h) + T(h))

and the uniform distribution below the unigrams. A word that was never seen after h gets T(h) / (c(h) + T(h)) of
P(w | h'), which is exactly the back-off weight that the format wants: the probabilities sum to one as they are.

[1] I. H. Witten, T. C. Bell: The zero-frequency problem. IEEE Transactions on Information Theory 37(4), 1991.
[2] S. F. Chen, J. Goodman: An empirical study of smoothing techniques for language modeling. TR-10-98, Harvard, 1998.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence

START, END = "<s>", "</s>"
_ORDER = 3
_NEVER = -99.0

Ngram = tuple[str, ...]


class LanguageModel:
    """A smoothed trigram model.

    Args:
        sentences: Words, separated by spaces; each sentence counts as often as it is given.

    Raises:
        ValueError: There is no word in them.
    """

    def __init__(self, sentences: Iterable[str]) -> None:
        counts: list[Counter[Ngram]] = [Counter() for _ in range(_ORDER)]
        for sentence in sentences:
            words = (START, *sentence.split(), END)
            if len(words) > 2:
                for order in range(_ORDER):
                    counts[order].update(words[i : i + order + 1] for i in range(len(words) - order))
        # The start is given, never predicted.
        del counts[0][(START,)]
        if not counts[0]:
            raise ValueError("a language model needs at least one word")
        self.words = tuple(sorted(ngram[0] for ngram in counts[0] if ngram[0] != END))
        self._counts = counts
        self._after: defaultdict[Ngram, int] = defaultdict(int)
        self._different: defaultdict[Ngram, int] = defaultdict(int)
        for order in range(_ORDER):
            for ngram, count in counts[order].items():
                self._after[ngram[:-1]] += count
                self._different[ngram[:-1]] += 1

    def probability(self, word: str, history: Sequence[str] = ()) -> float:
        """P(word | history); of the history, the last two words count."""
        history = tuple(history)[-(_ORDER - 1) :]
        below = self.probability(word, history[1:]) if history else 1 / (len(self.words) + 1)
        after, different = self._after.get(history, 0), self._different.get(history, 0)
        if not after:
            return below
        return (self._counts[len(history)][(*history, word)] + different * below) / (after + different)

    def arpa(self) -> str:
        """The model in ARPA format."""
        lines = ["\\data\\"]
        tables = [self._table(order) for order in range(_ORDER)]
        lines += [f"ngram {order + 1}={len(table)}" for order, table in enumerate(tables)]
        for order, table in enumerate(tables):
            lines += ["", f"\\{order + 1}-grams:", *table]
        return "\n".join([*lines, "", "\\end\\", ""])

    def _table(self, order: int) -> list[str]:
        ngrams = sorted(self._counts[order])
        if order == 0:
            ngrams = [(START,), *ngrams]
        lines = []
        for ngram in ngrams:
            log = _NEVER if ngram == (START,) else math.log10(self.probability(ngram[-1], ngram[:-1]))
            line = f"{log:.4f}\t{' '.join(ngram)}"
            if order < _ORDER - 1:
                after, different = self._after.get(ngram, 0), self._different.get(ngram, 0)
                line += f"\t{math.log10(different / (after + different)) if after else 0.0:.4f}"
            lines.append(line)
        return lines
