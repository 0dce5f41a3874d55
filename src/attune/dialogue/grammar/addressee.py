"""Who is spoken to: the robot, or somebody else in the room."""

import re
from collections.abc import Sequence

from attune.dialogue.grammar.clauses import Called
from attune.dialogue.grammar.tokens import Token
from attune.dialogue.lexicon import Lexicon
from attune.dialogue.words import words

_OPENERS = words(
    "hey hi hello oh yes no okay well so please listen thanks now look excuse me dear good morning and but right sorry "
    "omg god ach och oi aww lol"
)
_TO_YOU = words(
    "can could would will did do does have has are is was were where what when why how who you please "
    "shall should may i we give pass bring get fetch hand put take come go stop wait look listen the this "
    "that it there let"
)
_KNOWN_OPENERS = words(
    "please hello hey hi okay so well actually listen look sorry right alright yes no thanks thank now "
    "also then oh morning evening wait stop robot anyway additionally finally next first instead however "
    "quick quickly hurry honestly great perfect good cool fine lovely nice excellent wonderful brilliant "
    "wow gosh god jesus damn ah change plan breakfast not never one two freeze halt pause enough nope yep "
    "exactly correct rather maybe perhaps again another more later today anyhow basically seriously sure "
    "certainly absolutely definitely oops whoops pardon excuse hmm welcome goodbye bye sir still yet "
    "besides furthermore moreover alternatively otherwise afterwards meanwhile secondly lastly second "
    "third yo dude lovely sounds hmm say ahh super duper alas finally eventually ideally quietly "
    "slowly gently carefully immediately fast hopefully possibly kindly gosh golly crikey blimey "
    "darn drat ouch yikes yay yeah "
    "obviously clearly naturally surprise help everything nothing something anything nobody now then beautiful "
    "what who whom whose which where how why neither either none both all any some each every much many most few "
    "only even too very such he she they me him her them us myself yourself next earlier hopefully "
    "maybe would could can will shall should kindly peas plea least leased roberts robo bot droid hallo cheers "
    "alrighty righto righty um like literally straight wonder hopefully essentially simply furthermore plus "
    "yesterday tonight tomorrow whenever wherever whoever whatever anyways anyhow regardless nonetheless "
    "don't not never ever always often usually sometimes go come run walk drive turn open close start stop begin try "
    "look see hear feel think know mean say tell ask let make do have be use need want like love hate prefer forget "
    "remember replace swap exchange switch change cancel return remove add clear clean wash fill pour cut move leave "
    "drop set lay place store keep hold carry deliver serve prepare cook bake wait halt freeze pause continue resume "
    "proceed repeat speak talk "
    "to of in on at by for with from up down out off over under about into onto as than because "
    "just better might must may whoa huh ha haha hiya psst aha real ready omg lol afterwards whether "
    "gonnae gonna gotta wanna lemme honest luckily meantime apparently except unless though although thankfully "
    "soon ta "
    "oi oy ey somebody someone anybody anyone och ach oui si chef "
    "third here there this that it you i we see fantastic super awesome correction wrong mistake "
    "apologies hungry thirsty tired careful easy slower faster louder quieter and but or if when while "
    "since because as after before until once fetch bring get"
)
_AUX = words("can could would will did do have are")
_ORDERS = words("bring get fetch pass hand give put take grab leave find set lay make")
_MODALS = words("can could would will")
_ORDERS_TO_HAND = words("bring get fetch pass hand give put take grab")
_AFTER_ORDER = words("me us the that those these this your my our it them a some him her")
_POLITE = words("sir madam")
_SEVERAL = re.compile(r" you (?:lot|guys|boys|girls|kids|lads|pair|little ones|T\d+(?= *(?:$|[,.])))")
"""Who is told to stop is no robot: "cut it out, you two"."""
_NAMES_THAT_ARE_WORDS = words("will may mark grace hope rose sue pat bill art gene rob summer dawn joy people")
_TWO_NAMES = 2
_THIRD_PERSON = re.compile(
    r"^(?:needs|wants|would like|likes|is|has|was|said|says|asked|told|and|also|or|had|dropped|broke)\b"
)


_TELLS_WHAT_SOMEBODY_SAYS = re.compile(
    r"^(?:(?!(?:i|we|you|robot|please)\b)[\w']+ ){1,5}?(?:said|says|would say|roared|whispered|shouted|yelled|cried|"
    r"goes|told (?:me|him|her|us|them)) (?:, |to |that )?(?:please )?(?:bring|fetch|get|give|pass|put|hand|take)\b"
)
_REPORTS = re.compile(
    r"^(?!.* you (?:should|must|have to|need to|ought to|can|may) (?:stop|wait|halt|pause)\b)"
    r"(?:(?:and|so|but|then|well|the|my|our|his|her) )*(?!i |we |you |please |robot )\w+ (?:then |just )?(?:said|says|"
    r"whispered|shouted|yelled|replied|cried|screamed|sang|was like|is like) (?:, )?(?=\w+ )"
)


def is_for_someone_else(tokens: Sequence[Token], lexicon: Lexicon) -> bool:  # noqa: PLR0911 - one rule per return
    """Whether somebody else is called by name at the beginning or the end."""
    words = [token.text for token in tokens]
    if any(word == "robot" and words[at - 1 : at] in ([], [","], ["."]) for at, word in enumerate(words)):
        return False
    others = lexicon.others
    at = 0
    while at < len(words) and (words[at] in _OPENERS or words[at] == ","):
        at += 1
    if at < len(words) and words[at] in others and words[at] not in _POLITE:
        rest = words[at + 1 :]
        if not rest or rest[0] in {",", ".", "?"} or words[at : at + 2] == ["guys"]:
            return True
        if rest[0] in _TO_YOU and not _THIRD_PERSON.match(" ".join(rest)):
            # "anna is here" speaks about her, "anna did you ..." to her; neither is for the robot.
            return True
    if (
        _names_somebody_in_between(words, lexicon)
        or _calls_a_stranger(tokens, words, at, lexicon)
        or _REPORTS.match(" ".join(words))
    ):
        return True
    if _TELLS_WHAT_SOMEBODY_SAYS.match(" ".join(words)):
        return True
    end = len(words)
    while end and words[end - 1] in {".", "?", "please", "thanks"}:
        end -= 1
    if end < 3 or words[end - 2] not in {",", "you"} or words[end - 1] not in others or words[end - 1] in _POLITE:
        return False
    # "Leave it be, sweetheart" may be for the robot, but not "you take the fork, sweetie".
    return words[0] == "you" or words[end - 1] not in lexicon.robot


def is_told_to_another(text: str, end: int, tokens: Sequence[Token], lexicon: Lexicon) -> bool:
    """Whether a name follows an order to stop: "stop it, Tobi".

    Args:
        text: The skeleton.
        end: Where the order ends in it.
        tokens: The utterance; a capital within a sentence makes a name.
        lexicon: The words of this situation.
    """
    told = text.find(" you", max(end - len(" you"), 0), end + len(" , you"))  # It may belong to the order.
    if told >= 0 and _SEVERAL.match(text, told):
        return True
    called = re.match(r" (\w+)\b", text[end:].removeprefix(" ,"))
    if called is None or called[1] in lexicon.robot:
        return False
    capitals = {token.text for token in tokens if token.capital} - {"i"}
    if called[1] in capitals and len(capitals) < len(tokens) // 2:
        return True
    after_comma = text[:end].endswith(",") or text[end:].startswith(" ,")
    return called[1] in lexicon.others - (frozenset() if after_comma else _NAMES_THAT_ARE_WORDS)


def who_is_called(tokens: Sequence[Token], lexicon: Lexicon, *, left_out: int) -> Called:
    """Who is called, by a name anywhere in the utterance.

    Args:
        tokens: The whole utterance.
        lexicon: The words of this situation.
        left_out: How many of its words were a name of the robot at its beginning or end.
    """
    words = [token.text for token in tokens]
    for at, word in enumerate(words):
        if word in _ROBOTS and (at == 0 or words[at - 1] not in _BEFORE_WHAT_IS_SPOKEN_OF):
            return "robot"
    if is_for_someone_else(tokens, lexicon):
        return "else"
    return "dear" if left_out else ""


_ROBOTS = words("robot robbie attune robo bot")
_BEFORE_WHAT_IS_SPOKEN_OF = words(
    "the a an this that my your our his her their of with to for kitchen new toy every which any no some one little"
)


def _names_somebody_in_between(words: Sequence[str], lexicon: Lexicon) -> bool:
    """Whether a name stands between commas: "a bigger plate, Steve, this one is silly". A stop is never lost to it."""
    return "stop" not in words and any(
        word in lexicon.names and before == "," and after in {",", "."}
        for before, word, after in zip(words, words[1:], words[2:], strict=False)
    )


def _calls_a_stranger(tokens: Sequence[Token], words: Sequence[str], at: int, lexicon: Lexicon) -> bool:
    """Whether a request begins with a word or two that nobody says to the robot: "Mary Lou, pass ..."."""

    def is_stranger(word: str) -> bool:
        known = word in _KNOWN_OPENERS or word in _OPENERS or word in lexicon.robot or lexicon.knows(word)
        return word.isalpha() and not known

    comma = words.index(",", at, at + 3) if "," in words[at : at + 3] else 0
    called = words[at:comma] if comma > at else words[at : at + 1]
    if not called or not all(is_stranger(word) for word in called):
        return False
    if len(called) == _TWO_NAMES and not tokens[at + 1].capital:
        return False
    rest = words[comma + 1 :] if comma > at else words[at + 1 :]
    if len(rest) > 1 and rest[0] in (_AUX if comma > at else _MODALS) and rest[1] == "you":
        return True
    order = rest[1:] if rest[:1] == ["please"] else rest
    if comma > at:
        return len(order) > 0 and order[0] in _ORDERS
    return len(order) > 1 and order[0] in _ORDERS_TO_HAND and order[1] in _AFTER_ORDER
