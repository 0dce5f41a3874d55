"""Words that tell what is wanted from what is not, where things are, and what says nothing at all."""

import re

from attune.dialogue.grammar import frames
from attune.dialogue.words import words

NEGATIVE = re.compile(
    r"(?:instead of|rather than|in place of|in lieu of|in exchange for|as opposed to|as (?:a |the )?(?:replacement|"
    r"substitute|alternative) (?:for|to)|other than|"
    r"no longer (?:want|need|require)|(?<!why )(?:do|does|did|would|will|must|should|need) not (?:\w+ )??(?:want|"
    r"need|like|"
    r"bring|fetch|"
    r"get|take|mean|ask for|give|care for|fancy|say|order|feel like|serve|deliver|prefer|hand|pass|grab)"
    r"(?: me| us| to have| you to bring| you to bring me| to eat| to use| to drink from)*|\bnot(?: in)?|\bno need for|"
    r"\bnor|wrong|"
    r"\b(?:put|take|bring|carry) (?:away|back)|except(?: for)?|sick of|enough of|\bwithout|\bskip|\bless|"
    r"against using|can not (?:\w+ )?(?:abide|stand|bear|eat|drink|have|digest|stomach)|(?:^|[.,] |"
    r"\b(?:i|we) (?:\w+ )?)(?:hate|"
    r"dislike|detest)|allergic to|tired of|fed up with|"
    r"have not asked for|never asked for|never wanted|never said|not asked for|changed my mind (?:about|on|"
    r"regarding)|"
    r"(?:am|are|was|were|be) not (?:after|looking for)|no more)$"
)
NO = re.compile(r"\bno$")
PREFERRED_OVER = re.compile(r"\b(?:prefer|preferable|rather|better|sooner|more)\b.*\b(?:than|over|to)$")
BACK = re.compile(r"^(?: P\d+)? (?:back|away|off the list|is wrong|is not what|was wrong|was a mistake|any ?more)\b")
SWAP_PAIR = re.compile(
    rf"^(?:(?:over )?from )?(?P<old>T\d+|{frames.PRONOUN}|P\d+)"
    r"(?: (?:please|back|out|in your (?:hands?|gripper|arms?)|(?:that )?you (?:have|hold|are holding|have got)|,))* "
    r"(?:for|with|against|by|to|into|and|in for|over to)(?: (?:please|just|,))* (?P<new>T\d+)"
)
SWAPPED_PAIR = re.compile(
    r"\bT(?P<old>\d+)(?: (?:to be|be|being|should be|needs to be|must be|can be))? "
    r"(?:replaced|exchanged|swapped|switched|changed|traded) (?:out )?(?:with|for|by|to|against|into) T(?P<new>\d+)"
)
ONLY_CHANGE = re.compile(
    rf"^(?:(?:please|no|,) )*P\d+ (?:please )?{frames.PRONOUN}(?: things| stuff)?(?: please)?[ .,]*$|"
    rf"\b(?:want|need|like|rather|prefer|have|love|put)\b.*?\b(?:have )?{frames.PRONOUN}(?: \w+)? P\d+|"
    r"P\d+ (?:would|will|might|should|is|is going to) be (?:\w+ )?(?:better|best|nicer|preferable|fine|good|great|"
    r"perfect|lovely|ideal|easier|handier|more \w+)|P\d+ (?:is|seems) (?:\w+ )?(?:better|best|nicer|preferable)|"
    r"\b(?:destination|location|place|spot|goal|target)\b.*? P\d+"
)
TRAVEL = re.compile(
    r"\b(?:go|look|check|open|head|walk|drive|search|run|peek|have a look|come|hop|roll|nip|pop|dash|whizz|"
    r"trundle|wander|pass)\b"
)
PASSIVE = re.compile(
    r"T\d+ (?:should|must|needs? to|has to|have to) (?:go|be|be put|be placed|be brought)(?: over| back)? P\d+|"
    r"(?:can|could|would|may|should) T\d+(?: please)? (?:be|get) (?:brought|fetched|put|placed|taken|delivered|"
    r"carried|moved|served|handed|set)"
)
ABOUT_A_THING = re.compile(
    r"(?:(?:no|oh|but|sorry|,) )*T\d+(?: P\d+)? (?:is|are|was|were|looks?|seems?) (?:\w+ ){0,2}?too\b"
)
CONTRAST = re.compile(r"\bT\d+(?: P\d+)?(?: please)?(?: ,)? (?:instead of|rather than|in place of|and not) T\d+")
ASKS_FOR_ANOTHER = re.compile(
    r"\b(?:have you(?: not)?(?: got)?|do you(?: not)? have|have not you(?: got)?|do not you have|"
    r"(?:is|are)(?: not)? there(?: not)?|you got)(?: maybe| perhaps| also| by any chance)* T(\d+)"
)
NOT_ASKED_FOR = re.compile(
    r"\b(?:that|this|it) (?:is|was) (?:not|never) (?:what|the (?:one|thing)|which) i (?:\w+ )?"
    r"(?:asked for|wanted|ordered|said|meant|had in mind|was after)\b|\bi (?:did not|"
    r"never) (?:ask(?:ed)? for|order(?:ed)?|"
    r"want(?:ed)?|mean|meant|say|said) (?:that|this|it)(?: one)?\b"
)
FOR_SOMEBODY = re.compile(r"\bfor (\w+)(?= *(?:[.,?]|$)| (?:as well|too|please|now|also)\b)")
PLEASE = re.compile(
    r"(?:^|[,.] (?:so |now |and |next |then |great |just |anyway )*)(?:please )(?:just )?T\d+(?: P\d+)?(?: (?:and|"
    r",) T\d+)*(?: this time| now)?[ .,]*$|"
    r"[,.] (?:so |now |and |next |then |just |only |anyway )*T\d+(?: P\d+)?(?: (?:and|,) T\d+)* please[ .,]*$"
)
SOMEBODY = re.compile(r"(?:he|she|they|it|my|our|his|her|their|the|somebody|someone|people) ")
LOCATED = re.compile(r"T(\d+)(?: (?:is|are|should be|must be|might be|stands?|sits?|lies|can be found|'s|will be|"
                      r"somewhere|kept|still|out|up|standing|sitting|lying|adrift|"
                      r"i think|left|over|there|right|just|now|probably|which|that|in there|inside|"
                      r",))*$")  # fmt: skip
PRONOUN_OBJECT = re.compile(
    rf"^(?:(?:me|us|over|back|down|,|please|just|then) )*(?:{frames.PRONOUN}\b|some(?= *(?:[.,?]|$| please| too)))"
)
SEVERAL = re.compile(
    r"^(?:(?:me|us|over|back|down|,|please|just|then) )*"
    r"(?:them|those|these|both|all|everything|the lot|it(?= *(?:[.,]|$)))\b"
)
LISTED = re.compile(r"\bT\d+(?: for (?:the |my )?(?!T\d)\w+)?(?:(?: ,)?(?: and| plus)? T\d+)+")
"""Things named together, which "them" means afterwards: "a plate, a fork, bring them"."""
COMMENTED = re.compile(
    r"^(?:(?!no\b|not\b|sorry\b|actually\b|i mean\b)[^.?])*?(?:, |because |cause |since |instead , |rather , )"
    r"(?:there (?:is|are)|(?:the|my|our|his|her|\w+ 's|somebody|someone|somebody 's|\w+) (?!mean\b|meant\b|said\b)"
    r"(?:'s|is|are|has|have|\w+ed|\w+ \w+ed|\w+ (?:'s|is|are|has|have))\b)"
)
"""A remark about another place, after the one where something shall go."""
OTHER_PLACE = re.compile(r"(?: ,)?(?: and)? (?:rather than|instead of|not) P\d+")
SUBJECT = re.compile(r" (?:is|'s|has|was|will|would)\b")
SHOWN = re.compile(
    r"(?:(?:no|but|oh|hey|sorry|well|,) )*(?:that|this|these|those|it) (?:is|are|'s) (?:just |only |a )?"
    r"T(\d+)(?= *(?:[.,]|$))"
)
NEGATIVE_SPOT = re.compile(r"(?:instead of|rather than|in place of|\bnot|\bthan)$")
FILLER = words(
    "please thanks thank you and also too as well now then okay ok robot for me us if possible would "
    "could can no sorry wait actually i mean meant instead of rather than not but oh yes again maybe "
    "perhaps some more just only here over to "
    "hey hello hi right there good morning evening afternoon well make it that a an the or quickly , . ? plus "
    "additionally "
    "was asked asking said wanted had one quick fast asap kindly nope rather will do  my be so dear "
    "love mate buddy pal do is change plan plans of mind on second thought thoughts better wrong ah aha "
    "this way from with at once immediately straight away soon second thoughts changed  correction "
    "oops    sir madam yet another time next first after all in addition coming up prefer "
    "today very much ready moment when minute in case any chance  ahead "
)


def without_purpose(body: str) -> str:
    """Cut off what it is for: "a bowl for my T1", "a knife to cut T1"."""
    body = re.sub(r"\b(everything|all|things|stuff|what) (?:(?:i|we) need )?for (?:my |the |our )?T\d+", r"\1", body)
    body = re.sub(r"(?<=[TP]\d)( please)? for (?:my |the |our |a )?T\d+", r"\1", body)
    body = re.sub(
        r" , (?:it|that|they|which) (?:is|are|was|were) (?:T\d+ )?(?:that |which )?"
        r"(?:i|my|we|our|he|she|they|you|his|her) [^.?]*",
        "",
        body,
    )
    body = re.sub(r"\b(?:so that|so) (?:i|we) .*", "", body)
    body = re.sub(r"\b(?:because|since|(?<!well )as) (?:i|my|we|the|our|it|T\d+) .*", "", body)
    body = re.sub(
        r"(?<=\d) to (?:cut|eat|drink|spread|put|pour|use|make|go|stir|mix|butter|serve|slice|hold|have|enjoy) .*",
        "",
        body,
    )
    return re.sub(r"\b(?:which|that) (?:i|we|you) .*?(?=,|\.|$)", "", body)
