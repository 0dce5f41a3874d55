"""Tells what the robot does (before it moves) and how it ended, as much as the person wants to hear."""

from attune.core.messages import CommandOutcome, ObjectSpec, RobotState
from attune.dialogue.speaker import Speaker
from attune.dialogue.wording import an, called, noun, the, where

_DELIVERING = frozenset({"bring_me", "replace_object"})
_FULL_STORY = frozenset({"drive", "reach", "open", "set_down"})


class Narrator:
    """Announces robot states and outcomes.

    Args:
        speaker: Who says it.
    """

    def __init__(self, speaker: Speaker) -> None:
        self._speaker = speaker
        self._last: RobotState | None = None
        self._told: tuple[str, str, str] = ("", "", "")
        self._deferred: set[str] = set()

    def state(self, state: RobotState) -> None:
        """A new state of the robot: announce the step or movement that begins now."""
        last, self._last = self._last, state
        if self._speaker.policy.announce == "results":
            return
        situation = _what_begins(state, last)
        if not situation or (situation in _FULL_STORY and self._speaker.policy.announce != "everything"):
            return
        if (
            not self._speaker.knows("announce", situation, exactly=True)
            and self._speaker.policy.announce != "everything"
        ):
            return
        told = (situation, str(state.object), state.destination_location)
        if told == self._told:
            return
        self._told = told
        place = _at(state.destination_location or state.current_location)
        if situation in {"drive", "carry", "open"} and not (state.destination_location or state.current_location):
            return
        self._speaker.say(
            "announce", situation, cause=state.id, urgency="background", object=_the_or_it(state.object), place=place,
            where=where(state.destination_location or state.current_location),
        )  # fmt: skip

    def outcome(self, outcome: CommandOutcome, *, several: bool) -> str:
        """What became of a command.

        Args:
            outcome: The outcome.
            several: The command was about several objects; the end of each is told only to who wants all.

        Returns:
            The question that was asked with it, or "".
        """
        slots = {
            "object": _the_or_it(outcome.object),
            "place": _at(outcome.place),
            "where": where(outcome.place),
            "thing": outcome.object.type or "thing",
        }
        match outcome.status:
            case "done":
                self._done(outcome, several, slots)
            case "failed" | "refused":
                return self._failed(outcome, slots)
            case "deferred":
                if outcome.command not in self._deferred:
                    self._deferred.add(outcome.command)
                    self._speaker.say("deferred", "atomic_step", cause=outcome.id)
            case _:
                pass
        return ""

    def _done(self, outcome: CommandOutcome, several: bool, slots: dict[str, str]) -> None:
        self._deferred.discard(outcome.command)
        if outcome.object == ObjectSpec():
            kind = "setting_breakfast" if outcome.kind == "setting_breakfast" else "everything"
            if several:
                self._speaker.say("done", kind, cause=outcome.id)
            return
        if several and self._speaker.policy.announce == "results":
            return
        kind = "bring_me" if outcome.kind == "setting_breakfast" else outcome.kind
        if not outcome.place and kind in _DELIVERING:
            kind = "everything"
        if self._speaker.knows("done", kind):
            self._speaker.say(
                "done", kind, cause=outcome.id, object=slots["object"], place=slots["place"], where=slots["where"],
                thing=slots["thing"],
            )  # fmt: skip

    def _failed(self, outcome: CommandOutcome, slots: dict[str, str]) -> str:
        self._deferred.discard(outcome.command)
        if outcome.alternative is not None and outcome.reason in {
            "not_found",
            "unknown_object",
            "unreachable",
            "grasp_failed",
        }:
            nearest = the(outcome.alternative)
            offer = self._speaker.say(
                "ask", "absent_offer", cause=outcome.id, object=noun(outcome.object), nearest=nearest
            )
            return offer.text
        if outcome.reason in {"stopped", "replaced"}:
            return ""
        if outcome.status == "failed" and outcome.object == ObjectSpec() and not outcome.reason:
            # What failed was told object by object.
            self._speaker.say("failed", "incomplete", cause=outcome.id)
            return ""
        situation = outcome.reason if self._speaker.knows("failed", outcome.reason) else "other"
        if outcome.reason == "not_found" and outcome.object.type:
            slots["object"] = an(outcome.object) if outcome.status == "refused" else slots["object"]
        if outcome.reason == "unknown_place":
            slots["place"] = outcome.place or "such place"
        self._speaker.say(
            "failed", situation, cause=outcome.id, object=slots["object"], place=slots["place"], where=slots["where"],
            thing=slots["thing"],
        )  # fmt: skip
        return ""


def _what_begins(state: RobotState, last: RobotState | None) -> str:
    """Which step or movement begins with this state, or ""."""
    new_step = last is None or last.step != state.step or str(last.object) != str(state.object)
    moves_base = state.move_base and (
        last is None or not last.move_base or last.destination_location != state.destination_location or new_step
    )
    moves_arm = state.move_arm and (last is None or not last.move_arm or new_step)
    match state.step:
        case "transporting_search":
            return "search" if new_step else "drive" if moves_base else "open" if moves_arm else ""
        case "transporting_fetch":
            return "drive" if moves_base else "reach" if moves_arm else ""
        case "transporting_deliver":
            there = state.current_location == state.destination_location
            if _is_returned(state) and (moves_base or new_step):
                return "return"
            return "carry" if moves_base or new_step else "set_down" if moves_arm and there else ""
        case "recovering":
            return "recovering" if new_step else ""
        case _:
            return ""


def _is_returned(state: RobotState) -> bool:
    """Whether the object of this state is being brought back to where it came from."""
    return any(task.status == "returning" and task.object.name == state.object.name for task in state.queue)


def _the_or_it(spec: ObjectSpec) -> str:
    return called(spec) if spec.type or spec.color or spec.size else "it"


def _at(place: str) -> str:
    return f"the {place}" if place else "its place"
