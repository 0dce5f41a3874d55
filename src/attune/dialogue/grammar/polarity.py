"""Which of the things that are named are not wanted: "not the cup", "instead of the bowl", "forget the spoon"."""

import re
from collections.abc import Sequence

from attune.dialogue.context import Context
from attune.dialogue.grammar import cues
from attune.dialogue.grammar.clauses import Clause
from attune.dialogue.grammar.items import Spot, Thing


def refused(
    clauses: Sequence[Clause], things: Sequence[Thing], spots: Sequence[Spot], context: Context
) -> tuple[set[int], dict[int, bool]]:
    """The numbers of the things that are not wanted, and which of them were called wrong."""
    wrong: dict[int, bool] = {}
    negative: set[int] = set()
    total = sum(len(clause.things()) for clause in clauses)
    for clause in clauses:
        text = clause.text
        last_negative = False
        for match in re.finditer(r"\bT(\d+)\b", text):
            number = int(match[1])
            before, after = text[: match.start()].rstrip(), text[match.end() :]
            listed = (
                last_negative
                and re.search(r"T\d+ (?:and|or|nor|,)$", before) is not None
                and total > len(negative) + 1
                and (not re.search(r",$", before))
            )
            last_negative = (
                listed
                or cues.NEGATIVE.search(before) is not None
                or (
                    cues.NO.search(before) is not None
                    and clause.kind != "lack"
                    and not things[number].article
                    and (total > 1 or things[number].spec.type in {has.type for has in context.recent})
                )
                or cues.PREFERRED_OVER.search(before) is not None
                or (cues.BACK.match(after) is not None and clause.kind in {"fetch", "put", "drop", "plain"})
                or (
                    clause.kind == "drop"
                    and clause.body.startswith(f"T{number}")
                    and not (goes_to(clause, spots) and _is_put_there(clause, things[number], context))
                )
            )
            if last_negative:
                negative.add(number)
                # "the wrong cup" is whatever the robot brings or has brought.
                wrong[number] = re.search(r"\b(?:wrong|(?:this|that|it) is not)$", before) is not None
    return negative, wrong


def _is_put_there(clause: Clause, thing: Thing, context: Context) -> bool:
    """Whether "drop a mug off at the table" asks for a mug: the robot cannot leave out what it is not about."""
    about = {has.type for has in context.recent}
    if clause.verb == "return":
        return not context.busy
    return clause.verb in {"drop", "leave"} and not thing.definite and (thing.article or thing.spec.type not in about)


def goes_to(clause: Clause, spots: Sequence[Spot]) -> bool:
    """Whether a clause says where a thing shall be."""
    return any(spots[number].role in {"at", "to"} for number in clause.spots())
