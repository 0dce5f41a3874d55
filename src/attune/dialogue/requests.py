"""Acting on what was meant: commands where it is clear, questions where it is not, confirmation once it is accepted."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import anyio

from attune.core.bus import COMMAND, OUTCOME, Bus
from attune.core.clock import Clock
from attune.core.messages import Band, CommandOutcome, ObjectSpec, Utterance
from attune.dialogue.answering import Answerer
from attune.dialogue.commands import commands_for
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.grammar.references import is_described_by
from attune.dialogue.grounding import Grounding, ground
from attune.dialogue.interpreter import Intent, Interpretation
from attune.dialogue.narrator import Narrator
from attune.dialogue.situation import PendingQuestion, Situation, completed
from attune.dialogue.speaker import Speaker
from attune.dialogue.wording import called, choices, noun, the, things, where

VERDICT_WITHIN = 0.3
"""A command is confirmed once the planner has accepted it, and after this long if it has said nothing [s]."""
_SEVERAL = 2
_REMEMBERED = 20
_ASKED_BACK = {"unclear": ("ask", "which_object"), "unknown_object": ("cannot", "unknown_object"),
               "unknown_action": ("cannot", "unknown_action")}  # fmt: skip
_CHANGES: frozenset[Intent] = frozenset({"replace_object", "change_location", "cancel_object", "put_back"})
"""What alters a plan; the policy says whether it is confirmed in words."""
_VAGUE = ("something", "anything", "some ", "one ")
_ASIDES: frozenset[Intent] = frozenset(
    {"status", "style", "stated_age", "thanks", "greeting", "repeat", "dont_stop", "question"}
)
"""What leaves the robot's own question open: its answer may still come."""


class Requests:
    """Does what a person wants, as far as it is clear.

    Args:
        bus: Where commands go and outcomes come from.
        clock: The session's clock.
        speaker: Who answers.
        situation: What is known, done and asked.
        narrator: Who tells of outcomes.
        embedded: Reads which objects a question names.
    """

    def __init__(
        self,
        bus: Bus,
        clock: Clock,
        speaker: Speaker,
        situation: Situation,
        narrator: Narrator,
        embedded: GrammarInterpreter,
    ) -> None:
        self._bus = bus
        self._clock = clock
        self._speaker = speaker
        self._situation = situation
        self._narrator = narrator
        self._embedded = embedded
        self._answerer = Answerer(speaker, situation)
        self._several: dict[str, bool] = {}
        self._said_stopped = ""
        self._confirmations: dict[str, Callable[[], object]] = {}
        self._group: anyio.abc.TaskGroup | None = None

    async def run(self) -> None:
        """Follow what becomes of the commands, until cancelled."""
        with self._bus.subscribe(OUTCOME) as outcomes:
            async with anyio.create_task_group() as self._group:
                async for outcome in outcomes:
                    self._outcome(outcome)

    # --- what was said -----------------------------------------------------------------------------------------

    def answered(self, meaning: Interpretation, cause: str) -> Interpretation:
        """The whole of what is wanted, if this answers the pending question, which it settles unless it is an aside.

        Args:
            meaning: What was said.
            cause: Id of the utterance.
        """
        pending = self._situation.question(self._clock.now())
        if pending is None or meaning.intent in _ASIDES:
            return meaning
        self._situation.pending = None
        self._speaker.take_back((pending.reply,), cause)
        return completed(meaning, pending)

    def act(self, utterance: Utterance, meaning: Interpretation, band: Band) -> None:
        """Do it, ask, or answer.

        Args:
            utterance: What was said.
            meaning: What it means.
            band: The person's age band.
        """
        if meaning.destination and meaning.destination not in self._situation.places:
            self._speaker.say("cannot", "unknown_place", cause=utterance.id, place=meaning.destination)
            return
        if meaning.intent in {"bring_me", "replace_object"}:
            self._fetch(utterance, meaning, band)
            return
        meaning = self._situation.with_what_to_put_back(meaning, self._clock.now())
        last = self._speaker.last
        old = (
            meaning.remove[0] if meaning.remove else next(iter(self._situation.context(self._clock.now()).recent), None)
        )
        confirm = partial(
            self._speaker.say, "accept", self._confirmation(meaning.intent), cause=utterance.id,
            urgency="urgent" if meaning.intent == "stop" else "normal", place=f"the {meaning.destination}",
            old=called(old) if old else "it", thing=noun(old) if old else "thing", repeated=meaning.reply,
        )  # fmt: skip
        if meaning.intent == "put_back" and self._situation.is_returning(meaning.remove):
            confirm()
        elif self._speaker.knows("accept", meaning.intent):
            self._publish(utterance, meaning, band, confirm)
        else:
            self._answerer.answer(meaning, self._embedded.objects_in(utterance.text), last, utterance.id)

    def ask_back(self, utterance: Utterance, meaning: Interpretation) -> None:
        """Ask what was meant."""
        if meaning.doubted is not None:
            self._ask_whether(utterance, meaning.doubted)
            return
        if meaning.suggestion:
            reply = self._speaker.say("ask", "repair", cause=utterance.id, nearest=meaning.suggestion)
            self._situation.pending = PendingQuestion(reply.text, self._clock.now(), reply=reply.id)
            return
        group, situation = _ASKED_BACK.get(meaning.intent, ("ask", "again"))
        unknown = meaning.unknown or "such thing"
        if unknown.startswith(_VAGUE):
            group, situation = "ask", "which_object"
        reply = self._speaker.say(group, situation, cause=utterance.id, unknown=unknown, repeated=meaning.reply)
        if meaning.reply.endswith("?"):
            self._situation.pending = PendingQuestion(reply.text, self._clock.now(), reply=reply.id)

    def ask_for_the_rest(self, utterance: Utterance) -> None:
        """Ask for the rest of a sentence that broke off."""
        reply = self._speaker.say("ask", "fragment", cause=utterance.id)
        self._situation.pending = PendingQuestion(reply.text, self._clock.now(), reply=reply.id)

    def _ask_whether(self, utterance: Utterance, doubted: Interpretation) -> None:
        """Ask whether something was meant for the robot at all; only yes makes it a command."""
        kind = doubted.intent if doubted.remove or doubted.intent != "replace_object" else "bring_me"
        reply = self._speaker.say(
            "ask", f"whether_{kind}", cause=utterance.id, objects=things(doubted.add, doubted.definite),
            to=f" to the {doubted.destination}" if doubted.destination else "", where=where(doubted.destination),
            old=called(doubted.remove[0]) if doubted.remove else "",
        )  # fmt: skip
        self._situation.pending = PendingQuestion(
            reply.text, self._clock.now(), doubted, options=doubted.add, reply=reply.id, whole=True
        )

    def stop(self, cause: str) -> None:
        """A stop: nothing that was said before it is confirmed or asked any more.

        Args:
            cause: Id of the utterance.
        """
        self._situation.pending = None
        self._confirmations.clear()
        self._said_stopped = self._speaker.say("accept", "stop", cause=cause, urgency="urgent").id

    # --- fetching ----------------------------------------------------------------------------------------------

    def _fetch(self, utterance: Utterance, meaning: Interpretation, band: Band) -> None:
        """Bring or replace, once it is clear which objects are meant."""
        unclear = self._unclear(meaning)
        if not unclear:
            self._publish(utterance, meaning, band, partial(self._confirm, utterance, meaning))
            return
        first = next(iter(unclear))
        found = unclear[first]
        about, index = meaning, first
        if meaning.intent == "bring_me":
            # What is clear is begun at once; only the rest is asked about.
            clear = _only(meaning, [number for number in range(len(meaning.add)) if number not in unclear])
            if clear.add:
                self._publish(utterance, clear, band)
            about, index = _only(meaning, list(unclear)), 0
        self._ask_about(utterance, about, index, found)

    def _unclear(self, meaning: Interpretation) -> dict[int, Grounding]:
        """The objects that need a question, and why."""
        definite = (*meaning.definite, *(False for _ in meaning.add))
        unclear: dict[int, Grounding] = {}
        for index, spec in enumerate(meaning.add):
            found = ground(spec, definite[index], self._situation.known, self._situation.places, self._situation.in_use)
            ambiguous = found.finding == "ambiguous" and not self._embedded.is_mass(spec.type)
            if ambiguous or found.finding in {"absent", "elsewhere", "unknown_place"}:
                unclear[index] = found
        return unclear

    def _ask_about(self, utterance: Utterance, about: Interpretation, index: int, found: Grounding) -> None:
        match found.finding:
            case "ambiguous":
                options = choices(found.options)
                reply = self._speaker.say("ask", "which", cause=utterance.id, options=options, thing=noun(found.spec))
            case "unknown_place":
                self._speaker.say("cannot", "unknown_place", cause=utterance.id, place=found.spec.location)
                return
            case "elsewhere":
                nearest = f"{the(found.options[0])} from {self._situation.place_of(found.options[0])}"
                reply = self._speaker.say(
                    "ask", "elsewhere_offer", cause=utterance.id, object=noun(found.spec), nearest=nearest,
                    where=where(found.spec.location),
                )  # fmt: skip
            case _:
                reply = self._speaker.say(
                    "ask", "absent_offer", cause=utterance.id, object=noun(found.spec), nearest=the(found.options[0])
                )
        self._situation.pending = PendingQuestion(reply.text, self._clock.now(), about, index, found.options, reply.id)

    def _confirm(self, utterance: Utterance, meaning: Interpretation) -> None:
        situation: str = meaning.intent
        wanted = _as_many_as_known(meaning, self._situation.known)
        same_type = bool(meaning.remove and meaning.add) and meaning.remove[0].type == meaning.add[0].type
        old = (the if same_type else called)(meaning.remove[0]) if meaning.remove else ""
        if situation == "replace_object":
            situation = self._confirmation(meaning.intent) if old else "bring_me"
        if situation == "bring_me" and meaning.destination:
            situation = "bring_me_to"
        to = f" to the {meaning.destination}" if meaning.destination else ""
        self._speaker.say(
            "accept", situation, cause=utterance.id, objects=things(wanted.add, wanted.definite), old=old, to=to,
            to_now=to, repeated=meaning.reply,
        )  # fmt: skip

    def _confirmation(self, intent: Intent) -> str:
        return "changed" if intent in _CHANGES and not self._speaker.policy.restate else intent

    # --- commands and what becomes of them ---------------------------------------------------------------------

    def _publish(
        self, utterance: Utterance, meaning: Interpretation, band: Band, confirm: Callable[[], object] | None = None
    ) -> None:
        """Publish the commands for a meaning, and confirm them once the first is accepted."""
        now = self._clock.now()
        policy = self._speaker.policy
        if meaning.intent == "bring_me" and not meaning.destination and policy.destination:
            meaning = replace(meaning, destination=policy.destination)
        context = self._situation.context(now)
        commands = commands_for(meaning, context, now=now, cause=utterance.id, band=band)
        if confirm and (not commands or meaning.intent == "stop" or self._group is None):
            confirm()
        elif confirm and self._group is not None:
            self._confirmations[commands[0].id] = confirm
            self._group.start_soon(self._confirm_in_any_case, commands[0].id, name="confirmation")
        for command in commands:
            several = command.kind == "setting_breakfast" or len(meaning.add) >= _SEVERAL
            self._several = {**dict(list(self._several.items())[-_REMEMBERED:]), command.id: several}
            self._bus.publish(COMMAND, command)

    async def _confirm_in_any_case(self, command: str) -> None:
        await self._clock.sleep(VERDICT_WITHIN)
        confirm = self._confirmations.pop(command, None)
        if confirm:
            confirm()

    def _outcome(self, outcome: CommandOutcome) -> None:
        confirm = self._confirmations.pop(outcome.command, None)
        if outcome.status in {"accepted", "deferred", "done"}:
            if self._said_stopped and outcome.kind != "stop":
                # Who says "carry on" at once has heard enough of "I have stopped".
                self._speaker.take_back((self._said_stopped,), outcome.id)
                self._said_stopped = ""
            if confirm:
                confirm()
        self._situation.outcome(outcome)
        offer = self._narrator.outcome(outcome, several=self._several.get(outcome.command, False))
        if offer and outcome.alternative is not None:
            wanted = Interpretation(intent="bring_me", add=(outcome.object,), destination=outcome.place)
            self._situation.pending = PendingQuestion(
                offer.text, self._clock.now(), wanted, 0, (outcome.alternative,), offer.id
            )


def _only(meaning: Interpretation, numbers: Sequence[int]) -> Interpretation:
    """The meaning with only some of its objects."""
    definite = (*meaning.definite, *(False for _ in meaning.add))
    return replace(
        meaning,
        add=tuple(meaning.add[number] for number in numbers),
        definite=tuple(definite[number] for number in numbers),
    )


def _as_many_as_known(meaning: Interpretation, known: Sequence[ObjectSpec]) -> Interpretation:
    """Without what is wanted more often than it is known to exist; the planner says that there are no more."""
    numbers = []
    for number, spec in enumerate(meaning.add):
        exist = sum(is_described_by(replace(spec, location="", name=""), has) for has in known)
        if not exist or meaning.add[:number].count(spec) < exist:
            numbers.append(number)
    return _only(meaning, numbers)
