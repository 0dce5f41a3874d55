"""Repairs what the recogniser misheard: "bring me a bull" is a bowl, in a kitchen."""

import re
from dataclasses import replace
from functools import lru_cache

from attune.core.messages import Utterance
from attune.dialogue.context import Context
from attune.dialogue.grammar.command_model import load_command_model
from attune.dialogue.grammar.tokens import tokenize
from attune.dialogue.interpreter import Intent, Interpretation, Interpreter
from attune.dialogue.lexicon import Lexicon
from attune.dialogue.words import words

_DOUBTFUL: frozenset[Intent] = frozenset({"unclear", "unknown_object", "fragment", "talk", "unknown_action"})
_COMMANDS = frozenset(
    {"bring_me", "replace_object", "change_location", "setting_breakfast", "cancel_object", "put_back"}
)
_SURE, _POSSIBLE = 0.26, 0.42
"""Relative distance of sounds under which a repair is made, or asked about."""
_CLEARLY_BETTER = 0.08
_REQUESTS = words("bring get fetch want need hand pass give take find like have put instead grab could can please")

_RULES: tuple[tuple[str, str], ...] = (
    (r"ph", "f"), (r"gh(?=t)", ""), (r"ough", "o"), (r"wh", "w"), (r"wr", "r"), (r"kn", "n"), (r"ck", "k"),
    (r"sch", "x"),
    (r"sh|ch|tch", "x"), (r"th", "t"), (r"dge", "j"), (r"c(?=[eiy])", "s"), (r"c", "k"), (r"q", "k"),
    (r"g(?=[eiy])", "j"),
    (r"x", "ks"), (r"z", "s"), (r"oa|ow|ou|oo", "o"), (r"ea|ee|ie|y", "i"), (r"ai|ay|ei", "e"),
    (r"au|aw", "o"), (r"e(?=\b)", ""), (r"(.)\1", r"\1"),
)  # fmt: skip
_LIKE = ("pb", "td", "kg", "fv", "sx", "xj", "mn", "lr", "wv")
_VOWELS = frozenset("aeiou")


@lru_cache(maxsize=4096)
def sounds(word: str) -> str:
    """A rough phonetic spelling: `bull` and `bowl` come out nearly the same."""
    for pattern, replacement in _RULES:
        word = re.sub(pattern, replacement, word)
    return word


def distance(first: str, second: str) -> float:
    """How unlike two words sound: 0 for the same, about 1 for nothing in common."""
    a, b = sounds(first), sounds(second)
    row = [float(i) for i in range(len(b) + 1)]
    for i, x in enumerate(a, 1):
        diagonal, row[0] = row[0], float(i)
        for j, y in enumerate(b, 1):
            gap = 0.6 if y in _VOWELS else 1.0
            diagonal, row[j] = (
                row[j],
                min(row[j] + (0.6 if x in _VOWELS else 1.0), row[j - 1] + gap, diagonal + _unlike(x, y)),
            )
    return row[-1] / max(len(a), len(b), 1)


def _unlike(x: str, y: str) -> float:
    if x == y:
        return 0.0
    if x in _VOWELS and y in _VOWELS:
        return 0.35
    return 0.5 if any(x in pair and y in pair for pair in _LIKE) else 1.0


class Repairer:
    """Looks for a plausible reading of what made no sense.

    Args:
        lexicon: The words that make sense in this kitchen.
    """

    def __init__(self, lexicon: Lexicon) -> None:
        self._names = tuple(
            dict.fromkeys(
                words[0]
                for words, entry in lexicon.phrases.items()
                if len(words) == 1 and entry.group in {"type", "color", "place"}
            )
        )
        self._canonical = frozenset(lexicon.values("type")) | frozenset(lexicon.values("color"))
        self._model = load_command_model()
        self._people = lexicon.others
        self._known = frozenset(word for words in lexicon.phrases for word in words)

    async def repaired(
        self, meaning: Interpretation, utterance: Utterance, context: Context, interpreter: Interpreter
    ) -> Interpretation:
        """The meaning, or a better one of another reading.

        Another reading is taken only when it is a command, sounds nearly the same, and no other reading competes.
        When one is plausible but not sure, the result is `unclear` with the `suggestion` to ask about.

        Args:
            meaning: What the text as heard means.
            utterance: What was heard, with the recogniser's own alternatives.
            context: The situation.
            interpreter: Who interprets the other readings.
        """
        if meaning.intent not in _DOUBTFUL or meaning.doubted or (utterance.typed and meaning.intent == "fragment"):
            return meaning
        tokens = tokenize(utterance.text)
        words = [token.text for token in tokens]
        if meaning.intent == "talk" and not (_REQUESTS & set(words)):
            return meaning
        for alternative in utterance.alternatives[:4]:
            other = await interpreter.interpret(alternative, context)
            if other.intent in _COMMANDS and other.confidence >= 0.75:
                return replace(
                    other, confidence=other.confidence * 0.9, reason=f"another reading of the sound: {other.reason}"
                )
        names = self._people | {token.text for token in tokens if token.capital}
        return await self._by_sound(words, names, meaning, context, interpreter)

    async def _by_sound(
        self,
        words: list[str],
        names: frozenset[str],
        meaning: Interpretation,
        context: Context,
        interpreter: Interpreter,
    ) -> Interpretation:
        for index, word in enumerate(words):
            if word in self._known or word in _COMMON or word in names or len(word) < 3 or self._model.knows(word):
                continue
            near = sorted((distance(word, name), name) for name in self._names)
            best, name = near[0]
            rivals = [other for other in near[1:4] if other[0] - best < _CLEARLY_BETTER and other[1][:4] != name[:4]]
            if best > _POSSIBLE or (best > _SURE and rivals):
                continue
            text = " ".join([*words[:index], name, *words[index + 1 :]])
            other = await interpreter.interpret(text, context)
            if other.intent not in _COMMANDS:
                continue
            if best <= _SURE and not rivals:
                return replace(other, confidence=other.confidence * 0.85, reason=f"sounds like {name}: {other.reason}")
            return replace(meaning, intent="unclear", suggestion=f"the {name}", reason=f"may have been {name}")
        return meaning


def _set(*lines: str) -> frozenset[str]:
    return frozenset(word for line in lines for word in line.split())


_COMMON: frozenset[str] = _set(
    "the and you for that this with have from they would could there their what about which when make "
    "like time just know take people into year your good some them than then now look only come over "
    "think also back after use two how our work first well way even new want because any these give day "
    "most please bring fetch get need put place hand pass grab can may might shall will are was were been "
    "has had did does not but all one out her his she him its who why where let too very much more less "
    "off down here again please thanks thank okay yes sorry wait stop hold carry going keep tell talk "
    "speak robot hello mum dad milk water coffee tea sugar salt pepper butter cheese newspaper phone book "
    "remote chair sofa window door lamp light bed towel napkin pan pot kettle toaster oven sink bottle "
    "box bag apple banana orange egg eggs toast meat fish rice pasta soup salad cake cookie biscuit "
    "chocolate honey jam keys glasses shoes jacket coat hat shirt pen paper radio music television news "
    "car house room garden dog cat baby child friend brother sister doctor medicine pills tissue "
    "yesterday today tomorrow morning evening night breakfast lunch dinner pizza sandwich wine beer "
    "teapot tray basket bucket something anything nothing everything someone little pull push close open "
    "turn switch clean wash cook throw drop blanket pillow cushion laptop tablet charger walker stick "
    "cane wheelchair slippers socks flowers vase candle plant letter mail saucer ladle spatula whisk "
    "grater jug pitcher tongs scissors opener corkscrew sponge soap candy crisps nuts vinegar oil",
)
"""Words that are themselves: nobody who says "book" meant a bowl."""
