"""The words that order the robot to stop, in a text as a recogniser writes it."""

import re

STOP_WORD = re.compile(r"(?<!\w)(stop|halt|freeze|wait|pause|hold (?:on|it)|don't move|stand still)(?!\w)")
_NEGATED = re.compile(
    r"(?<!\w)(?:(?:don't|do not|never|without|can't|no need to)(?: (?:have|need) to| \w+)?"
    r"|not (?:(?:have|need) to|\w+)"
    r"|(?:^|(?:do|does|did|should|would|could|will|can|must|may|might|need|better|please|to|and|or|just|rather) )not) $"
)
"""Elsewhere a "not" right before "stop" is no English: "blue not stop" is how "robot stop" may be understood."""


def stops_in(text: str) -> list[str]:
    """The stop words in it that are not negated, in order."""
    return [match.group() for match in STOP_WORD.finditer(text) if not _NEGATED.search(text[: match.start()])]


def is_negated_after(text: str) -> bool:
    """Whether a stop word that follows is negated: "please do not"."""
    return bool(_NEGATED.search(f"{text} "))


def reads_as_stop(text: str) -> bool:
    """Whether there is a stop word in it that is not negated."""
    return bool(stops_in(text))


def is_negated(text: str) -> bool:
    """Whether each stop word in it is negated, and there is one: "please don't stop"."""
    return bool(STOP_WORD.search(text)) and not stops_in(text)
