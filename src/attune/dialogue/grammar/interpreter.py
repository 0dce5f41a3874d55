"""The embedded interpreter: a semantic parser for the kitchen. No network, no model, a few milliseconds."""

import re
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.dialogue.context import Context
from attune.dialogue.grammar import frames
from attune.dialogue.grammar.addressee import is_for_someone_else, who_is_called
from attune.dialogue.grammar.answers import read_answer, read_question
from attune.dialogue.grammar.breakfast import wants_breakfast
from attune.dialogue.grammar.clauses import ClauseCutter, Sentence, skeleton
from attune.dialogue.grammar.corrections import settle
from attune.dialogue.grammar.phrases import PhraseReader
from attune.dialogue.grammar.references import fits, in_their_roles, object_spoken_of
from attune.dialogue.grammar.remarks import remark, status_question
from attune.dialogue.grammar.requests import RequestReader
from attune.dialogue.grammar.second_opinion import CERTAIN, INSTRUCTIONS, NOTHING_FOUND, SOMEBODY_CALLED, SecondOpinion
from attune.dialogue.grammar.stopping import find_stop, without_denied_stops
from attune.dialogue.grammar.tokens import Token, tokenize
from attune.dialogue.grammar.wanted import Wanted, same_request
from attune.dialogue.interpreter import Interpretation
from attune.dialogue.lexicon import Lexicon, load_lexicon
from attune.dialogue.words import words

NOTHING_KNOWN = Context()
_KEPT_LEXICONS = 32
_LONGEST_FRAGMENT = 12
_SHORT_OPENING = 5
_STOP_WORDS = words("stop halt freeze abort")
_GIVES_UP = re.compile(r"(?:\w+ )*?(?:cancel|forget|scrap|scratch|never ?mind|drop|call)\b")
_WAITS = re.compile(r"(?:\w+ )*?(?:wait|hold on|hang on)\b")
_CUT_OFF = re.compile(
    r"\b(?:put|place|set|lay|leave|stand|move)(?: \S+){0,3}? T\d+ (?:on|in|at|by|under|next to|inside)[ .,]*$|"
    r"\b(?:put|place|set|lay|leave) (?:it|that|them|this) (?:on|in|at|by|under|next to)[ .,]*$|\band put it[ .,]*$|"
    r"\bT\d+\b.*\b(?:to|in|on|from|into|onto|at) (?:the|a|an|my|our)[ .,]*$|"
    r"\bT\d+ (?:(?:to|and|or|from|into|onto)(?: the| a| my)?|(?:on|in|of|with|at) (?:the|a|my))[ .,]*$"
)
_UNKNOWN_PLACE = re.compile(
    r"\bT\d+(?: please| over| down| back)? (?:to|into|onto) (?:the|my|our) (?P<to>(?!T\d|P\d)[a-z]+(?: room)?)\b|"
    r"\b(?:put|place|set|leave|lay|stick|pop|stand|drop|store) T\d+ (?:in|on|under|behind|beside|next to) "
    r"(?:the|my|our) (?P<at>(?!T\d|P\d)[a-z]+(?: room)?)\b"
)
_NO_PLACES = words(
    "morning evening afternoon night day weekend way double moment meantime end middle minute side left right top back "
    "front house kitchen place spot usual same corner lady man guest guests family girl boy old other one very next "
    "first last wife husband boss patient others person people visitors seat"
)
_BEFORE_A_NAME = words(
    "hey hello hi dear okay please oh yes no so well now excuse me listen look good morning thank you , ."
)
_ALSO_ADJECTIVES = words("love man machine dear friend pet duck sugar honey")
_DANGLING = words(
    "the a an my your our to from on in of with and or some that this bring get fetch put take "
    "give hand pass could can would you want need like i for at into onto its their his her"
)


class GrammarInterpreter:
    """Understands kitchen talk by its own grammar.

    Args:
        lexicon: The words it knows; each context's scene adds its own.
    """

    def __init__(self, lexicon: Lexicon | None = None) -> None:
        self._lexicon = lexicon or load_lexicon()
        self._cutter = ClauseCutter(self._lexicon)
        self._judge = SecondOpinion(self._cutter)
        self._extended: OrderedDict[tuple[ObjectSpec, ...], tuple[Lexicon, PhraseReader]] = OrderedDict()

    async def interpret(self, text: str, context: Context) -> Interpretation:
        """What `text` means in this situation."""
        return self.read(text, context)

    def read(self, text: str, context: Context = NOTHING_KNOWN) -> Interpretation:
        """As `interpret`, without waiting."""
        tokens = tokenize(text)
        if not any(token.text[0].isalnum() for token in tokens):
            return Interpretation(intent="backchannel", confidence=0.9, reason="no words")
        if is_for_someone_else(tokens, self._words_of(context)[0]):
            meaning = Interpretation(intent="talk", confidence=SOMEBODY_CALLED, reason="somebody else is called")
        else:
            meaning = self._by_rules(tokens, context)
        if meaning.intent not in CERTAIN:
            meaning = self._second_opinion(meaning, tokens, context)
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
        tokens = _without_names_of_robot(tokens, lexicon)
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
        called = re.match(r" , (\w+)(?= [,.]|$)", stopless[end:])
        if words not in _STOP_WORDS and called and called[1] in lexicon.others - lexicon.robot:
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
            if _GIVES_UP.match(words) or _is_of_the_kind(meaning, context):
                meaning = _instead(meaning, after, context, said)
            return replace(meaning, reason=f"{words!r}, then {meaning.reason}")
        return Interpretation(intent="stop", confidence=0.95, reason=f"says {words!r}")

    def objects_in(self, text: str) -> tuple[ObjectSpec, ...]:
        """The objects that a text names, whatever it says about them."""
        sentence = skeleton(PhraseReader(self._lexicon).items(tokenize(text)))
        return tuple(thing.spec for thing in sentence.things if thing.head == "noun")

    def is_mass(self, type_: str) -> bool:
        """Whether people say "the milk" without meaning a particular one."""
        return type_ in self._lexicon.mass

    def _meaning(
        self, plain: str, text: str, sentence: Sentence, context: Context, lexicon: Lexicon, reader: PhraseReader,
        said: tuple[ObjectSpec, ...], fragment: bool = False,
    ) -> Interpretation:  # fmt: skip
        if context.pending_question:
            question = read_question(context.pending_question, context, reader)
            settled, answered, _ = settle(sentence, frames.without_asides(text))
            answer = read_answer(answered if answered.strip(" .,?") else text, settled, question, context)
            if answer is not None:
                return answer
        if _CUT_OFF.search(text):
            return Interpretation(intent="fragment", confidence=0.7, reason="breaks off before it says where or what")
        noted = remark(plain if not fragment else text, text)
        if noted is not None:
            return noted
        has_things = re.search(r"\bT\d+\b", text) is not None
        wanted = self._wanted(text, sentence, context, lexicon, said)
        if wants_breakfast(self._plain_of(text, sentence), bool(wanted.add)):
            return Interpretation(intent="setting_breakfast", confidence=0.92, reason="asks for breakfast")
        result = _elsewhere(wanted, text, lexicon) or _decide(wanted, text, context, said)
        if result is not None:
            return _answering(result, question.options, context) if context.pending_question else result
        return self._no_request(plain, text, wanted, has_things)

    def _wanted(
        self, text: str, sentence: Sentence, context: Context, lexicon: Lexicon, said: tuple[ObjectSpec, ...]
    ) -> Wanted:
        settled, text, _ = settle(sentence, frames.without_asides(text))
        return RequestReader(settled, context, lexicon, said).read(self._cutter.cut(text))

    @staticmethod
    def _plain_of(text: str, sentence: Sentence) -> str:
        return re.sub(r"\bP(\d+)\b", lambda m: f"the {sentence.spots[int(m[1])].place}", text)

    @staticmethod
    def _no_request(plain: str, text: str, wanted: Wanted, has_things: bool) -> Interpretation:  # noqa: PLR0911 - one rule per return
        words = plain.strip(" .,?").split()
        if wanted.unknown and (wanted.asked or wanted.framed) and not _breaks_off(words):
            return Interpretation(
                intent="unknown_object", unknown=wanted.unknown, confidence=0.7, reason="asks for something unknown"
            )
        status = status_question(plain, names_things=has_things)
        if status is not None:
            return status
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


def _elsewhere(wanted: Wanted, text: str, lexicon: Lexicon) -> Interpretation | None:
    """A thing shall go where the robot does not know a place: that is asked back, not brought somewhere else."""
    named = _UNKNOWN_PLACE.search(text)
    if named is None or wanted.destination or not (wanted.asked and wanted.add):
        return None
    place = named["to"] or named["at"]
    if place in _NO_PLACES | lexicon.others:
        return None
    reason = "names a place it does not know"
    return Interpretation(intent="unknown_object", unknown=place, confidence=0.7, reason=reason)


def _answering(meaning: Interpretation, options: Sequence[ObjectSpec], context: Context) -> Interpretation:
    """After a question, "not the plate, the spoon" replaces nothing: the plate was only offered."""
    refused = meaning.remove and all(any(fits(spec, option) for option in options) for spec in meaning.remove)
    if meaning.intent != "replace_object" or not refused or any(spec in context.recent for spec in meaning.remove):
        return meaning
    return replace(meaning, intent="bring_me", remove=(), reason="wants something other than what was offered")


def _is_of_the_kind(meaning: Interpretation, context: Context) -> bool:
    """Whether what is wanted after "wait" is of the kind that the robot is about: then it is that which was wrong."""
    about = {spec.type for spec in context.recent}
    return meaning.intent == "bring_me" and len(meaning.add) == 1 and meaning.add[0].type in about


def _instead(meaning: Interpretation, text: str, context: Context, said: tuple[ObjectSpec, ...]) -> Interpretation:
    """Read "cancel that, I'll have juice": what the robot was about is given up for what is wanted now."""
    if meaning.intent != "bring_me" or context.task is None or frames.ADDITIVE.search(text):
        return meaning
    old = object_spoken_of(context, meaning.add[0], said)
    return replace(meaning, intent="replace_object", remove=(old,)) if old and old not in meaning.add else meaning


def _breaks_off(words: Sequence[str]) -> bool:
    """Whether a sentence ends where none does: "bring me the", "could you"."""
    if not words or len(words) > _LONGEST_FRAGMENT or words[-1] not in _DANGLING:
        return False
    asks_you = words[-2:-1] and words[-2] in {"can", "could", "would", "will"} and len(words) <= _SHORT_OPENING
    return words[-1] not in {"you", "it"} or bool(asks_you)


def _decide(wanted: Wanted, text: str, context: Context, said: tuple[ObjectSpec, ...]) -> Interpretation | None:  # noqa: PLR0911 - one rule per return
    """The command that is wanted, or None."""
    additive = frames.ADDITIVE.search(text) is not None and not re.search(r"\binstead\b", text)
    add, remove = tuple(wanted.add), tuple(dict.fromkeys(wanted.remove))
    confidence = 0.95 if wanted.framed else 0.9 if wanted.asked else 0.75
    moving = (
        wanted.destination
        and not remove
        and (not add or _is_moving(wanted, context, additive))
        and (wanted.moves or wanted.pronoun or context.busy)
    )
    if moving:
        return Interpretation(
            intent="change_location",
            destination=wanted.destination,
            confidence=confidence,
            reason="names another place",
        )
    if add and remove:
        remove = tuple(spec for spec in remove if spec not in add) or remove
        return _replacing(wanted, add, remove, confidence, "wants one thing instead of another")
    if remove and not add:
        back = re.search(r"\bT\d+ (?:back|away)\b|\breturn T\d+|\b(?:put|take|bring|carry) (?:back|away) T\d+", text)
        if back:
            return Interpretation(intent="put_back", remove=remove, confidence=0.85, reason="wants something put back")
        return Interpretation(
            intent="cancel_object", remove=remove, confidence=0.85, reason="does not want something any more"
        )
    if not add:
        return None
    if not additive:
        instead = re.search(r"\binstead\b|\bin its place\b|\bin place of (?:it|that|this)\b", text) is not None
        corrects = instead or wanted.contrast or (context.busy and _corrects(wanted, text))
        if corrects:
            spoken_of = object_spoken_of(context, add[0], said)
            old = (spoken_of,) if spoken_of is not None and spoken_of != add[0] else ()
            if old or instead or wanted.contrast:
                return _replacing(wanted, add, old, confidence, "corrects what was wanted")
    return Interpretation(
        intent="bring_me", add=add, definite=tuple(wanted.definite), destination=wanted.destination,
        unknown=wanted.unknown, confidence=confidence, reason="asks for objects",
    )  # fmt: skip


def _corrects(wanted: Wanted, text: str) -> bool:
    if frames.CORRECTION.search(text) or wanted.indirect:
        return True
    return re.fullmatch(
        r"(?:please |, |robot |oh )*(?:i (?:want|would like|need|would prefer) )?T\d+(?: please| ,| \.|!| \?)*", text
    ) is not None and (len(wanted.add) == 1 and wanted.definite[:1] == [True] and not wanted.asked and wanted.indirect)


def _is_moving(wanted: Wanted, context: Context, additive: bool) -> bool:
    """Whether the objects named with a place are those the robot is about already."""
    if additive or not (wanted.asked or wanted.moves) or not context.busy:
        return False
    about = context.recent
    return all(definite for definite in wanted.definite) and all(
        not spec.location and same_request(spec, about) for spec in wanted.add
    )


def _replacing(
    wanted: Wanted, add: tuple[ObjectSpec, ...], remove: tuple[ObjectSpec, ...], confidence: float, reason: str
) -> Interpretation:
    return Interpretation(
        intent="replace_object", add=add, remove=remove, destination=wanted.destination,
        definite=tuple(wanted.definite), confidence=confidence, reason=reason,
    )  # fmt: skip


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
