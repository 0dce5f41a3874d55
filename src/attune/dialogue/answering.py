"""Answers to remarks and questions: thanks, "what are you doing?", "where is my cup?", "say that again"."""

from attune.core.messages import ObjectSpec, RobotState
from attune.dialogue.interpreter import Interpretation
from attune.dialogue.situation import Situation
from attune.dialogue.speaker import Speaker
from attune.dialogue.wording import an_existing, called, listed, noun, number_word, sentence_case, where

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

    def answer(self, meaning: Interpretation, spoken_of: tuple[ObjectSpec, ...], last: str, cause: str) -> None:
        """Say something fitting.

        Args:
            meaning: What was meant.
            spoken_of: The objects that the utterance names.
            last: What the robot said last.
            cause: Id of the utterance.
        """
        match meaning.intent:
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

    def _status(self, meaning: Interpretation, spoken_of: tuple[ObjectSpec, ...], cause: str) -> None:
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
            case "object" | "stock" if spoken_of:
                self._where(meaning, spoken_of[0], cause)
            case "duration" if state is not None and state.step not in _RESTING and len(state.queue) > 1:
                self._progress(state, cause)
            case "object" if state is not None and state.holding:
                self._speaker.say("talk", "object_held", cause=cause, object=called(state.holding[0]))
            case _:
                self._doing(state, cause)

    def _progress(self, state: RobotState, cause: str) -> None:
        done = sum(item.status == "delivered" for item in state.queue)
        if done == 0:
            self._speaker.say("talk", "just_begun", cause=cause, object=called(state.object))
            return
        words = f"{number_word(done)} of {number_word(len(state.queue))}"
        self._speaker.say("talk", "progress", cause=cause, done=sentence_case(words), object=called(state.object))

    def _doing(self, state: RobotState | None, cause: str) -> None:
        if state is None or state.step in _RESTING:
            self._speaker.say("talk", "idle", cause=cause)
            return
        step = state.step if self._speaker.knows("doing", state.step) else "other"
        place = f"the {state.destination_location or state.current_location or 'table'}"
        self._speaker.say("doing", step, cause=cause, object=called(state.object), place=place)

    def _where(self, meaning: Interpretation, spec: ObjectSpec, cause: str) -> None:
        held = self._situation.state.holding if self._situation.state else ()
        if any(item.type == spec.type and (not spec.color or item.color == spec.color) for item in held):
            self._speaker.say("talk", "object_held", cause=cause, object=called(spec))
            return
        known = [
            item for item in self._situation.known
            if item.type == spec.type and spec.color in {"", item.color} and spec.size in {"", item.size}
        ]  # fmt: skip
        if meaning.status == "stock":
            names = listed([f"{an_existing(item)} {where(item.location)}" for item in known[:3]])
            self._speaker.say("talk", "stock_yes" if known else "stock_no", cause=cause, objects=names)
        elif known and known[0].location:
            chosen = known[0]
            name = noun(chosen if len(known) > 1 else spec)
            self._speaker.say("talk", "object_at", cause=cause, object=f"the {name}", where=where(chosen.location))
        else:
            self._speaker.say("talk", "object_unknown", cause=cause)
