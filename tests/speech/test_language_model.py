"""The trigram model is a probability distribution, and the decoder reads it as such."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from attune.speech.language_model import END, START, LanguageModel
from attune.speech.pronunciation import UnpronounceableWordError, dictionary_text, pronounce

WORDS = st.sampled_from(["bring", "me", "a", "cup", "stop"])


@given(st.lists(st.lists(WORDS, min_size=1, max_size=6), min_size=1, max_size=10), st.lists(WORDS, max_size=2))
def test_the_probabilities_after_any_history_sum_to_one(sentences: list[list[str]], history: list[str]) -> None:
    model = LanguageModel([" ".join(words) for words in sentences])
    total = sum(model.probability(word, history) for word in (*model.words, END))
    assert total == pytest.approx(1.0)


def test_what_was_seen_is_likelier_than_what_was_not_and_nothing_is_impossible() -> None:
    model = LanguageModel(["bring me a cup", "bring me a spoon", "stop"])
    assert model.probability("cup", ("me", "a")) > model.probability("stop", ("me", "a")) > 0
    assert model.probability("bring", (START,)) > model.probability("cup", (START,))


def test_back_off_in_the_file_gives_the_model_s_probabilities() -> None:
    model = LanguageModel(["bring me a cup", "bring me a spoon", "stop", "stop it"])
    logs: dict[tuple[str, ...], float] = {}
    weights: dict[tuple[str, ...], float] = {}
    for line in model.arpa().splitlines():
        fields = line.split("\t")
        if len(fields) > 1:
            ngram = tuple(fields[1].split())
            logs[ngram] = float(fields[0])
            weights[ngram] = float(fields[2]) if len(fields) > 2 else 0.0

    def from_file(ngram: tuple[str, ...]) -> float:
        return logs[ngram] if ngram in logs else weights.get(ngram[:-1], 0.0) + from_file(ngram[1:])

    for history in [("me", "a"), ("it", "cup"), ("bring", "me"), (START, "stop"), ("stop", "it")]:
        for word in (*model.words, END):
            assert from_file((*history, word)) == pytest.approx(math.log10(model.probability(word, history)), abs=1e-3)


def test_a_model_without_words_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one word"):
        LanguageModel(["", "  "])


def test_unknown_words_get_a_pronunciation_by_rule_and_none_is_dropped() -> None:
    found = pronounce(["cup", "cornflakes", "weetabix", "the"])
    assert found["cup"] == ("K AH P",)
    assert found["cornflakes"] == ("K AO R N F L EY K S",)
    assert found["weetabix"][0].startswith("W IY T")
    assert len(found["the"]) > 1
    assert "the(2) " in dictionary_text(found)
    with pytest.raises(UnpronounceableWordError, match=r"'42', '\?'"):
        pronounce(["cup", "42", "?"])
