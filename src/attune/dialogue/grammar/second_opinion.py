"""Weighs what the rules found against the command model, which has learnt from some thousand sentences."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar import frames
from attune.dialogue.grammar.clauses import ClauseCutter, Sentence
from attune.dialogue.grammar.command_model import COMMANDS, load_command_model
from attune.dialogue.grammar.corrections import settle
from attune.dialogue.grammar.second_reading import SecondReading
from attune.dialogue.grammar.stopping import without_denied_stops
from attune.dialogue.interpreter import Interpretation
from attune.dialogue.lexicon import Lexicon

INSTRUCTIONS = frozenset({"bring_me", "replace_object", "change_location", "setting_breakfast"})
CERTAIN = frozenset(
    {
        "stop",
        "thanks",
        "greeting",
        "backchannel",
        "style",
        "stated_age",
        "repeat",
        "dont_stop",
        "carry_on",
        "put_back",
        "deny",
    }
)
"""What the rules are not contradicted in."""
NOTHING_FOUND = frozenset({"talk", "question", "fragment", "unknown_action", "unknown_object", "unclear"})
SOMEBODY_CALLED = 0.85
"""The rules' confidence that somebody else is spoken to, when they say so by a name."""

# How much likelier a command is when the rules found it; measured by cross-validation on unseen sentences.
_TRUST_IN_BRING_ME = math.exp(1.5)
_TRUST_IN_OTHERS = math.exp(2)
_TRUST_IN_A_CONTRAST = math.exp(4)
_TRUST_IN_NOTHING = math.exp(1.5)
_MISSING_A_STOP_IS_WORSE = 1.5
_LIKELY = 0.4
_LIKELIER_THAN_NOT = 0.5
_SURE = 0.9
_EXPLAINS = re.compile(r"\b(?:i|we) have (?:already )?(?:found|got) T\d+$")
_ABOUT_MEMORY = re.compile(r"\b(?:forget|remember|erase|delete) (?:about )?(?:me|my name|who i am|everything about)\b")


class SecondOpinion:
    """Judges whole sentences where the rules judge words.

    Args:
        cutter: Cuts sentences into clauses.
    """

    def __init__(self, cutter: ClauseCutter) -> None:
        self._cutter = cutter
        self._model = load_command_model()

    def weighed(
        self, meaning: Interpretation, sentence: Sentence, context: Context, lexicon: Lexicon,
        said: Sequence[ObjectSpec],
    ) -> Interpretation:  # fmt: skip
        """What the rules found, or what the model makes of it when it is much surer.

        Args:
            meaning: What the rules found.
            sentence: The whole utterance.
            context: The situation.
            lexicon: The words of this situation.
            said: What the robot spoke of last.
        """
        if _ABOUT_MEMORY.search(sentence.skeleton):
            return meaning
        found = meaning.intent if meaning.intent in COMMANDS else "other"
        judged = self._model.judge(sentence, context, lexicon)
        trust = _trust(meaning)
        command = max(COMMANDS, key=lambda name: judged[name] * (trust if name == found else 1.0))
        if found == "other" and judged["stop"] > max(judged[command] / _MISSING_A_STOP_IS_WORSE, _LIKELY):
            command = "stop"
        if command == found or (meaning.intent == "cancel_object" and command not in _MORE_THAN_CANCELLING):
            return meaning
        text = without_denied_stops(sentence.skeleton)[0]
        settled, text, _ = settle(sentence, frames.without_asides(text))
        reading = SecondReading(text, settled, context, lexicon, said)
        return reading.read_as(command, self._cutter, judged[command]) or meaning

    def is_no_request(self, after: str, sentence: Sentence, context: Context, lexicon: Lexicon) -> bool:
        """Whether what follows a stop only explains it, as far as the model is sure."""
        if _EXPLAINS.search(after):
            return True
        return self._model.judge(replace(sentence, skeleton=after), context, lexicon)["other"] > _LIKELIER_THAN_NOT

    def instruction(
        self, after: str, sentence: Sentence, context: Context, lexicon: Lexicon, said: Sequence[ObjectSpec]
    ) -> Interpretation | None:
        """The instruction that follows a stop, where the model is sure that there is one."""
        judged = self._model.judge(replace(sentence, skeleton=after), context, lexicon)
        command = max(COMMANDS, key=lambda name: judged[name])
        if command not in INSTRUCTIONS or judged[command] < _SURE:
            return None
        settled, text, _ = settle(sentence, frames.without_asides(after))
        return SecondReading(text, settled, context, lexicon, said).read_as(command, self._cutter, judged[command])


_MORE_THAN_CANCELLING = frozenset({"replace_object", "setting_breakfast"})


def _trust(meaning: Interpretation) -> float:
    if meaning.intent in NOTHING_FOUND and meaning.confidence < SOMEBODY_CALLED:
        return _TRUST_IN_NOTHING
    if meaning.intent == "replace_object":
        return _TRUST_IN_A_CONTRAST
    return _TRUST_IN_BRING_ME if meaning.intent == "bring_me" else _TRUST_IN_OTHERS
