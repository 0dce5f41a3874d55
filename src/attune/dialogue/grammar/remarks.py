"""Utterances that ask for nothing to be fetched: carry on, style wishes, questions, thanks, small talk."""

import re

from attune.core.messages import Band
from attune.dialogue.interpreter import Intent, Interpretation, StatusTopic, StyleWish

_POLITE = (
    r"(?:please|robot|now|okay|actually|just|then|thanks|thank you|hey|oh|well|so|yes|alright|all right|right|and|"
    r"but|no|you can|you may|could you|can you|would you|will you|let us|i would like you to|i want you to|"
    r"would you mind|you should|now you can|,|\.|\?)"
)

_CARRY_ON = re.compile(
    rf"(?:{_POLITE} )*(?:carry(?:ing)? on|go(?:ing)? on|continue|continuing|keep going|resume|go ahead|proceed|"
    rf"keep at it|keep it up|"
    r"keep moving|start again|move on|you can start again|on you go|as you were|finish (?:it|the task|"
    r"what you were doing)|pick up where you left off|"
    rf"unfreeze|unpause|get going again|get on with it)(?: (?:with (?:it|that|the task|what you were doing|"
    rf"your work|your task|breakfast)|working|again|from where you (?:stopped|were)|moving|what you were doing|"
    rf"bringing .*|as before|{_POLITE}))*[ .,?]*"
)
_PUT_BACK = re.compile(
    rf"(?:{_POLITE} )*(?:(?:put|take|bring|carry|move|place) (?:it|that|this|them|those|everything|both) (?:back|"
    rf"away)|(?:put|take) (?:back|away) (?:it|that|everything|them)|"
    rf"return (?:it|that|them|this|everything)|put it where (?:it was|you found it|"
    rf"you got it))(?: (?:to )?where (?:it|they|you) .*| again| to (?:its|their) place| (?:into|in) (?:its|"
    rf"their) place| {_POLITE})*[ .,?]*"
)
_REPEAT = re.compile(
    rf"(?:{_POLITE} )*(?:(?:say|repeat) (?:that|it|this)?(?: again| one more time| once more)?|repeat|"
    rf"pardon(?: me)?|what did you say|what was that|come again|say again|excuse me|"
    rf"i did not (?:hear|catch|get|understand) (?:that|you|it|what you said)|once more|sorry)(?: {_POLITE})*[ .,?]*|"
    r"(?:(?:sorry|oh|pardon|robot|,|\.|\?) )*what(?: (?:please|sorry|robot|,|\.|\?))*[ .,?]*"
)
_LESS = re.compile(
    r"\b(?:(?:talk|speak|tell me|say|chatter|announce) less|less (?:talking|talk|chatter|chatty|words|information|"
    r"detail|announcements)|"
    r"(?:do|need|have) not (?:have to |need to |always )?(?:tell|say|announce|explain|describe|"
    r"report)(?: me)? (?:everything|so much|every\w*|each|all|that much|what you are doing|that|it all|anything)|"
    r"not talk so much|do not talk|talk too much|too chatty|too much talking|be (?:quiet|silent)|shut up|"
    r"stop (?:talking|speaking|telling me|announcing|chatting|babbling|explaining|yelling|shouting)|"
    r"no need to (?:tell|say|announce|explain|comment)|keep it short|be brief|(?:please )?shush|hush|silence|"
    r"only the (?:important|essential)|without (?:talking|commenting)|save your breath|not so many words|"
    r"just do it)\b"
)
_MORE = re.compile(
    r"\b(?:(?:talk|speak|explain|say|tell me) (?:a bit |a little )?more(?! \w+ly\b)|"
    r"tell me (?:what|everything|each|every|when|before|"
    r"about (?:what|everything)|where you|step)|keep me (?:informed|posted|updated|in the loop)|"
    r"let me know (?:what|when|before|everything)|explain (?:what|everything)|warn me before|"
    r"announce (?:everything|every|what|your)|say what you|describe what you|inform me|more (?:detail\w*|"
    r"information))\b"
)
_SLOWER = re.compile(
    r"\b(?:slower|more slowly|slow down|too fast|not so fast|"
    r"(?:speak|talk|say \w+) (?:\w+ )?(?:slow(?:ly)?|clear(?:ly|er)))\b"
)
_FASTER = re.compile(
    r"\b(?:(?:speak|talk|say \w+) (?:\w+ ){0,2}(?:faster|quicker|more quickly)|faster|too slow(?:ly)?|speed up|"
    r"talk quickly)\b"
)
_LOUDER = re.compile(
    r"\b(?:louder|speak up|(?:can|could) not hear you|too quiet(?:ly)?|too soft(?:ly)?|more loudly|"
    r"turn (?:up the volume|the volume up|it up)|volume up|hard of hearing|talk up|raise your voice)\b"
)
_QUIETER = re.compile(
    r"\b(?:quieter|not so loud|too loud(?:ly)?|more quietly|(?:speak|talk) (?:more )?(?:softly|quietly|softer)|"
    r"softer|lower your voice|turn (?:down the volume|the volume down|it down)|volume down|keep your voice down|"
    r"less loud|whisper)\b"
)

_NORMAL = re.compile(
    rf"(?:{_POLITE} )*(?:(?:(?:talk|speak)(?: to me)?|be|go|use|back to|at|in|with) )*"
    rf"(?:normal(?:ly)?|as (?:usual|always|before)|(?:(?:your|the|an?) )?(?:normal|usual) (?:speed|volume|voice|pace))"
    rf"(?: (?:again|{_POLITE}))*[ .,?]*"
)

_NUMBERS = {"twenty": 20, "thirty": 30, "forty": 40, "fourty": 40, "fifty": 50, "sixty": 60, "seventy": 70,
            "eighty": 80, "ninety": 90,
            "eighteen": 18, "nineteen": 19, "sixteen": 16, "seventeen": 17, "fifteen": 15, "hundred": 100}  # fmt: skip
_DECADES = {f"{name[:-1]}ies": age for name, age in _NUMBERS.items() if name.endswith("ty")}
_AGE = re.compile(
    r"\bi am (?:only |already |almost |over |about )?(?:in my )?(?:early |mid |late )?(\d+|"
    + "|".join(_NUMBERS)
    + "|"
    + "|".join(_DECADES)
    + r")s?(?: \w+)?(?: years?(?: old| young)?)?[ .,]*$"
)
_OLD = re.compile(
    r"\bi am (?:an? )?(?:very |quite |rather )?(old|older|elderly|senior|pensioner|retired|young|younger|teenager|"
    r"student|kid|child)(?: \w+)?[ .,]*$"
)

_THANKS = re.compile(
    r"(?:(?:oh|okay|well|yes|no|that is|that was|it is|this is|you are|very|so|really|all|just|right|a|great|ah|"
    r"good|i|and) )*"
    r"(?:thank you|thanks|cheers|much appreciated|well done|good (?:job|robot|work|boy|girl)|great job|nice job|"
    r"perfect|"
    r"wonderful|brilliant|excellent|lovely|great|good|nice|fantastic|awesome|super|cool|fine|appreciate it|amazing|"
    r"delicious|you are the best|love it|that is all)"
    r"(?: (?:for T\d+(?: (?:and|,) T\d+)*|"
    r"thank you|thanks|so|very|much|a|lot|again|robot|indeed|for (?:that|your help|everything|helping|"
    r"the help)|"
    r"that is|perfect|great|lovely|kind|of you|good|job|work|you are|welcome|now|everything|all|done|my|dear|friend|"
    r"wonderful|nice|it is|bye|,|\.|too|then|well))*"
)
_GREETING = re.compile(
    r"(?:(?:oh|well|and|,|\.) )*(?:hello|hi|hey|good (?:morning|evening|afternoon|day|night)|greetings|goodbye|"
    r"bye|see you|"
    r"how are you|how do you do|nice to meet you|good to see you|welcome)"
    r"(?: (?:there|robot|hello|hi|hey|my|dear|friend|everyone|everybody|all|good|morning|evening|how|are|you|"
    r"today|again|later|"
    r"soon|bye|buddy|old|old chap|little|i am|back|doing|feeling|do|is it going|going|nice to|meet|see|to|and|"
    r"then|tomorrow|"
    r",|\.|\?))*"
)
_HOW_ARE_YOU = re.compile(r"\bhow (?:are you|do you do|is it going)\b")
_FAREWELL = re.compile(r"\b(?:good ?bye|bye|see you|good night)\b")
_IS_THE = re.compile(r"(?:\w+ |, )*?(?:is|are) (?:the|my|our|all the) ")
_BACKCHANNEL = re.compile(
    r"^(?:(?:mhm|uh|huh|aha|ah|oh|okay|right|i see|got it|sure|alright|all right|hm+|mm+|well|so|yes|really|"
    r"indeed|ha|haha|wow|interesting|fine|yay|ooh|,|\.|\?) ?)+$"
)
YES = re.compile(
    r"^(?!(?:robot|oh|and|then|dear|just|well|mhm|,|\.| )*$)(?:(?:mhm|yes|sure|okay|alright|all right|right|of course|"
    r"please do|please|go ahead|do that|do it|exactly|"
    r"correct|absolutely|definitely|certainly|indeed|sounds? (?:good|great|fine|lovely)|"
    r"(?:that|it) (?:is|would be|will be|sounds) (?:just |really |very |absolutely |quite |most )?(?:right|fine|good|"
    r"great|lovely|perfect|nice|correct|okay|wonderful|splendid|grand|smashing|brilliant|fantastic|super|excellent|"
    r"marvellous|marvelous|terrific|ideal|fab|fabulous|kind|helpful|ace|champion|delightful|magic|awesome|cool|it)|"
    r"(?:would be|is) fine|i do|i did|why not|go on|that is what i (?:said|meant|want|wanted)|i said that|"
    r"good idea|perfect|by all means|affirmative|very well|great|fine|"
    r"that one|that is (?:the one|it)|"
    r"thank you|thanks|of you|(?:lovely|great|nice|excellent|splendid) idea|i would|"
    r"i would (?:like|love) (?:that|it|one|some|to)|please yes|you may|oh|and|then|that|with me|"
    r"by me|it is|they are|if you (?:could|would|like|want|must)|lovely|good|robot|well|would you|,|\.|do|so|"
    r"be so kind|i think so|right then|dear|just) ?)+$"
)
NO = re.compile(
    r"^(?=.*\b(?:no|nope|not|neither|none|nothing|negative|fine|okay)\b)(?!.*\bokay$)(?:(?:no|nope|not really|"
    r"neither|none|none of them|neither of them|nothing|negative|thank you|thanks|i do not|no need|not that one|"
    r"not those|please|not now|i did not|it is okay|i am fine|it is not|do not|well|oh|,|\.|not) ?)+$"
)
_STATUS: tuple[tuple[StatusTopic, re.Pattern[str]], ...] = (
    ("finished", re.compile(r"\b(?:are you (?:\w+ )?(?:done|finished|ready|through)|have you (?:\w+ )?finished|"
                            r"is (?:it|that|everything|breakfast) (?:nearly |almost )?(?:ready|done|finished))\b")),
    ("doing", re.compile(r"\bwhat (?:are you|r u|you are|is the robot) (?:\w+ )?(?:doing|up to|carrying|bringing|"
                         r"holding|fetching|looking for|waiting for)|what is (?:going on|happening)|"
                         r"what is taking|are you (?:busy|done|finished|ready|there|bringing|fetching|getting|"
                         r"working|stuck|still|coming)|what (?:is|was) your (?:task|plan)|why (?:is|"
                         r"does) (?:it|this) tak|is it (?:nearly |almost )?(?:ready|done|finished)|"
                         r"how (?:is it|are you|are things) (?:going|coming|getting) (?:on|along)|did you (?:find|get|"
                         r"bring|finish|forget|hear)|have you (?:found|finished|got|brought)|why (?:did|are|"
                         r"do) you")),
    ("place", re.compile(r"\bwhere (?:are|r) you\b|\bwhere (?:you are|do you go|are we)")),
    ("object", re.compile(r"\bwhere(?:abouts)? (?:is|are|did|do|have|has|was|can|could|would)|which \w+ (?:are|is|"
                          r"do)")),
    ("duration", re.compile(r"\bhow (?:long|much longer|far)|when (?:will|are|do|can)")),
    ("ability", re.compile(r"\bwhat can you|who are you|what are you\b|how do you work|what do you do|"
                           r"can you help|what is your name|help$")),
    ("stock", re.compile(r"\b(?:do (?:we|you|i) have|have (?:we|you) got|is there|are there|how many|how much)\b|"
                         r"^(?:and |so |, )*(?:is|are) (?:the|my|our|all the) ")),
)  # fmt: skip


def remark(plain: str, skeleton: str) -> Interpretation | None:  # noqa: PLR0911 - one rule per return
    """What an utterance is that asks for no object; None if it is none of these.

    Args:
        plain: The normalised words with their breaks.
        skeleton: The same with things and places as `T0` and `P0`.
    """
    text = plain.strip(" .,?")
    if _CARRY_ON.fullmatch(plain):
        return _is("carry_on", "asks to go on")
    if _PUT_BACK.fullmatch(plain):
        return _is("put_back", "asks to put it back")
    if wish := _style(plain, skeleton):
        return wish
    if stated := _stated_age(text):
        return stated
    if _REPEAT.fullmatch(plain):
        return _is("repeat", "asks to say it again")
    if NO.match(text):
        return _is("deny", "says no")
    if _BACKCHANNEL.match(text) and "yes" not in text:
        return _is("backchannel", "only shows that somebody listens")
    if YES.match(text) and not _THANKS.fullmatch(text):
        return _is("affirm", "says yes")
    if _GREETING.fullmatch(skeleton.strip(" .,?")):
        topic: StatusTopic = (
            "wellbeing" if _HOW_ARE_YOU.search(plain) else "farewell" if _FAREWELL.search(plain) else ""
        )
        return Interpretation(intent="greeting", status=topic, confidence=0.9, reason="greets")
    if _THANKS.fullmatch(skeleton.strip(" .,?")):
        return _is("thanks", "thanks or praises")
    return None


def status_question(plain: str, *, names_things: bool) -> Interpretation | None:
    """A question about what the robot does, where it or something is, or what it can do."""
    for topic, pattern in _STATUS:
        if pattern.search(plain) and (names_things or not (topic == "stock" and _IS_THE.match(plain))):
            return Interpretation(intent="status", status=topic, confidence=0.85, reason=f"asks about {topic}")
    return None


def _style(plain: str, skeleton: str) -> Interpretation | None:
    wishes: tuple[tuple[StyleWish, re.Pattern[str]], ...] = (
        ("less", _LESS), ("more", _MORE), ("slower", _SLOWER), ("faster", _FASTER),
        ("louder", _LOUDER), ("quieter", _QUIETER),
    )  # fmt: skip
    # "Normal" is a size, too.
    if _NORMAL.fullmatch(plain):
        return Interpretation(
            intent="style", style="normal", confidence=0.9, reason="wants the robot to speak as usual"
        )
    if re.search(r"\b[TP]\d+\b", skeleton) or re.search(r"\b(?:he|she|they|him|her|story|time|weather|joke)\b", plain):
        return None
    for wish, pattern in wishes:
        if pattern.search(plain):
            return Interpretation(intent="style", style=wish, confidence=0.9, reason=f"wants the robot to speak {wish}")
    return None


def _stated_age(text: str) -> Interpretation | None:
    if match := _AGE.search(text):
        age = int(match[1]) if match[1].isdigit() else (_NUMBERS | _DECADES)[match[1]]
        possible = 5 <= age <= 120
        return (
            Interpretation(intent="stated_age", age=age, confidence=0.9, reason="states an age") if possible else None
        )
    if match := _OLD.search(text):
        old = match[1] in {"old", "older", "elderly", "senior", "pensioner", "retired"}
        band: Band = "older" if old else "younger"
        return Interpretation(intent="stated_age", band=band, confidence=0.9, reason="states an age in words")
    return None


def _is(intent: Intent, reason: str) -> Interpretation:
    return Interpretation(intent=intent, confidence=0.9, reason=reason)
