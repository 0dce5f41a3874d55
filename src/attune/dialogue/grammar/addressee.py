"""Who is spoken to: the robot, or somebody else in the room."""

import re
from collections.abc import Sequence

from attune.dialogue.grammar.tokens import Token
from attune.dialogue.lexicon import Lexicon
from attune.dialogue.words import words

_OPENERS = words(
    "hey hi hello oh yes no okay well so please listen thanks now look excuse me dear good morning and but right sorry"
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
    "third here there this that it you i we see fantastic super awesome correction wrong mistake "
    "apologies hungry thirsty tired careful easy slower faster louder quieter and but or if when while "
    "since because as after before until once fetch bring get"
)
_AUX = words("can could would will did do have are")
_THIRD_PERSON = re.compile(
    r"^(?:needs|wants|would like|likes|is|has|was|said|says|asked|told|and|also|or|had|dropped|broke)\b"
)


def is_for_someone_else(tokens: Sequence[Token], lexicon: Lexicon) -> bool:
    """Whether somebody else is called by name at the beginning or the end."""
    words = [token.text for token in tokens]
    others = lexicon.people | lexicon.names
    at = 0
    while at < len(words) and (words[at] in _OPENERS or words[at] == ","):
        at += 1
    if at < len(words) and words[at] in others:
        rest = words[at + 1 :]
        if not rest or rest[0] in {",", ".", "?"} or words[at : at + 2] == ["guys"]:
            return True
        if rest[0] in _TO_YOU and not _THIRD_PERSON.match(" ".join(rest)):
            # "anna is here" speaks about her, "anna did you ..." to her; neither is for the robot.
            return True
    if (
        len(words) > 3
        and words[1] == ","
        and words[2] in _AUX
        and words[3] == "you"
        and words[0] not in _KNOWN_OPENERS | lexicon.robot
    ):
        return lexicon.phrases.get((words[0],)) is None
    end = len(words)
    while end and words[end - 1] in {".", "?", "please", "thanks"}:
        end -= 1
    called = lexicon.names | (lexicon.people - {"sir", "madam"})
    return end >= 3 and words[end - 1] in called and words[end - 2] in {",", "you"}
