"""Answers to remarks and questions: thanks, "what are you doing?", "where is my cup?", "say that again"."""

from dataclasses import replace

from attune.core.messages import ObjectSpec, RobotState
from attune.dialogue.grammar.references import is_described_by
from attune.dialogue.interpreter import Interpretation
from attune.dialogue.situation import Situation
from attune.dialogue.speaker import Speaker
from attune.dialogue.wording import an_existing, called, counted, number_word, placed, sentence_case, the, where

_TOLD = 4
"""So many things are told one by one."""
_RESTING = frozenset({"idle", "task_done", "already_done", "failed"})


class Answerer:
    """Answers what is no command.

    Args:
        speaker: Who says it.
        situation: What there is to tell.
    """

    def __init__(self, speaker: Speaker, situation: Situation) -> None:
        self._speaker = speaker
        self._situation = situation
        self._asked_about = ""

    def answer(self, meaning: Interpretation, spoken_of: tuple[ObjectSpec, ...], last: str, cause: str) -> None:
        """Say something fitting.

        Args:
            meaning: What was meant.
            spoken_of: The objects that the utterance names.
            last: What the robot said last.
            cause: Id of the utterance.
        """
        match meaning.intent:
            case "thanks" | "greeting" if meaning.reply:
                self._speaker.say("talk", meaning.intent, cause=cause, repeated=meaning.reply)
            case "greeting" if meaning.status:
                self._speaker.say("talk", meaning.status, cause=cause)
            case "thanks" | "greeting" | "deny" | "stated_age":
                self._speaker.say("talk", meaning.intent, cause=cause)
            case "style":
                self._speaker.say("talk", f"style_{meaning.style}", cause=cause)
            case "repeat":
                if last:
                    self._speaker.say("talk", "thanks", cause=cause, repeated=last)
                else:
                    self._speaker.say("talk", "nothing_to_repeat", cause=cause)
            case "status":
                self._status(meaning, spoken_of, cause)
            case _:
                pass

    def _status(  # noqa: PLR0912 - one case per topic
        self, meaning: Interpretation, spoken_of: tuple[ObjectSpec, ...], cause: str
    ) -> None:
        state = self._situation.state
        match meaning.status:
            case "ability":
                self._speaker.say("talk", "ability", cause=cause)
            case "place" if state is not None and state.current_location:
                self._speaker.say("talk", "at_place", cause=cause, place=f"the {state.current_location}")
            case "place" if state is not None and state.destination_location:
                self._speaker.say("talk", "on_the_way", cause=cause, place=f"the {state.destination_location}")
            case "place":
                self._speaker.say("talk", "somewhere", cause=cause)
            case "object" if spoken_of:
                self._asked_about = spoken_of[0].type
                self._where(spoken_of[0], cause)
            case "stock" if wanted := self._in_question(meaning, spoken_of):
                self._stock(wanted, cause)
            case "duration" if state is not None and state.step not in _RESTING and len(state.queue) > 1:
                self._progress(state, cause)
            case "duration" if state is not None and state.step not in _RESTING:
                self._speaker.say("talk", "duration", cause=cause, doing=self._doing(state))
            case "object" if state is not None and state.holding:
                self._speaker.say("talk", "object_held", cause=cause, object=called(state.holding[0]))
            case "object" | "stock":
                self._speaker.say("ask", "which_object", cause=cause)
            case "finished" if self._situation.pending is None and (state is None or state.step in _RESTING):
                self._speaker.say("talk", "finished", cause=cause)
            case "finished" if state is not None and state.step not in _RESTING:
                self._speaker.say("talk", "not_finished", cause=cause, doing=self._doing(state))
            case _ if state is None or state.step in _RESTING:
                self._idle(cause)
            case _:
                self._speaker.say("doing", "as_it_is", cause=cause, repeated=self._doing(state))

    def _in_question(self, meaning: Interpretation, spoken_of: tuple[ObjectSpec, ...]) -> ObjectSpec | None:
        """The object that a question about the stock means; "a blue one" is of the kind that was asked about before."""
        pointed_at = next(iter(meaning.add), None)
        found = spoken_of[0] if spoken_of else pointed_at
        if found is None or not (found.type or self._asked_about):
            return None
        found = replace(found, type=found.type or self._asked_about)
        self._asked_about = found.type
        return found

    def _idle(self, cause: str) -> None:
        asked = self._situation.pending
        if asked is None:
            self._speaker.say("talk", "idle", cause=cause)
            return
        self._speaker.take_back((asked.reply,), cause)
        reply = self._speaker.say("talk", "waiting_for_answer", cause=cause, question=asked.text)
        self._situation.pending = replace(asked, reply=reply.id)

    def _progress(self, state: RobotState, cause: str) -> None:
        done = sum(item.status == "delivered" for item in state.queue)
        if done == 0:
            self._speaker.say("talk", "just_begun", cause=cause, object=called(state.object))
            return
        words = f"{number_word(done)} of {number_word(len(state.queue))}"
        self._speaker.say("talk", "progress", cause=cause, done=sentence_case(words), object=called(state.object))

    def _doing(self, state: RobotState) -> str:
        step = state.step if self._speaker.knows("doing", state.step) else "other"
        place = f"the {state.destination_location or state.current_location or 'table'}"
        return self._speaker.word("doing", step, object=called(state.object), place=place)

    def _where(self, spec: ObjectSpec, cause: str) -> None:
        held = self._situation.state.holding if self._situation.state else ()
        if any(is_described_by(spec, replace(item, location="", name="")) for item in held):
            self._speaker.say("talk", "object_held", cause=cause, object=called(spec))
            return
        known = [item for item in self._known(spec) if item.location]
        # "My cup" is first of all the one that the robot has just brought.
        brought = [item for item in known if replace(item, location="", name="") in self._situation.in_use]
        known = brought[-1:] or known
        if not known:
            self._speaker.say("talk", "object_unknown", cause=cause)
        elif len(known) == 1:
            name = the(known[0] if brought else spec)
            self._speaker.say("talk", "object_at", cause=cause, object=name, where=where(known[0].location))
        else:
            self._speaker.say("talk", "objects_at", cause=cause, objects=placed(known[:_TOLD], the, verb=True))

    def _stock(self, spec: ObjectSpec, cause: str) -> None:
        known = self._known(spec)
        if not known:
            self._speaker.say("talk", "stock_no", cause=cause)
        elif len(known) == 1:
            self._speaker.say("talk", "stock_yes", cause=cause, objects=placed(known, an_existing))
        else:
            told = placed(known[:_TOLD], an_existing)
            count = counted(spec, len(known))
            situation = "stock_some" if len(known) > _TOLD else "stock_all"
            self._speaker.say("talk", situation, cause=cause, all=count, objects=told)

    def _known(self, spec: ObjectSpec) -> list[ObjectSpec]:
        """What fits, wherever it is; a place is asked for only where it was named."""
        return [
            item for item in self._situation.known
            if is_described_by(replace(spec, location=""), item) and spec.location in {"", item.location}
        ]  # fmt: skip
