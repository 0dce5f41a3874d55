"""The embedded interpreter: a semantic parser for the kitchen. No network, no model, a few milliseconds."""

import re
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar import frames
from attune.dialogue.grammar.addressee import is_for_someone_else, is_told_to_another, who_is_called
from attune.dialogue.grammar.answers import agreed_to_the_only, read_answer
from attune.dialogue.grammar.breakfast import wants_breakfast
from attune.dialogue.grammar.clauses import ClauseCutter, Sentence, skeleton
from attune.dialogue.grammar.command_judge import CommandJudge
from attune.dialogue.grammar.corrections import settle
from attune.dialogue.grammar.decision import (
    answering,
    decide,
    elsewhere,
    instead_of_given_up,
    is_of_the_kind,
    just_spoken_of,
    left_out,
    pointed_at,
)
from attune.dialogue.grammar.destinations import settled_with_roles
from attune.dialogue.grammar.moves import moved
from attune.dialogue.grammar.phrases import PhraseReader
from attune.dialogue.grammar.questions import read_question
from attune.dialogue.grammar.references import in_their_roles
from attune.dialogue.grammar.remarks import remark, status_question
from attune.dialogue.grammar.requests import RequestReader
from attune.dialogue.grammar.second_opinion import CERTAIN, INSTRUCTIONS, NOTHING_FOUND, SOMEBODY_CALLED, SecondOpinion
from attune.dialogue.grammar.stopping import find_stop, without_denied_stops
from attune.dialogue.grammar.tokens import Token, tokenize
from attune.dialogue.grammar.wanted import Wanted
from attune.dialogue.interpreter import Interpretation
from attune.dialogue.lexicon import Lexicon, load_lexicon
from attune.dialogue.words import words

NOTHING_KNOWN = Context()
_KEPT_LEXICONS = 32
_LONGEST_FRAGMENT = 12
_CUT_OFF_FOR_SURE = 0.9
_SHORT_OPENING = 5
_STOP_WORDS = words("stop halt freeze abort")
_GIVES_UP = re.compile(r"(?:\w+ )*?(?:cancel|forget|scrap|scratch|never ?mind|drop|call)\b")
_WAITS = re.compile(r"(?:\w+ )*?(?:wait|hold on|hang on)\b")
_ROBOT_ONLY = re.compile(
    r"(?:(?:hey|oh|okay|dear|excuse me|listen|so|well|,) )*(?:robot|robbie|robo|attune|computer)"
    r"(?:(?: ,)? (?:robot|robbie|robo|please))*(?: [,.?])*"
)
_CUT_OFF = re.compile(
    r"\b(?:put|place|set|lay|leave|stand|move)(?: \S+){0,3}? T\d+ (?:on|in|at|by|under|next to|inside)[ .,]*$|"
    r"\b(?:put|place|set|lay|leave) (?:it|that|them|this) (?:on|in|at|by|under|next to)[ .,]*$|\band put it[ .,]*$|"
    r"\bT\d+\b.*\b(?:to|in|on|from|into|onto|at) (?:the|a|an|my|our)[ .,]*$|"
    r"\bT\d+ , (?:the|a|an|my)[ .,]*$|"
    r"\bT\d+ of(?: , of)*[ .,]*$|\binstead of T\d+ , (?:bring|get|fetch|give)(?: me)?[ .,]*$|"
    r"\bT\d+ (?:(?:to|and|or|from|into|onto)(?: the| a| my)?|(?:on|in|of|with|at) (?:the|a|my))[ .,]*$"
)
_ASKS_FOR_LAST = re.compile(r"\b(?:bring|get|fetch|give|pass|hand|have|want|like|need)(?: me| us)? T(\d+)$")
_BEFORE_A_NAME = words(
    "hey hello hi dear okay please oh yes no so well now excuse me listen look good morning thank you , ."
)
_ALSO_ADJECTIVES = words("love man machine dear friend pet duck sugar honey")
_BRINGS = words("bring get fetch give hand pass")
_DANGLING = words(
    "the a an my your our to from on in of with and or some that this bring get fetch put take "
    "give hand pass could can would you want need like i for at into onto its their his her"
)


class GrammarInterpreter:
    """Understands kitchen talk by its own grammar.

    Args:
        lexicon: The words it knows; each context's scene adds its own.
        judge: Weighs whole sentences; the one that comes with Attune by default.
    """

    def __init__(self, lexicon: Lexicon | None = None, judge: CommandJudge | None = None) -> None:
        self._lexicon = lexicon or load_lexicon()
        self._cutter = ClauseCutter(self._lexicon)
        self._judge = SecondOpinion(self._cutter, judge)
        self._extended: OrderedDict[tuple[ObjectSpec, ...], tuple[Lexicon, PhraseReader]] = OrderedDict()

    async def interpret(self, text: str, context: Context) -> Interpretation:
        """What `text` means in this situation."""
        return self.read(text, context)

    def read(self, text: str, context: Context = NOTHING_KNOWN) -> Interpretation:
        """As `interpret`, without waiting."""
        tokens = tokenize(text)
        if not any(token.text[0].isalnum() for token in tokens):
            return Interpretation(intent="backchannel", confidence=0.9, reason="no words")
        if _ROBOT_ONLY.fullmatch(" ".join(token.text for token in tokens)):
            return Interpretation(intent="greeting", status="called", confidence=0.9, reason="calls the robot")
        if is_for_someone_else(tokens, self._words_of(context)[0]):
            meaning = Interpretation(intent="talk", confidence=SOMEBODY_CALLED, reason="somebody else is called")
        else:
            meaning = self._by_rules(tokens, context)
        if meaning.intent not in CERTAIN and not _is_cut_off(meaning):
            meaning = self._second_opinion(meaning, tokens, context)
        meaning = left_out(meaning, " ".join(token.text for token in tokens), context)
        if meaning.intent == "replace_object":
            add, remove = in_their_roles(meaning.add, meaning.remove, context.recent)
            meaning = replace(meaning, add=add, remove=remove)
        return meaning

    def sentence(self, text: str, context: Context = NOTHING_KNOWN) -> tuple[Sentence, Lexicon]:
        """An utterance as the skeleton that the command model judges, with the words of this situation."""
        return self._sentence(tokenize(text), context)

    def _sentence(self, tokens: Sequence[Token], context: Context) -> tuple[Sentence, Lexicon]:
        lexicon, reader = self._words_of(context)
        kept = _without_names_of_robot(list(tokens), lexicon)
        called = who_is_called(tokens, lexicon, left_out=len(tokens) - len(kept))
        return replace(skeleton(reader.items(kept)), called=called), lexicon

    def _second_opinion(self, meaning: Interpretation, tokens: Sequence[Token], context: Context) -> Interpretation:
        sentence, lexicon = self._sentence(tokens, context)
        said = _spoken_of(context, self._words_of(context)[1])
        return self._judge.weighed(meaning, sentence, context, lexicon, said)

    def _by_rules(self, tokens: list[Token], context: Context) -> Interpretation:  # noqa: PLR0911 - one rule per return
        lexicon, reader = self._words_of(context)
        said_tokens, tokens = tokens, _without_names_of_robot(tokens, lexicon)
        sentence = skeleton(reader.items(tokens))
        plain = " ".join(token.text for token in tokens)
        said = _spoken_of(context, reader)
        stopless, denied = without_denied_stops(sentence.skeleton)
        stop = find_stop(stopless)
        if stop is None:
            whole = self._meaning(plain, stopless, sentence, context, lexicon, reader, said)
            if denied and whole.intent not in INSTRUCTIONS:
                return Interpretation(intent="dont_stop", confidence=0.9, reason="asks not to stop")
            return whole
        start, end, words = stop
        alone = words in _STOP_WORDS and stopless[start:end].strip(" ,") == words
        if (
            not (alone and context.busy)
            and is_told_to_another(stopless, end, tokens, lexicon)
            and who_is_called(said_tokens, lexicon, left_out=0) != "robot"
        ):
            return Interpretation(intent="talk", confidence=SOMEBODY_CALLED, reason="somebody else is called")
        after = stopless[end:].strip(" ,.?")
        if after and _WAITS.match(words) and re.search(r"\b[TP]\d+\b", stopless[:start]):
            # "put it on the table, no wait, on the counter"
            whole = self._meaning(plain, stopless, sentence, context, lexicon, reader, said)
            if whole.intent in INSTRUCTIONS:
                return whole
        given_up = re.findall(r"\bT\d+", stopless[start:end])
        if after and given_up:
            after = f"not {given_up[-1]} , {after}"  # "stop bringing the cup, bring the bowl"
        meaning = (
            self._meaning(after, after, sentence, context, lexicon, reader, said, fragment=True) if after else None
        )
        if meaning and meaning.intent in NOTHING_FOUND:
            meaning = self._judge.instruction(after, sentence, context, lexicon, said) or meaning
        if meaning and self._judge.is_no_request(after, sentence, context, lexicon):
            meaning = None  # "leave it, I've found one"
        if meaning and (meaning.intent in INSTRUCTIONS or meaning.intent in {"carry_on", "put_back"}):
            if meaning.intent in {"bring_me", "replace_object", "change_location"} and meaning.confidence < 0.5:
                return Interpretation(intent="stop", confidence=0.9, reason=f"says {words!r}")
            if meaning.intent == "setting_breakfast" and context.task and context.task.command == meaning.intent:
                return Interpretation(intent="stop", confidence=0.9, reason=f"says {words!r}")
            if _GIVES_UP.match(words) or is_of_the_kind(meaning, context):
                meaning = instead_of_given_up(meaning, after, context, said)
            return replace(meaning, reason=f"{words!r}, then {meaning.reason}")
        return Interpretation(intent="stop", confidence=0.95, reason=f"says {words!r}")

    def objects_in(self, text: str) -> tuple[ObjectSpec, ...]:
        """The objects that a text names, whatever it says about them."""
        sentence = skeleton(PhraseReader(self._lexicon).items(tokenize(text)))
        return tuple(thing.spec for thing in sentence.things if thing.head == "noun")

    def is_mass(self, type_: str) -> bool:
        """Whether people say "the milk" without meaning a particular one."""
        return type_ in self._lexicon.mass

    def _meaning(  # noqa: PLR0911 - one rule per return
        self, plain: str, text: str, sentence: Sentence, context: Context, lexicon: Lexicon, reader: PhraseReader,
        said: tuple[ObjectSpec, ...], fragment: bool = False,
    ) -> Interpretation:  # fmt: skip
        if _CUT_OFF.search(text) or (not context.pending_question and _lacks_its_noun(text, sentence)):
            reason = "breaks off before it says where or what"
            return Interpretation(intent="fragment", confidence=_CUT_OFF_FOR_SURE, reason=reason)
        if context.pending_question:
            question = read_question(context.pending_question, context, reader)
            settled, answered, _ = settle(sentence, frames.without_asides(text))
            answer = read_answer(answered if answered.strip(" .,?") else text, settled, question, context)
            if answer is not None:
                return answer
        noted = remark(plain if not fragment else text, text)
        if noted is not None:
            return noted
        settled, plainly = settled_with_roles(sentence, text, context)
        clauses = self._cutter.cut(plainly)
        where = moved(plainly, clauses, settled, context)
        if where is not None:
            return where
        wanted = RequestReader(settled, context, lexicon, said).read(clauses)
        if wants_breakfast(self._plain_of(text, sentence), bool(wanted.add)):
            return Interpretation(intent="setting_breakfast", confidence=0.92, reason="asks for breakfast")
        result = elsewhere(wanted, text, lexicon) or decide(wanted, text, context, said)
        if result is not None:
            return answering(result, question.options, context) if context.pending_question else result
        if context.pending_question and len(question.options) == 1 and wanted.pronoun and wanted.asked:
            return agreed_to_the_only(question, context)  # "you may bring it"
        meant = just_spoken_of(wanted, context, said)
        return meant or self._no_request(plain, text, wanted, pointed_at(text, sentence, context, said))

    @staticmethod
    def _plain_of(text: str, sentence: Sentence) -> str:
        return re.sub(r"\bP(\d+)\b", lambda m: f"the {sentence.spots[int(m[1])].place}", text)

    @staticmethod
    def _no_request(  # noqa: PLR0911 - one rule per return
        plain: str, text: str, wanted: Wanted, about: tuple[ObjectSpec, ...]
    ) -> Interpretation:
        has_things = re.search(r"\bT\d+\b", text) is not None
        words = plain.strip(" .,?").split()
        if wanted.unknown and (wanted.asked or wanted.framed) and not _breaks_off(words):
            return Interpretation(
                intent="unknown_object", unknown=wanted.unknown, confidence=0.7, reason="asks for something unknown"
            )
        status = status_question(plain, names_things=has_things)
        if status is not None:
            return replace(status, add=about)
        if _breaks_off(words):
            return Interpretation(intent="fragment", confidence=0.7, reason="breaks off before it says what")
        if wanted.unresolved:
            return Interpretation(intent="unclear", confidence=0.5, reason="points at something that was not named")
        if wanted.pronoun and wanted.asked:
            return Interpretation(intent="unclear", confidence=0.4, reason="it is not clear what is meant by it")
        if frames.QUESTION.match(text):
            return Interpretation(intent="question", confidence=0.6, reason="a question, no request")
        if re.match(r"(?:please |robot |hey |, )*(?:can|could|would|will) you\b", plain):
            return Interpretation(
                intent="unknown_action", confidence=0.6, reason="asks for something the robot cannot do"
            )
        if re.search(r"\bP\d+\b", text) and not has_things and len(words) <= 5:
            return Interpretation(intent="fragment", confidence=0.5, reason="a place, and nothing to do there")
        return Interpretation(intent="talk", confidence=0.6, reason="no request to the robot in it")

    def _words_of(self, context: Context) -> tuple[Lexicon, PhraseReader]:
        key = context.scene
        if key not in self._extended:
            lexicon = self._lexicon.extended(key) if key else self._lexicon
            self._extended[key] = (lexicon, PhraseReader(lexicon, {spec.type for spec in key}))
            if len(self._extended) > _KEPT_LEXICONS:
                self._extended.popitem(last=False)
        self._extended.move_to_end(key)
        return self._extended[key]


def _breaks_off(words: Sequence[str]) -> bool:
    """Whether a sentence ends where none does: "bring me the", "could you"."""
    if not words or len(words) > _LONGEST_FRAGMENT:
        return False
    if words[-1] in {"me", "us"} and words[-2:-1] and words[-2] in _BRINGS:
        return True
    if words[-1] not in _DANGLING:
        return False
    asks_you = words[-2:-1] and words[-2] in {"can", "could", "would", "will"} and len(words) <= _SHORT_OPENING
    return words[-1] not in {"you", "it"} or bool(asks_you)


def _is_cut_off(meaning: Interpretation) -> bool:
    return meaning.intent == "fragment" and meaning.confidence >= _CUT_OFF_FOR_SURE


def _lacks_its_noun(text: str, sentence: Sentence) -> bool:
    """Whether a request ends with a size, and with nothing that has it: "get me the small blue"."""
    asked = _ASKS_FOR_LAST.search(text)
    if asked is None:
        return False
    thing = sentence.things[int(asked[1])]
    return thing.head == "bare" and bool(thing.spec.size) and not thing.compared


def _spoken_of(context: Context, reader: PhraseReader) -> tuple[ObjectSpec, ...]:
    text = context.pending_question or context.last_robot_utterance
    if not text:
        return ()
    sentence = skeleton(reader.items(tokenize(text)))
    return tuple(thing.spec for thing in sentence.things if thing.head == "noun")


def _without_names_of_robot(tokens: list[Token], lexicon: Lexicon) -> list[Token]:
    """Leave out what the robot is called at the beginning or the end ("robot, ...", "..., mate")."""
    words = [token.text for token in tokens]
    kept = list(tokens)
    start = 0
    while start < len(words):
        for length in (3, 2, 1):
            rest = kept[start + length :]
            if rest and " ".join(words[start : start + length]) in lexicon.robot:
                ambiguous = length == 1 and words[start] in _ALSO_ADJECTIVES and rest[0].text not in {",", "."}
                if not ambiguous:
                    return kept[:start] + (rest[1:] if rest[0].text == "," else rest)
        if words[start] not in _BEFORE_A_NAME:
            break
        start += 1
    end = len(words)
    while end and words[end - 1] in {".", "?"}:
        end -= 1
    for length in (3, 2, 1):
        if (
            end > length
            and " ".join(words[end - length : end]) in lexicon.robot
            and (words[end - length - 1] == "," or words[end - 1] in {"robot", "mate", "buddy"})
        ):
            start = end - length - (words[end - length - 1] == ",")
            return kept[:start] + kept[end:]
    return kept
