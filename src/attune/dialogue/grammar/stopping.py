"""Finds orders to halt, to wait or to give up; and what only sounds like one ("don't stop", "the bus stop")."""

import re

from attune.dialogue.words import words

_SOFT_END = (
    r"(?: (?:please|now|robot|at once|immediately|right now|already|will you|would you|okay|thanks|"
    r"thank you|for now|then|all right|for (?:a|one|two|five|ten) (?:moments?|minutes?|seconds?|secs?|bit|while)))*"
)
_MAY_COME_BEFORE = words(
    "no wait please robot hey okay actually just oh sorry well and you then but so said yes now or"
)
_BEFORE = rf"(?:^|(?<=[.,?] )|{'|'.join(f'(?<=@{word} )' for word in sorted(_MAY_COME_BEFORE))})".replace("@", r"\b")

NOT_A_STOP = re.compile(
    r"\b(?:please )?(?:(?<!why )(?<!if you )do not (?:you )?(?:ever |even think about |just |dare (?:to )?)?"
    r"(?:stop(?:ping)?|freeze|halt|pause|give up|wait|cancel|abandon)|"
    r"do not let (?:me|us|this|that) (?:stop|interrupt|disturb) you|"
    r"why (?:would|should) (?:i|we|you) (?:want you to )?(?:stop|wait|pause)|"
    r"i never (?:said|told you to|asked you to|meant you to) (?:stop|wait|pause)|"
    r"never stop|(?:you )?do not (?:have|need) to (?:stop|wait|pause|halt)|no need to (?:stop|wait|pause|halt)|"
    r"not (?:have|need) to stop|"
    r"(?:i )?(?:was|am) not (?:telling|asking|talking to|ordering) you(?: to)? (?:stop|wait|halt)|"
    r"(?:i )?(?:did|do) not (?:say|mean|want you to|tell you to|ask you to|said|"
    r"mean to)(?: say)? "
    r"(?:\w+ )?(?:stop|halt|wait|pause)|(?<!if you do )not stop|without stopping|"
    r"should not stop|must not stop|keep going (?:and )?do not stop|(?:there is )?no reason to stop|non stop|nonstop)"
    r"(?: (?:now|it|that|please|yet|here|there|until \S+ \S+|moving|going|working|what you are doing|on my account|"
    r"because of me|there is|robot))*"
)
_GERUNDS = (
    r"(?:moving|doing|going|driving|walking|bringing|fetching|getting|carrying|working|searching|looking|running|"
    r"reaching|"
    r"grabbing|taking|putting|making|preparing|setting|delivering|rolling|turning|placing|opening|picking|everything|"
    r"being|trying|messing|touching)"
)
_STAND_STILL = re.compile(r"(?:^|(?<=[.,?] )|(?<=robot ))(?:stand|stay|hold|keep) still\b|^do not move\b")
STOP_WORD = re.compile(r"\b(?:stop|halt|freeze|abort|cease|whoa|woah|stopp|avast|desist|discontinue)\b")
_STOP_EXCLUDED_BEFORE = re.compile(
    r"(?:\b(?:bus|tram|train|next|last|full|pit|non|a|the|this|my|our|first|truck|whistle|metro|subway|rest|"
    r"never|not|did|does|without|he|she|they|we|i|it|who|always|rain|ever|people|kids|him|her|them|us|"
    r"someone|everyone|somebody|deep|coffee|pee|quick|short)"
    r"|(?<!i )(?<!just )(?<!i have )\b(?:said|says|shouted|shouts|yelled|yells|screamed|cried|shouting|yelling|saying|"
    r"was like|told (?:me|us|him|her|them))(?: to| that)?(?: ,)?"
    r"|\b(?:when|whenever|if|until|unless|once|time|because) (?:i|we|you|they|he|she) "
    r"(?:say|said|shout|shouted|yell|yelled)(?: ,)?"
    r"|\b(?:who|what|nobody|never|no one|why would i)(?: \w+){1,2} you(?: to)?"
    r"|\b(?:did|do|have) (?:i|we|you) (?:just |ever |really |even )?(?:say|said|hear|mean)(?: ,)?"
    r"|\b(?:never|not|word|about|written|reads|called) (?:\w+ )?(?:said|say|meant|mean|ask|asked)?(?: ,)?"
    r"|(?<!you )\b(?:could|would|will)|\b(?:i|we) (?:had|have) to"
    r"|\b(?:why|when|where|how|if|until|unless|before|after|whenever|once) (?:you|it|that)|\b(?:did|do|"
    r"does) (?:you|it)"
    r"|(?<!you )(?<!have )(?<!need )(?<!said )(?<!had )(?<!must )(?<!ought )(?<!got )to"
    r"|(?:tell|told|ask|asked|want|wants|wanted|get|got|begged) (?!you )\w+ to"
    r"|(?:he|she|they|mum|mom|dad|people|doctor|the|my) \w* ?(?:said|says|told me|tells me|wants me|"
    r"asked me)(?: to)?)$"
)
_STOP_EXCLUDED_AFTER = re.compile(
    rf"^ (?:(?!{_GERUNDS}\b)\w+ing\b(?! please)|by\b(?! P\d)|sign\b|light\b|watch\b|over\b|and smell|at the \w+\b|"
    rf"in the \w+\b|"
    r"(?:us|you|him|them)\b|near\b|motion|button\b|words?\b|talk\b|"
    r"(?:the|this|that|your|those) (?:music|car|bus|train|tv|television|"
    r"radio|noise|oven|"
    r"kettle|washing|dog|cat|baby|kids|children|video|film|movie|bleeding|leak|fight|song|game|alarm|timer|"
    r"nonsense|war)\b)"
)
_TALK_STOP = re.compile(
    r"\bstop (?:talking|speaking|chatting|telling|saying|yelling|shouting|babbling|mumbling|announcing|explaining)\b"
)

_OF_PEOPLE = re.compile(
    r"\b(?:stop|quit) (?:crying|whisking|stirring|chopping|peeling|kneading|frying|chewing|eating|drinking|licking|"
    r"biting|laughing|giggling|teasing|tickling|bullying|smoking|whining|moaning|complaining|nagging|arguing|fighting|sulking|"
    r"swearing|lying|joking|kidding|barking|growling|scratching|sniffing|snoring|coughing|sneezing|fidgeting|slouching|"
    r"worrying|dreaming|dancing|whistling|kissing|flirting)\b|\bhold on (?:to \w|tight)"
)


_CAREFULLY = re.compile(
    r"\bmind (?:the|your|my|that|those) (?!P\d)(?:step|steps|stairs|gap|door|rug|edge|head|toes|feet|cat|dog|wall)\b|"
    r"\bhold (?:it|that|them|T\d+) (?:with|by|in|from|upright|level|straight|tight|tightly|carefully|gently|firmly|"
    r"properly|like)\b"
)


def is_no_stop(skeleton: str) -> bool:
    """Whether it only sounds like a stop: what people and animals shall not do, or care: "stop crying"."""
    return bool(_OF_PEOPLE.search(skeleton) or _CAREFULLY.search(skeleton))


_WAIT = re.compile(
    rf"{_BEFORE}(?:(?:can|could|would|will) you |please |just )*"
    r"(?:(?<=you )wait T\d+|wait|hold on(?! to \w| tight)|hang on|hold it|hold up|pause|"
    rf"hold your horses|"
    r"hang fire|would you mind waiting|(?:put|keep) (?:it|that|this|everything) on (?:hold|pause)|"
    r"hold(?= *(?:[.,?]|$))|"
    r"(?:just )?(?:one|a) (?:moment|second|sec|minute|mo)|give me (?:a|one) (?:moment|second|sec|minute)|"
    r"hold still|(?:take|have) a break(?: from (?:it|that|this))?|rest a moment)"
    r"(?: (?:a|one|just|second|sec|secs|seconds|minute|minutes|moment|mo|tick|please|for|me|there|up|now|while|"
    r"bit|here|robot|"
    r"right|everything|it|that|this|little|couple|of|the|task|wait|hold|on|hang|then|okay|until (?!you (?:hear|see)).*|"
    r"what you are doing|to|think|let me think|"
    r"(?:i|somebody|someone|there|the (?:door|phone|bell|dog|cat|baby|kids|children)|he|she|they|we) "
    r"(?![^.?]*\b[TP]\d)[^.?]*|my \w+$|what|will|would|you|everyone|all|work|movement|your|on it))*(?= *(?:[.,?]|$))"
)
_ALL_OF_IT = (
    r"(?:it|that|this|them|everything|anything|all|all of (?:it|that|them)|the lot|"
    r"(?:the|that|this|my) (?:\w+ )?(?:thing|lot|business|order|task|request|job|action|plan|command|delivery|one|idea|"
    r"matter|errand)|(?:whatever|any|every) (?:task|job|order)(?: you have)?|"
    r"(?:the |my |that )?breakfast|my (?:\w+ )?(?:request|order|wish)|"
    r"what (?:i|you) (?:\w+ ){0,2}?(?:said|asked|wanted|doing|ordered|do)(?: for)?|i said anything|i asked)"
)
_BREAK_OFF = (
    rf"(?:interrupt|suspend|terminate|discontinue|disregard|ignore|strike|belay|end|stop|halt|break off|undo|revoke|"
    rf"cancel|withdraw|drop) (?:{_ALL_OF_IT}|(?:your|the|my|this|that) (?:(?:last|current|previous|whole) )?(?:task|"
    r"action|activity|work|job|mission|motion|movement|request|command|order|instruction|errand|trip|thing)|"
    r"what you are doing|that last (?:bit|part|one))|"
    r"i (?:would like|want|wish|need) to (?:cancel|withdraw|revoke|take back)"
    r"(?: (?:it|that|this|everything|my (?:\w+ )?(?:request|order|wish|instruction)))?(?: if \w+(?: \w+)?)?|"
    r"come to a (?:halt|stop)|jack it in|(?:keep|stay|stand) back|"
    r"interrupt|break off|(?:that is )?far enough|no further|hold (?:your )?fire|brakes?|(?:hit|put on) the brakes|"
    r"put the brakes on|steady(?: on)?|easy(?: there| now)|take five|"
    r"let us (?:take a break|pause|stop(?: here| there)?)|"
    r"(?:would|do) you mind (?:stopping|waiting|pausing|not doing that)|i take (?:it|that) back|"
    r"on second thoughts?(?: ,)? (?:do not|leave it|no|never mind)|nobody moves?|everybody stop|"
    r"you (?:can|may) (?:rest|relax|put your feet up)|(?:we|you) are (?:done|finished|through) here|timeout|let go|"
    r"(?:it is|i think it is) (?:about )?time (?:that )?you stopped|(?:it is )?time to stop|"
    r"(?:it is |that is )?(?:no longer|not) (?:needed|necessary|required)(?: any ?more| any ?longer| now)?|"
    r"i would (?:like|prefer) (?:it if )?you (?:to )?(?:stopped|stop|waited|paused)|i want a (?:pause|break)"
)
_GIVE_UP = re.compile(
    rf"{_BEFORE}(?:(?:can|could|would|will) (?:you|we) |we (?:can|could) |please |just |let us |you can |you may |"
    rf"you might as well |oh |i (?:want|need|would like) you to |i would say )*(?:"
    rf"never ?mind(?: (?:about )?{_ALL_OF_IT}| (?:that )?then| after all)(?! T\d)|never ?mind(?! (?:the|about|T\d)\b)|"
    rf"(?:forget|cancel|scrap|drop|scratch|skip|abandon|leave off|give up(?: on)?)(?: about)? {_ALL_OF_IT}(?: all)?|"
    r"cancel|"
    r"give up (?:on )?T\d+|(?<!take it or )leave it(?: (?:be|alone|there|now|then|for now|at that|please|all))?|"
    r"leave (?:that|this|"
    r"everything)(?: (?:be|alone))?|leave (?:off|be)|"
    r"call (?:it|that|this|the whole thing|everything|the thing) off|call it off|"
    r"knock it off|cut it out|cut that out|give it a rest|give (?:it )?up|quit(?: it| that)?|"
    rf"quit {_ALL_OF_IT}|pack it in|"
    r"(?:okay )?(?:that is|that will be|that has been|it is|i have had|this is)? ?(?:quite |more than |"
    r"really )?enough(?: (?:now|already|for now|for today|of (?:this|that|it)))*|"
    r"that will do(?: now)?|(?:do not|stop) (?:you )?(?:dare )?mov(?:e|ing)(?: a muscle| any further| at all|"
    r" any more| an inch)?|stay (?:where you are|there|put|still|right (?:there|where you are)|here|away)|"
    r"(?:stand|keep|hold|be|stay|remain|sit) still|do not (?:do|touch|bring|fetch|get|take|move|bother|continue|"
    r"carry on|keep going|"
    r"go(?: any further| on| there)?|proceed)(?: (?:it|that|this|anything|me anything|them|with (?:it|that)|"
    r"anything else|on|me that|any more|any further))*|"
    r"never you mind|(?:i|we) (?:will|can|could) (?:do|manage|cope) without(?: it| that| them)?|"
    r"back off|(?:(?:i|we) )?(?:do not|no longer|did not) (?:need|want)(?: (?:it|that|this|anything|them)(?= |$)|"
    r" (?:the |my |any )?breakfast(?= any ?more| now| after all))?(?: (?:any ?more|any ?longer|now|"
    r"after all|at all|from you))*|"
    r"i (?:do not|no longer) want you to (?:do that|do it|continue|bring .*|go on)|no need(?: (?:any more|"
    r"to (?:go|look|bother|continue|do (?:it|that)|(?:bring|fetch|get) (?:it|that|them|anything))|"
    r"for that|any longer|after all))?|"
    r"let it (?:be|go)|do nothing|"
    r"(?:do not (?:take|go|make|move) |not )(?:another|one more) (?:inch|step|move|meter|centimeter|centimetre)|"
    r"end (?:it|the task|this)|terminate|shut (?:it )?down|switch off|"
    r"turn (?:yourself )?off|stand down|emergency(?: stop)?|"
    r"watch out|look out|hands off|do not|no more(?: of (?:this|that))?|break it off|time out|kill it|"
    r"let go of that plan|break|"
    r"(?:i am|we are) cancelling (?:it|that|this|everything)|"
    r"you (?:need not|do not (?:have|need) to) (?:bring|fetch|get|go|do)(?: (?:it|that|this|them|anything))*"
    r"(?: any ?more| any ?longer| after all)?|do not bother(?: (?:with|about) T\d+)?|"
    r"i give up|undo that|discard that|you can leave it|that is not necessary any more|"
    r"it is not necessary any more|not any more|"
    r"back to idle|skip it|skip that|put an end to (?:it|that|this)|i am calling it off|"
    rf"{_BREAK_OFF}"
    rf"){_SOFT_END}(?= *(?:[.,?]|$))"
)


_WITH_A_REASON = re.compile(
    r"^never ?mind(?= i (?:do not|no longer|found|have)\b)|"
    r"\bif you do not (?:stop|quit|halt|wait)(?: \S+){0,3}?(?= (?:, )?i (?:will|am)\b)"
)
"""Not at the end of a clause: "if you don't stop I'll pull the plug"."""


def without_denied_stops(skeleton: str) -> tuple[str, bool]:
    """Cut out what denies a stop ("don't stop"); says whether there was any."""
    cleaned = NOT_A_STOP.sub(" ", skeleton)
    return " ".join(cleaned.split()).strip(" ,"), cleaned != skeleton


def find_stop(skeleton: str) -> tuple[int, int, str] | None:
    """Where an order to stop stands: start, end, and its words; None when there is none."""
    if _TALK_STOP.search(skeleton):
        return None
    if threatened := _WITH_A_REASON.search(skeleton):
        return threatened.start(), threatened.end(), threatened[0].strip()
    for match in STOP_WORD.finditer(skeleton):
        before, after = skeleton[: match.start()].rstrip(), skeleton[match.end() :]
        if match[0] == "stop" and (_STOP_EXCLUDED_BEFORE.search(before) or _STOP_EXCLUDED_AFTER.match(after)):
            continue
        if match[0] in {"freeze", "halt", "abort"} and re.search(
            r"\b(?:the|a|(?<!you )to|not|will|would|i|we|it|they)$", before
        ):
            continue
        return match.start(), _end_of_stop(skeleton, match.end()), match[0]
    for pattern in (_GIVE_UP, _WAIT, _STAND_STILL):
        found = pattern.search(skeleton)
        if found:
            return found.start(), found.end(), found[0].strip()
    return None


_STOP_TAIL = re.compile(
    rf"(?: (?:it|that|this|now|right|there|here|please|at once|immediately|everything|robot|the robot|the (?:task|"
    rf"plan|action|whole thing|delivery|work|machine)|"
    r"what you are doing|whatever you are doing|for (?:a|one) (?:second|moment|minute|sec|bit|while)|instant|stop|"
    r"already|"
    rf"this (?:instant|minute|second)|moving|doing (?:that|this|it|anything|whatever you are doing|"
    rf"what you are doing)|{_GERUNDS}(?: (?:it|that|this|me|things|breakfast|anything|T\d+|P\d+))*|thank you|thanks|"
    r"just|all|a (?:second|moment|minute)|,|halt|wait|freeze|no|so|before .*|or .*|i said|do you hear me?|hey|oh|"
    r"or else|you)(?![a-z]))*"
)


def _end_of_stop(skeleton: str, end: int) -> int:
    tail = _STOP_TAIL.match(skeleton, end)
    return tail.end() if tail else end
