"""Agreement that goes on: "yes, and a spoon", "yes to the table, and a knife as well", "the blue one and a plate"."""

import re
from collections.abc import Callable
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.questions import Question
from attune.dialogue.interpreter import Interpretation

_ADDED = re.compile(
    r"\b(?:and|plus|with|also|as well as)\b"
    r"(?P<rest>(?: (?!T\d|P\d|not\b|no\b|on\b|in\b|is\b|are\b|was\b)[\w']+){0,4}? "
    r"(?P<things>T\d+(?:(?: ,)? (?:and|plus|,) T\d+)*)"
    r"(?! P\d| (?:is|are|was|has|instead|on|in)\b).*)$"
)
_AGREES = re.compile(
    r"(?:(?:yes|sure|okay|alright|all right|right|of course|please|please do|definitely|absolutely|certainly|indeed|"
    r"lovely|perfect|great|go on|go ahead|by all means|do|i would like that|i would love that|that would be \w+|oh|"
    r"well|then|thanks|thank you|very well|good|fine|exactly|why not|go for it|sounds good|,|\.) ?)+"
)
_DENIES = re.compile(r"\b(?:not|no|never|nor|but|instead|rather|without|what|why|how|where|who)\b")


def agreed_with_addition(
    text: str, sentence: Sentence, question: Question, answer_to: Callable[[str], Interpretation | None]
) -> Interpretation | None:
    """What was asked about and more, or None.

    Args:
        text: The skeleton of what was said.
        sentence: The things and places in it.
        question: What was asked.
        answer_to: Reads the first part by itself.
    """
    added = _ADDED.search(text)
    if added is None or not question.options or _DENIES.search(text):
        return None
    numbers = [int(number) for number in re.findall(r"T(\d+)", added["things"])]
    new = [sentence.things[number] for number in numbers]
    if not all(thing.head == "noun" and not thing.unknown for thing in new):
        return None
    if set(re.findall(r"T\d+", added["rest"])) != set(re.findall(r"T\d+", added["things"])):
        return None
    first = text[: added.start()].strip(" ,.")
    first = "yes" if first and _AGREES.fullmatch(first) else first
    meaning = answer_to(first) if first else None
    if meaning is None or meaning.intent != "bring_me" or not meaning.answers:
        return None
    more = [thing for thing in new if not _is_offered(thing.spec, meaning.add)]
    specs = tuple(thing.spec for thing in more for _ in range(thing.count))
    definite = tuple(thing.definite for thing in more for _ in range(thing.count))
    return replace(
        meaning, add=meaning.add + specs, definite=meaning.definite + definite, reason="agrees, and wants more"
    )


def _is_offered(spec: ObjectSpec, offered: tuple[ObjectSpec, ...]) -> bool:
    return any(replace(spec, location=has.location) == has for has in offered)
