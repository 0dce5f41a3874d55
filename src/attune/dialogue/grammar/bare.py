"""Clauses without a verb that asks: "a spoon, please", "on the table", "the cup rather than the mug"."""

import re
from collections.abc import Sequence
from typing import Literal

from attune.dialogue.context import Context
from attune.dialogue.grammar import cues, frames
from attune.dialogue.grammar.items import Thing
from attune.dialogue.lexicon import Lexicon

_EXPLAINED = re.compile(
    r"\b(?:for (?:my|the|our|a) (?!T\d)\w+|so (?:that )?i can .*|to (?:go|eat|drink|have) .*|(?:because|since) .*)|"
    r"(?<=\bplease) (?:i|it|we|my|there|that) .*"
)
_IT_IS = re.compile(r"(?:it|that|this|there|here|these|those|they) (?:is|was|are|were|will)\b")


def names_only(text: str, lexicon: Lexicon) -> Literal["", "place", "things"]:  # noqa: PLR0911 - one rule per return
    """What a clause names if it has only things, places and words that say nothing more; "" if it says more.

    Args:
        text: The clause's skeleton.
        lexicon: The words of this situation.
    """
    if not re.search(r"\b[TP]\d+\b", text):
        return ""
    if not re.search(r"\bT\d+\b", text) and cues.TRAVEL.search(text):
        return ""
    if frames.PRAISE.search(text) or frames.NEEDED.search(text):
        return "things"
    question = frames.QUESTION.match(text) is not None
    if cues.ONLY_CHANGE.search(text) and not question:
        return "place"
    text = cues.NOT_ASKED_FOR.sub(" ", text)
    text = cues.FOR_SOMEBODY.sub(lambda found: " " if found[1] in lexicon.others else found[0], text)
    if cues.ABOUT_A_THING.match(text) or (question and not re.match(r"(?:what|how) about", text)):
        return ""
    if _IT_IS.match(text) and not re.search(r"\b(?:wrong|not)\b", text):
        return ""
    words = re.sub(r"\b[TP]\d+\b", " ", " ".join(_EXPLAINED.split(text))).split()
    more = any(word not in cues.FILLER for word in words)
    return "" if more and not cues.PLEASE.search(text) else "things"


def is_contrast(text: str, things: Sequence[Thing], context: Context) -> bool:
    """Whether one thing is named instead of another, or a different one asked for, in whatever words."""
    if frames.PAST.search(text) or cues.SOMEBODY.match(text):
        return False
    asked_for = cues.ASKS_FOR_ANOTHER.search(text)
    if asked_for and context.busy:
        thing = things[int(asked_for[1])]
        return thing.compared or thing.different or thing.other
    return cues.CONTRAST.search(text) is not None and not frames.QUESTION.match(text)
