"""Weighs what the rules found against the command model, which has learnt from some thousand sentences."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar.clauses import ClauseCutter, Sentence
from attune.dialogue.grammar.command_judge import CommandJudge, load_command_judge
from attune.dialogue.grammar.command_model import COMMANDS
from attune.dialogue.grammar.destinations import settled_with_roles
from attune.dialogue.grammar.moves import NAMED
from attune.dialogue.grammar.second_reading import SecondReading
from attune.dialogue.grammar.stopping import is_no_stop, without_denied_stops
from attune.dialogue.interpreter import CommandIntent, Interpretation
from attune.dialogue.lexicon import Lexicon

INSTRUCTIONS = frozenset({"bring_me", "replace_object", "change_location", "setting_breakfast"})
CERTAIN = frozenset(
    {"thanks", "greeting", "backchannel", "style", "stated_age", "repeat", "dont_stop", "carry_on", "put_back", "deny"}
)
"""What the rules are not contradicted in."""
NOTHING_FOUND = frozenset({"talk", "question", "fragment", "unknown_action", "unknown_object", "unclear"})
SOMEBODY_CALLED = 0.85
"""The rules' confidence that somebody else is spoken to, when they say so by a name."""


@dataclass(frozen=True, slots=True)
class Limits:
    """How much likelier no command has to be than the one that the rules found, as logarithms of odds.

    Chosen on sentences that neither the rules nor the model had seen (`scripts/check_command_models.py` makes
    such models), so that few commands are lost: a question costs a person a word, a false movement more.

    Attributes:
        ask: From here on the robot asks before it acts.
        ignore: From here on it takes the words for talk.
    """

    ask: float
    ignore: float


_LIMITS = {
    "bring_me": Limits(0.5, 2.5), "setting_breakfast": Limits(0.5, 2.5), "change_location": Limits(0.5, 2.5),
    "replace_object": Limits(1.0, 3.0),
}  # fmt: skip
_STOPS = Limits(1.5, 1.5)
"""A stop is no question: it is one or not."""
_ANSWERS = Limits(2.0, 3.0)
_CANCELLED_FOR_NOTHING = 1.5
"""From here on who says "not that knife" only talks, where leaving the knife out would be the end of the task."""
_CALLED, _FRAMED, _POINTS, _NAMED = 1.5, 0.8, 0.5, 1.5
"""So much later is doubted who calls the robot, who asks "could you ...", who points at what the robot is about, who
names it and says where it shall go."""
_STOP_SHORT, _STOP_TOLD = 4.0, 2.0
"""And so much later a stop of a few words, and one that the robot is told by its name or by "you"."""
_EXPRESSLY = 0.95
"""The rules' confidence in a request to "you"."""
_ANOTHER_COMMAND = {"bring_me": 2.0, "replace_object": 7.0}
"""How much likelier another command has to be; less for what people mix up."""
_ANOTHER_THAN_THE_REST = 2.5
_NONE_FOUND = 1.2
"""How much likelier a command has to be than none, where the rules found none."""
_SOMEBODY_ELSE_CALLED = 3.0
_A_STOP = {True: 0.3, False: -0.2}
"""The same for a stop, of a robot that is at work or not: one that has nothing to do loses nothing by stopping."""
_STOP_OF_ANOTHER = 1.5
"""And so much more, where somebody else is called."""
_LIKELIER_THAN_NOT = 0.5
_SURE = 0.9
_SHORT = 4
"""An answer of so few words is never doubted, and such a stop seldom."""
_EXPLAINS = re.compile(r"\b(?:i|we) have (?:already )?(?:found|got) T\d+$")
_YOU_STOP = re.compile(
    r"^(?:(?:please|hey|,) )*(?:can|could|would|will) you (?:please )?"
    r"(?:stop|wait|pause|hold on|halt|come to a (?:halt|stop))\b|"
    r"(?<!when )(?<!if )(?<!until )\byou (?:\w+ )?stop(?:ped)?\b|\bdo not you dare\b"
)
_ASKS_ABOUT_STOPS = re.compile(
    r"^(?:(?:and|but|so|robot|,) )*(?:when|how|what|why|where|which|who|does|do|did|is|has|have|if)\b|"
    r"^(?:can|could|would|will) you (?:stop|wait|pause|halt) (?:it )?(?:if|when|quickly|fast)\b"
)
_ABOUT_MEMORY = re.compile(r"\b(?:forget|remember|erase|delete) (?:about )?(?:me|my name|who i am|everything about)\b")
_CLEAR = re.compile(
    r"(?:(?:please|okay|now|well|hey|hello|good morning|then|and|also|yes|thanks|just|,|"
    r"(?:can|could|would|will) you) )*"
    r"(?:(?:bring|get|fetch|give|pass|hand|take)(?: (?:me|us|over))? (?:T\d+|it|that|them)"
    r"(?:(?: ,)? and T\d+)*(?: P\d+){0,2}|"
    r"(?:put|place|set|leave) (?:T\d+|it|that|them) (?:down )?P\d+|"
    r"(?:(?:may|can|could) (?:i|we) have|make|prepare|start|serve|bring|get|fix|set up|have)"
    r"(?: (?:me|us|my|our|the|some|up))* breakfast)"
    r"(?: (?:please|thanks|thank you|now|quickly|,|\.|\?))*"
)
"""An order that is nothing else, and so is not doubted, unless somebody else is called."""


class SecondOpinion:
    """Judges whole sentences where the rules judge words.

    Args:
        cutter: Cuts sentences into clauses.
        judge: Weighs whole sentences; the one that comes with Attune by default.
    """

    def __init__(self, cutter: ClauseCutter, judge: CommandJudge | None = None) -> None:
        self._cutter = cutter
        self._judge = judge or load_command_judge()

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
        judged = self._judge.judge(sentence, context, lexicon)
        if found != "other":
            answering = bool(context.pending_question) and found in INSTRUCTIONS
            doubted = self._doubted(meaning, found, judged, sentence, context, answering=answering)
            if doubted is not None or answering:
                return doubted or meaning
        command = self._command(meaning, found, judged, context)
        if is_no_stop(sentence.skeleton):
            return meaning
        if command == found or (meaning.intent == "cancel_object" and command not in _MORE_THAN_CANCELLING):
            return meaning
        settled, text = settled_with_roles(sentence, without_denied_stops(sentence.skeleton)[0], context)
        reading = SecondReading(text, settled, context, lexicon, said)
        return reading.read_as(command, self._cutter, judged[command]) or meaning

    @staticmethod
    def _doubted(
        meaning: Interpretation, found: CommandIntent, judged: Mapping[CommandIntent, float], sentence: Sentence,
        context: Context, *, answering: bool,
    ) -> Interpretation | None:  # fmt: skip
        """A question or talk in place of a command, where it is doubtful that anything was asked of the robot."""
        last = re.split(r" [,.] ", sentence.skeleton.strip(" ,.?"))[-1]
        if sentence.called != "else" and (
            _CLEAR.fullmatch(sentence.skeleton) or ("please" in last and _CLEAR.fullmatch(last))
        ):
            return None
        short = len(sentence.skeleton.split()) <= _SHORT
        told = bool(_YOU_STOP.search(sentence.skeleton)) and not _ASKS_ABOUT_STOPS.search(sentence.skeleton)
        told = told or sentence.called == "robot"
        if answering and short:
            return None
        limits = _ANSWERS if answering else _STOPS if found == "stop" else _LIMITS[found]
        later = (
            _STOP_SHORT * short + _STOP_TOLD * told
            if found == "stop"
            else _CALLED * (sentence.called == "robot")
            + _FRAMED * (meaning.confidence >= _EXPRESSLY)
            + _NAMED * (found == "change_location" and meaning.confidence >= NAMED)
            + _POINTS * (context.busy and any(thing.head != "noun" for thing in sentence.things))
        )
        against = _against(judged)
        if against > limits.ignore + later:
            reason = "the whole sentence sounds like no request"
            return Interpretation(intent="talk", confidence=round(judged["other"], 2), reason=reason)
        if against > limits.ask + later:
            reason = "may not have been asked of the robot"
            return Interpretation(intent="unclear", confidence=round(judged[found], 2), reason=reason, doubted=meaning)
        return None

    @staticmethod
    def _command(
        meaning: Interpretation, found: CommandIntent, judged: Mapping[CommandIntent, float], context: Context
    ) -> CommandIntent:
        """The command that is likeliest, given what the rules found."""
        likeliest: CommandIntent = max((name for name in COMMANDS if name != "other"), key=lambda name: judged[name])
        if found == "change_location" and (meaning.add or meaning.confidence >= NAMED):
            return found  # what is already on its way is not asked for anew
        if found != "other":
            usual = found if likeliest != "stop" else ""
            needed = _ANOTHER_COMMAND.get(usual, _ANOTHER_THAN_THE_REST)
            return likeliest if _log_odds(judged, likeliest, found) > needed else found
        somebody_else = meaning.intent == "talk" and meaning.confidence >= SOMEBODY_CALLED
        stop_needed = _A_STOP[context.busy] + _STOP_OF_ANOTHER * somebody_else
        if likeliest == "stop" and _log_odds(judged, "stop", "other") > stop_needed:
            return "stop"
        needed = _SOMEBODY_ELSE_CALLED if somebody_else else _NONE_FOUND
        return likeliest if _log_odds(judged, likeliest, "other") > needed else "other"

    def is_no_request(self, after: str, sentence: Sentence, context: Context, lexicon: Lexicon) -> bool:
        """Whether what follows a stop only explains it, as far as the model is sure."""
        if _EXPLAINS.search(after):
            return True
        return self._judge.judge(replace(sentence, skeleton=after), context, lexicon)["other"] > _LIKELIER_THAN_NOT

    def instruction(
        self, after: str, sentence: Sentence, context: Context, lexicon: Lexicon, said: Sequence[ObjectSpec]
    ) -> Interpretation | None:
        """The instruction that follows a stop, where the model is sure that there is one."""
        judged = self._judge.judge(replace(sentence, skeleton=after), context, lexicon)
        command = max(COMMANDS, key=lambda name: judged[name])
        if command not in INSTRUCTIONS or judged[command] < _SURE:
            return None
        settled, text = settled_with_roles(sentence, after, context)
        return SecondReading(text, settled, context, lexicon, said).read_as(command, self._cutter, judged[command])


_MORE_THAN_CANCELLING = frozenset({"replace_object", "setting_breakfast"})
_TINY = 1e-9


def _is_all_of_it(context: Context) -> bool:
    """Whether the task is about one thing, without which nothing of it is left."""
    return context.task is not None and len(context.task.objects) == 1


def _against(judged: Mapping[CommandIntent, float]) -> float:
    """The odds that nothing was asked, as a logarithm."""
    return math.log(judged["other"] + _TINY) - math.log(1 - judged["other"] + _TINY)


def _log_odds(judged: Mapping[CommandIntent, float], first: CommandIntent, second: CommandIntent) -> float:
    return math.log(judged[first] + _TINY) - math.log(judged[second] + _TINY)
