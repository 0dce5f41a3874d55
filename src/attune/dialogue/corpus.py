"""Sentences of the kitchen, sampled from a grammar of phrasings: what the speech recogniser learns from."""

import random
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import resources

from pydantic import BaseModel, ConfigDict

from attune.core.messages import ObjectSpec
from attune.core.scene import Scene
from attune.dialogue.lexicon import Group, Lexicon, load_lexicon

_SYMBOL = re.compile(r"<(\w+)>")
_CHOICE = re.compile(r"\(([^()]*)\)")
_POSSESSIVES = frozenset({"my", "your", "his", "her"})
_AGES = 0.01
"""Share of stated ages: seldom said, but each number has to be known."""
_CANONICAL_SHARE = 0.85
"""How often a thing is called by its plainest name; its synonyms share the rest."""


class _Phrasings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)
    intents: dict[str, int]
    rules: dict[str, tuple[str, ...]]


@cache
def _phrasings() -> _Phrasings:
    return _Phrasings.model_validate(
        tomllib.loads((resources.files("attune.data") / "phrasings.toml").read_text("utf-8"))
    )


def domain_sentences(scene: Scene, count: int = 8000, seed: int = 0) -> list[str]:
    """Sample sentences that people may say to the robot.

    Each word of the lexicon and of the scene occurs at least once, if `count` allows.

    Args:
        scene: Brings types, colours and places of its own.
        count: How many.
        seed: The same seed gives the same sentences.

    Returns:
        Lower case, without punctuation; may contain duplicates, as speech does.
    """
    sampler = Sampler(scene_lexicon(scene), seed)
    coverage = sampler.coverage()[:count]
    sampled = [sampler.sentence() for _ in range(count - len(coverage))]
    ages = [sampler.sentence("age") for _ in range(round(_AGES * len(sampled)))]
    return coverage + sampled[len(ages) :] + ages


def scene_lexicon(scene: Scene, base: Lexicon | None = None) -> Lexicon:
    """The lexicon with the words that a scene brings."""
    words = scene.vocabulary
    specs = [ObjectSpec(type=value) for value in words.types] + [ObjectSpec(color=value) for value in words.colors]
    return (base or load_lexicon()).extended(specs, words.places)


class Sampler:
    """Draws sentences from the grammar of phrasings.

    Args:
        lexicon: The words for the groups.
        seed: Of the random choices.
    """

    def __init__(self, lexicon: Lexicon, seed: int) -> None:
        self._random = random.Random(seed)
        self._lexicon = lexicon
        grammar = _phrasings()
        self._rules: Mapping[str, Sequence[str]] = grammar.rules
        self._intents = list(grammar.intents)
        self._weights = list(grammar.intents.values())
        self._groups: Mapping[str, Callable[[], str]] = {
            "type": lambda: self._say("type"),
            "types": lambda: self._say("type", plural=True),
            "color": lambda: self._say("color"),
            "size": lambda: self._say("size"),
            "bigger": lambda: self._say("comparative"),
            "place": lambda: self._say("place"),
        }

    def sentence(self, intent: str = "") -> str:
        """One sentence, of a given intent of the grammar or of any."""
        rule = intent or self._random.choices(self._intents, self._weights)[0]
        return _with_right_article(" ".join(self._expand(self._random.choice(self._rules[rule])).split()))

    def coverage(self) -> list[str]:
        """One short sentence for each phrase of the lexicon."""
        frames = {"type": "bring me the {}", "color": "the {} one", "size": "the {} one", "comparative": "a {} one",
                  "place": "from the {}", "unknown": "bring me the {}"}  # fmt: skip
        return [
            frames[entry.group].format(" ".join(words))
            for words, entry in self._lexicon.phrases.items()
            if words[0] not in _POSSESSIVES
        ]

    def _expand(self, template: str) -> str:
        template = _CHOICE.sub(lambda match: self._random.choice(match[1].split("|")), template)
        return _SYMBOL.sub(lambda match: self._symbol(match[1]), template)

    def _symbol(self, name: str) -> str:
        if name in self._groups:
            return self._groups[name]()
        return self._expand(self._random.choice(self._rules[name]))

    def _say(self, group: Group, *, plural: bool = False) -> str:
        value = self._random.choice(self._lexicon.values(group))
        sayings = self._lexicon.sayings(group, value, plural=plural) or self._lexicon.sayings(group, value)
        return sayings[0] if self._random.random() < _CANONICAL_SHARE else self._random.choice(sayings)


def _with_right_article(sentence: str) -> str:
    return re.sub(r"\ba (?=[aeiou])", "an ", sentence)
