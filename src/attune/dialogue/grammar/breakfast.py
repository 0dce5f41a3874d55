"""Finds requests to prepare breakfast, as opposed to talk about breakfast."""

import re

_MEAL = r"(?:breakfast|brekkie|brekky|breakky|break fast|morning meal)"
_TABLE = r"(?:the |our |my )?(?:breakfast |dining |kitchen )?table"
_PREPARE = re.compile(
    r"\b(?:make|making|prepare|preparing|prep|get|getting|set|setting|lay|laying|fix|fixing|serve|serving|start|"
    r"starting|do|doing|arrange|arranging|"
    r"organi[sz]e|ready|cook|cooking|have|having|put|putting|help|bring|bringing|fetch|begin|whip up|rustle up|"
    r"assemble|eat|eating|like|want|need|love|fancy|"
    r"time|about|go|deal|handle|take care|sort|create|provide|deliver|could use|use|got|laid|gather|collect|"
    r"could do with|"
    r"kick off|see to|give|proceed|wish|order|request|craving|crave|feel like|prefer|hungry|starving|happen|it is|"
    r"set up|say|said)\b"
)
_SET_TABLE = re.compile(
    rf"\b(?:set(?:ting)?(?: up)?|laid|lay(?:ing)?(?: out)?|prepare|preparing|dress|arrange|get(?:ting)?|ready|make|"
    rf"do|(?!at |on |from |to |is |of |by |under |near |in |and |"
    rf"for )\w+(?= {_TABLE} for {_MEAL})) {_TABLE}(?: (?:ready|up|set|laid|for {_MEAL}|for (?:me|us|"
    rf"two|one|three|four)))*\b"
)
_TABLE_SET = re.compile(
    r"\btable (?:(?:(?:to|must|should|needs to|has to) be )?(?:set|laid|ready|prepared)|"
    r"needs (?:setting|laying|preparing))\b"
)
_WERE_DONE = re.compile(
    rf"\b(?:if|wish) (?:{_TABLE}|(?:the |my |our )?{_MEAL}) (?:was|were|is|could be|got) "
    r"(?:all )?(?:set|laid|made|ready|prepared|served|on)\b|"
    rf"\bif you (?:\w+ )?(?:made|prepared|served|set|laid|did|started|got|fixed|cooked)(?: me|"
    rf" us)? (?:{_TABLE}|(?:the |my |our |some )?{_MEAL})"
)
_SOMEBODY_DID = re.compile(
    r"(?<!can )(?<!could )(?<!shall )(?<!should )(?<!may )\b(?:i|we|he|she|they|who) (?:had to|have to|used to|did|"
    r"will|already|always|just|never|usually|often) (?:\w+ )?$"
)
_OTHER_MEAL = re.compile(r"\b(?:dinner|lunch|supper|tea|brunch|tennis|games?|cards|poker)\b")
_TALK = re.compile(
    r"^(?:what(?! about)|where|when|who|did|does|have you|has|was|were|is|how (?!about)|why (?!do not|will)|"
    r"do (?:you|"
    r"we) (?:like|eat|have|usually)|are (?:you|we)(?! (?:able|going))|which)\b|"
    r"^(?:\w+ )?tell (?!me)\w+|"
    r"\b(?:had|ate|eaten|skipped|made|missed|was|their|his|her|"
    r"for tomorrow|used to|would make|makes|loves?|likes|enjoys?|always|usually|never|"
    r"served|yesterday|already|last|hate|about to have|is important|in bed|television|tv|news|show|club|room|"
    r"hotel|tomorrow|later|finished|finish|over)\b"
)
_AROUND = re.compile(rf"\b(?:before|after|during|since|until|late for|at|over) (?:\w+ )?{_MEAL}")
_ALONE = re.compile(
    rf"^(?:(?:please|robot|now|okay|yes|{_MEAL}|time|the|for|it is|me|us|my|our|one|two|three|four|everyone|"
    rf"everybody|all of us|good|morning|thanks|thank you|hey|"
    rf"hello|ready|i am|am|we are|and|then|so|,|\.|!|\?|would be (?:nice|great|lovely|good)) ?)+$"
)
_NOT_NOW = re.compile(rf"\b(?:no|not|do not|without|cancel|forget|stop|skip) (?:(?!and\b|but\b)\w+ ){{0,3}}?{_MEAL}")


def wants_breakfast(plain: str, has_things: bool) -> bool:
    """Whether an utterance asks to set the table for breakfast.

    Args:
        plain: The normalised words with their breaks.
        has_things: Objects are named too: then "for breakfast" is only a purpose.
    """
    for sentence in re.split(r" [.?](?: |$)", plain):
        clause = sentence.strip(" ,")
        meal = re.search(rf"\b{_MEAL}\b", clause)
        table = _SET_TABLE.search(clause) or _TABLE_SET.search(clause)
        if not meal and (not table or _OTHER_MEAL.search(clause)):
            continue
        if _WERE_DONE.search(clause) and not clause.startswith(("do you", "did", "have you", "i wonder", "who")):
            return True
        if _NOT_NOW.search(_without_politeness(clause)):
            continue
        if table and _SOMEBODY_DID.search(clause[: table.start()]):
            continue
        if (
            table
            and (meal or not has_things)
            and not re.match(
                r"(?:i|we|he|she|they|who|did|have|has|my \w+) (?!want|need|would|was|am|"
                r"wonder)",
                clause,
            )
        ):
            return True
        if has_things and re.search(rf"\bfor (?:my |the |our |a )?(?:\w+ )?{_MEAL}", clause):
            continue
        if not meal or _TALK.search(_without_politeness(clause)) or _AROUND.search(clause):
            continue
        if _ALONE.match(clause) or _PREPARE.search(clause):
            return True
    return False


def _without_politeness(clause: str) -> str:
    return re.sub(
        r"\b(?:i was (?:just )?(?:wondering|hoping|thinking)|was (?:wondering|hoping)|before you go|"
        r"already (?:late|hungry)|at once|have not eaten|have not had (?:my |any )?|not had|not had|not eaten|"
        r"time already)\b",
        " ",
        clause,
    ).strip()
