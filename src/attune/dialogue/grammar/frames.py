"""The ways in which people ask, as patterns over an utterance's skeleton.

In a skeleton each noun phrase is `T0`, `T1`, ... and each place `P0`, `P1`, ...; all else are plain words and the
breaks "," "." "?". "could you bring me T0 P0 , please ?"
"""

import re

from attune.dialogue.words import words

T = r"T\d+"
P = r"P\d+"
PRONOUN = (
    r"(?:it|that|this|them|those|these|everything|all|all of it|all of them|the lot|both|the things|my things|stuff)"
)

SOFTENER = (
    r"(?:please|just|also|maybe|possibly|kindly|perhaps|quickly|then|now|ever|really|actually|simply|at least|at all|"
    r"be able to|manage to|be so \w+(?: \w+)? (?:and|as to|to|,)|be (?:kind|good|nice) enough to|"
    r"be an? \w+(?: and| to| ,)?|"
    r"do me (?:a|the) \w+(?: and|,)?|go ahead and|like to|try to|try and|see your way to|help me(?: to| and| by)?|"
    r"mind|"
    r"think (?:that )?you (?:could|can|might)|first|next|go(?: over| back| there| quickly)?(?: and)?|come(?: and)?|"
    r"run(?: and)?|walk(?: over)?(?: and)?|drive(?: over)?(?: and)?|all|too|for me|again|instead|very kindly|,|and|"
    r"if (?:it is )?(?:possible|you can|you could|you would|you do not mind|not too much trouble)|possible|"
    r"hurry up and|"
    r"turn around and|in that case|as well|quick|dear|love|mate|robot|by any chance|perchance|at some point|"
    r"next time)"
)
_YOU = (
    r"(?:(?:can|could|would|will|wo|might|may|ca) (?:not )?(?:you|u|ya|somebody|someone|anybody|anyone)(?: to)?|"
    r"(?:do|would) (?:not )?you (?:think (?:that )?you (?:could|can|might|would)|mind|like to|want to|happen to|"
    r"possibly)|"
    r"you (?:can|could|might|may|should|must|have to|need to|ought to|may as well|might want to|are to|better)|"
    r"(?:i|we) (?:\w+ )?(?:would like|want|need|would love|would prefer|wanted|require|expect|ask|order|beg|urge|"
    r"command) "
    r"(?:\w+ )?you to|"
    r"(?:i|we) (?:was|am|were|are|had been|have been)? ?(?:just |really |kind of |sort of )*(?:wonder\w*|hop\w*|"
    r"think\w*|"
    r"going to ask)(?: that| if| whether| maybe| perhaps)* you (?:could|might|can|would|will|may)|"
    r"(?:i|we) (?:would be|would really be|am|was) (?:\w+ )?(?:grateful|thankful|happy|glad|delighted|pleased|"
    r"obliged) "
    r"if you (?:could|would|can|might)|"
    r"(?:i|we) would (?:\w+ )?(?:appreciate|love|like) it if you (?:could|would|can)|"
    r"if (?:only )?you (?:could|would|can|might|will)|"
    r"is it possible (?:for you )?to|is there any (?:chance|way|possibility) (?:that )?(?:for )?you (?:could|can|"
    r"to|might)|"
    r"any (?:chance|way) (?:that )?you (?:could|can|might|to|would)|"
    r"would it be (?:possible|okay|alright|all right|too much\w*(?: to ask| trouble)?)(?: for you)? (?:to|"
    r"if you could|if you)|"
    r"would it (?:\w+ )*trouble you (?:\w+ )?to|(?:may|can|could|might) (?:i|we) (?:\w+ )?(?:ask|trouble|beg|get|"
    r"have|bother) "
    r"you (?:to)?|why (?:do|can|will|wo|ca) not you|make sure (?:to|you|that you)|remember to|do not forget to|"
    r"feel free to|"
    r"i (?:said|say|told you to|asked you to|repeat)|how about (?:if )?you|what if you|time to|"
    r"(?:is|would) it (?:be )?(?:okay|alright|all right|possible|fine|too much) (?:if|for) you(?: (?:to|could|"
    r"would|can))?|"
    r"it would be \w+ (?:if you (?:could|would)|for you to)|that you (?:could|can|would)|you (?:will|"
    r"would) (?:please|now)|"
    r"(?:can|could|shall|may|might) we|let us|"
    r"be (?:so )?(?:kind|good|nice|sweet|lovely|dear) (?:and|to|as to|enough to)|be an? \w+(?: and| ,)|"
    r"do me (?:a|the) \w+(?: and|,)?|i will need you to|i am going to need you to|let us have you|are you able to|"
    r"it is your turn to|your (?:task|job) is to|please to|i insist that you|next you)"
)
FRAME = re.compile(rf"(?:^|(?<= ))(?:{_YOU}|please|kindly|better|best)(?: {SOFTENER})*$")
"""An explicit request to "you", directly before its verb."""

GERUND_FRAME = re.compile(
    r"(?:mind|about|by|appreciate|consider|trouble|chance of|possibility of|thinking of|bother|help me by)"
    r"(?: you| your)?(?: please| just| maybe| also| quickly| perhaps| terribly)*$"
)
PAST_FRAME = re.compile(r"(?:if|rather|wish|time|glad if|sooner) you(?: just| maybe| please| kindly| quickly)*$")

_ADVERB = (
    r"(?:really|also|still|just|now|then|actually|only|maybe|probably|so|definitely|desperately|do|kind of|sort of|"
    r"quite|certainly|always|indeed|badly|urgently|currently|simply|totally|very much|much|think i|believe i|guess i|"
    r"suppose i|might|will|am going to|do really|instead|rather|please|thought i|would say i|even|absolutely|"
    r"was hoping to|was thinking i|too)"
)
_WANT = (
    r"(?:wants?|am wanting|am needing|wish i had|need|"
    r"(?:would|should)(?: very much| really| dearly| quite| so)* (?:like|love)|"
    r"would like|would love|would prefer|prefer|require|fancy|crave|desire|wish for|wish|could use|"
    r"could do with|would appreciate|could really use|could really do with|am after|am looking for|am searching for|"
    r"feel like|am in need of|am dying for|will have|will take|would take|would have|must have|had like|"
    r"would rather have|would rather like|would rather take|would kill for|could murder|could go for|would go for|"
    r"will need|would need|am going to need|was hoping for|was after|am hoping for|wanted|would want|"
    r"would be (?:very |so |really )?(?:grateful|thankful|glad|happy|delighted|pleased) (?:for|with|about|to have|"
    r"to get)|"
    r"could handle|may need|might need|might want|shall have|shall need|are in need of|are after|are looking for|"
    r"would rather|would sooner have|wouldn't mind|would not mind|would not say no to|like|"
    r"(?:would|should|could|might|do|did)(?: very much| really| quite| rather| so| sure| surely| certainly)* "
    r"(?:fancy|enjoy|welcome|want|need|prefer|use|do with|mean|ask for|say|order)|"
    r"(?:will|shall|am going to) be (?:wanting|needing|having)|am going to (?:want|have)|"
    r"have (?:got )?a (?:\w+ )?(?:mind|craving|hankering|longing|taste|fancy|yen) for|"
    r"meant|said|asked for|ordered|had asked for|was asking for|had ordered)"
)
_TO_HAVE = (
    r"(?: (?:to|please to) (?:please |also |just )?(?:have|get|eat|drink|use|try|order|be given|take|enjoy|borrow|"
    r"receive|"
    r"having|getting|ask for|ask you for|request|read|wear|play with|put on|write with|look at|"
    r"listen to|finish|try on|sit on|"
    r"see|start with|hold|drink from|eat from|get hold of|be brought)| having| getting)?"
)
_GAP = (
    r"(?: (?:me|us|please|also|just|maybe|perhaps|some of|you to have|now|really|like|uh|you know|say|well|actually|"
    r"only|,|back))*"
)
WISH = re.compile(
    rf"\b(?:(?:i|we|me|id) (?:{_ADVERB} )*{_WANT}(?: {_ADVERB})*{_TO_HAVE}"
    r"|(?:can|could|may|might|shall) (?:i|we)(?: please| also| possibly| maybe| just| perhaps| kindly|"
    r" by any chance| now| then)*"
    r" (?:have|get|grab|take|borrow|trouble you for|bother you for|ask(?: you)? for|be given|get hold of|receive|"
    r"see|use)"
    r"|(?:think|if|whether|mind if|that|hoping|maybe|perhaps|wondering) (?:i|we) (?:could|can|might|may|"
    r"would)(?: please| also| just| only| possibly| maybe)*"
    r" (?:have|get|grab|take|borrow|ask for|trouble you for|bother you for)"
    r"|let (?:me|us)(?: please| just| all)? (?:have|get|go for|take|use)"
    r"|(?:is|would|was) there (?:be )?(?:any|a|some) (?:chance|possibility|way)(?: of| for| that| to| i| we)*"
    r"(?: could| can| might| may)?(?: have| get| having| getting)?"
    r"|any (?:chance|possibility|hope)(?: of| for| i| we)*(?: could| can| might)?(?: have| get| having| getting)?"
    r"|(?:how|what) about(?: having| getting)?"
    r"|what (?:i|we)(?: really| actually| now)? (?:need|want|would like|would love|was after|am after)(?: now)? is"
    r"|all (?:i|we) (?:need|want) is"
    r"|(?:would it be|is it)(?: \w+)? possible (?:for (?:me|us) )?to (?:have|get|see)"
    r"|(?:it|that) would be \w+ (?:to (?:have|get)|with)|would be \w+ to (?:have|get)"
    r"|(?:my|our) (?!T\d)\w+ (?:needs|would like|would love|wants|also needs|still needs|need)"
    r"|do you have|have you got|have you|do not forget|remember|you (?:have )?(?:forgot|forgotten)"
    rf")(?={_GAP} T\d)"
)
LACK = re.compile(
    r"\b(?:i|we) (?:still |also |just )?(?:do not have|have no|have not got|am missing|are missing|am short of|"
    r"are short of|"
    r"am lacking)(?= (?:any |enough )?T\d)"
)
TERSE_WISH = re.compile(
    r"(?:^|(?<=[.,?] )|(?<=and )|(?<=please )|(?<=robot ))(?:want|need|wanting|needing|would like)"
    r"(?: to (?:have|get|eat|drink|use))?(?= T\d)"
)
PRAISE = re.compile(
    rf"({T}(?: (?:and|,|or) {T})*(?: {P})?)(?: too| also| as well)? (?:would|will|might|should)(?: really| also)? "
    r"(?:be (?:\w+ )?(?:nicer|preferable|nice|great|lovely|good|perfect|wonderful|fine|brilliant|fantastic|super|"
    r"handy|useful|"
    r"excellent|"
    r"amazing|appreciated|ideal|better|best|welcome|helpful|marvellous|cool|grand|needed|awesome|enough)|"
    r"do(?: nicely| fine)?|"
    r"hit the spot|help|go down (?:well|nicely|a treat)|come in handy|make me happy)\b"
)
NEEDED = re.compile(rf"({T}(?: (?:and|,) {T})*) (?:is|are) (?:also |still )?(?:needed|required|wanted|missing)\b")
POINTING_WISH = re.compile(
    r"\b(?:(?:can|could|may|might) i (?:please )?(?:have|get|take)|i (?:\w+ )?(?:want|would like|would love|need|"
    r"will take|will have|"
    r"would take)(?: to have)?|give me|i would like to have) (?:that(?: one)?|it|this(?: one)?|them|those)\b(?! to\b)"
)
FOR_ME = re.compile(rf"^(?:do you have|have you got|have you) ?.*{T}.* for (?:me|us)\b")

QUESTION = re.compile(
    r"^(?:and |but |so |well |okay |oh |hey |now |, |robot )*(?:what|where|who|whose|whom|when|how|which|why|did|"
    r"does|has|had|"
    r"was|were|is|are|am|do (?:we|they|i|you)|have (?:you|we|they|i)|should (?:i|we)|shall (?:i|we)|would (?:he|"
    r"she|they|it)|"
    r"could (?:he|she|they)|can (?:he|she|they)|will (?:he|she|they|it))\b"
)
PAST = re.compile(
    r"\b(?:yesterday|last (?:week|night|month|year|time|summer|winter|monday|sunday|friday|saturday)|ago|used to|"
    r"when (?:i|we) (?:was|were)|every (?:day|morning|week|time|evening)|always|usually|once upon|tomorrow|next week|"
    r"the other day|back then|in (?:the old|those|the good old|olden) days|in my (?:day|youth|time)|"
    r"this morning|never)\b"
)
NEVER_BEFORE_VERB = words(
    "i he she we they it who someone somebody everyone people nobody to not never do does did will would can could "
    "should must may might shall always often usually sometimes us him her them let me the a an my his "
    "our your their this that these those some of in on at for with from by is are was were be been being "
    "had has have help helped"
    "made make told asked said which what how when where if than as because about into just's one's us' s"
)
ADDITIVE = re.compile(
    r"\b(?:too(?! T\d| \w+ing|\b \w+ ,)(?! much)|(?:need|want|like|have|bring|me) too(?= T\d)|as well|"
    r"also|another|one more|two more|more|in addition|"
    r"additionally|on top of that|extra|besides|"
    r"plus|"
    r"while you are (?:at it|there|up|about it)|at the same time|along with|together with|aswell|additional)\b|"
    r"^(?:oh |, )*and\b"
)
CORRECTION = re.compile(
    r"\b(?:instead|rather|prefer|wrong|i mean|i meant|i said|i wanted|i asked for|i was asking for|i had asked for|"
    r"i did ask for|make (?:it|that)|(?:change|switch|swap)(?: over| it| that)? (?:to|for|into|with)|"
    r"change of plans?|changed? my mind|"
    r"different|nicer|preferable|too T\d+|"
    r"on second thoughts?|actually|better|after all|not what i|misunderst\w+|mistake|not that one|not this one|"
    r"not that|"
    r"turn it into|(?:swap|exchange|replace|switch|trade) (?:it|that|this|them)|what i meant|i ordered|"
    r"supposed to be|correction|"
    r"i told you)\b|^(?:oh |ah |hey |, |robot |okay |wait |sorry |stop |hold on )*(?:no|nope|not)\b"
)

_ASIDE = re.compile(
    r"(?: ?,)? ?\b(?:if (?:it is |that is )?(?:not )?too (?:much|big a) (?:of a )?(?:trouble|bother|hassle|"
    r"problem|ask)|"
    r"if you (?:do not|would not) mind|if (?:it is |that is |at all )?(?:possible|okay|all right|"
    r"alright)(?: for you)?|"
    r"when(?:ever)? you (?:have|get|find|can spare) (?:a |the |some )?(?:moment|minute|second|time|chance|sec)|"
    r"when(?:ever)? you (?:can|are (?:ready|free|done|finished)|like)|as soon as (?:possible|you can)|"
    r"if you (?:can|could|would|"
    r"will|please|like|want|may|have time|get a chance|have a (?:moment|minute|second))(?= *(?:[.,?]|$))|"
    r"if i may(?: ask)?|i (?:nearly |almost |just )?forgot(?= *(?:[.,?]|$))|"
    r"if you (?:would|could) be so kind|would you(?: please| kindly)?(?= *(?:[.?]|$))|"
    r"could you(?: please)?(?= *(?:[.?]|$))|"
    r"excuse me|you know(?: what)?|let me think|let me see|i suppose|i guess|if i remember (?:right|correctly)|"
    r"by the way|(?:just )?one (?:more|last|other) thing|another thing|something else|"
    r"(?:just |only )?(?:two|three|four|five|six) (?:more )?things(?= ,)|"
    r"to be honest|at your convenience|no rush|no hurry|there is no rush|that would be (?:\w+ )?(?:great|nice|"
    r"lovely|kind|"
    r"wonderful|perfect|good|fantastic|helpful)|that is (?:very )?(?:kind|nice|sweet) of you|many thanks|"
    r"thank you(?: so much| "
    r"very much| kindly)?|thanks(?: a lot| so much| a million| in advance)?|in a (?:moment|minute|bit|while|"
    r"second)|right away|"
    r"straight away|right now|right this minute|for (?:breakfast|lunch|dinner|supper|tea)(?= *(?:[.,?]|$|please))|"
    r"for (?:me|us)|hold on|hang on|wait(?: a (?:minute|moment|second|sec))?|hold it|one moment|just a (?:minute|"
    r"moment|second)|"
    r"would that be (?:okay|possible|all right|alright)|is that (?:okay|possible|all right|alright)|good morning|"
    r"good evening|good afternoon|silly me|dear me|oh dear|(?:my )?goodness(?: me| gracious)?|"
    r"bless (?:you|me|your heart)|"
    r"mind you)\b"
)


_TAG = re.compile(
    r"(?: ,|(?<=[TP]\d)) (?:did|do|does|is|are|was|were|have|has|had|will|would|could|can|should) (?:not )?"
    r"(?:i|you|it|we|they|there|he|she)(?: not)?(?: please| now)?(?= *(?:[.?,]|$))"
)


_INSTEAD_FIRST = re.compile(r"\binstead (?=T\d+(?: ,)?(?: \w+){0,2} T\d)")


_HAVE_ONE_ALREADY = re.compile(
    r"\b((?:never ?mind|forget|skip|cancel|leave|do not (?:need|want|bring|bother with))(?: about)? T\d+"
    r"(?: any ?more)?) ,? ?(?:because |since |as )?(?:i|we) (?:already )?(?:have|got|found)(?: already)?"
    r"(?: got| found)? (?:T\d+|one|mine)(?: already| here| now| myself)*(?= *(?:[.,?]|$))"
)
"""Why something is not wanted any more names it again: "never mind the spoon, I've got one"."""


def without_asides(text: str) -> str:
    """A skeleton without courtesies, tag questions and other asides, which say nothing about what is wanted."""
    text = _TAG.sub(" ", f"{text} ")
    text = _INSTEAD_FIRST.sub("instead of ", text)
    text = _HAVE_ONE_ALREADY.sub(r"\1", text)
    return " ".join(_ASIDE.sub(" ,", f"{text} ").split()).strip(" ,")
