"""Things that are only mentioned beside what is asked for: "thanks for the milk, now some cereal"."""

import re

from attune.dialogue.context import Context
from attune.dialogue.grammar.clauses import Sentence
from attune.dialogue.grammar.items import Thing
from attune.dialogue.grammar.references import fits

_THANKED = re.compile(r"(?:\b(?:thanks|thank you)(?: \w+){0,3}? |^)for (T\d+)(?= \w+ ,| ,| \.|$)")
_THERE = re.compile(
    r"\b(T\d+)(?: 's| is| are)? (?:here|good|sorted|done|delivered|arrived)(?= *(?:[.,]|now\b))|"
    r"\b(?:i|we) have (?:got )?(T\d+) (?:now |here |already )?but\b|"
    r"\b(?:done|finished|through) with (T\d+)|\b(?:as well as|to go with|with|besides) (T\d+)"
)
_BUSY_WITH = re.compile(
    r"(?<=,) (?:the|my|his|her|our) (?!T\d|P\d)\w+(?: \w+)? (?:is|are|'s) (?:already |still )?(?:in|on|full of) (T\d+)|"
    r"(?<=,) (?:he|she|they) (?:is|are) \w+ing (?:\w+ ){0,5}?with (T\d+)"
)
_PEOPLE = re.compile(r"\b(T\d+) (?:of (?:us|you|them)|people|guests)\b|(?<!wish )\bfor (T\d+)(?= *(?:[.,]|so\b|$))")
_TWO = 2


def without_mentions(text: str, sentence: Sentence, context: Context) -> str:
    """The skeleton without things that are thanked for, there already, or count people, if another one remains."""
    if text.count("T") < _TWO:
        return text
    for pattern in (_THANKED, _THERE, _BUSY_WITH, _PEOPLE):
        for match in pattern.finditer(text):
            name = next(group for group in match.groups() if group)
            thing = sentence.things[int(name[1:])]
            if _is_only_mentioned(pattern, match, thing, context):
                shorter = " ".join(f"{text[: match.start()]} , {text[match.end() :]}".split()).strip(" ,")
                return without_mentions(shorter, sentence, context) if re.search(r"\bT\d", shorter) else text
    return text


def _is_only_mentioned(pattern: re.Pattern[str], match: re.Match[str], thing: Thing, context: Context) -> bool:
    about = any(thing.spec.type == has.type and fits(thing.spec, has) for has in context.recent)
    if pattern is _PEOPLE:
        return thing.head == "one" and thing.count > 1 and not (thing.spec.color or thing.spec.size or thing.definite)
    if pattern is _THERE:
        return thing.head == "noun" and about and (not match[4] or (thing.definite and not thing.other))
    return thing.head == "noun"
