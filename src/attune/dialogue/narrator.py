"""Tells what the robot does (before it moves) and how it ended, as much as the person wants to hear."""

from attune.core.messages import CommandOutcome, ObjectSpec, Reply, RobotState
from attune.dialogue.speaker import Speaker
from attune.dialogue.wording import an, called, noun, the, where

_DELIVERING = frozenset({"bring_me", "replace_object"})
_FULL_STORY = frozenset({"search_there", "drive", "shift", "reach", "arm", "set_down", "tidy"})
"""Situations that are told only where everything is: each is a movement."""
_WORKING = frozenset(
    {"set_parameters", "transporting_search", "transporting_fetch", "transporting_deliver", "recovering", "clearing"}
)
_INCLUDED = {
    "search_there": ("drive",), "carry": ("drive", "arm"), "return": ("drive", "arm"),
    "tidy": ("drive", "shift", "arm"),
}  # fmt: skip
"""What an announcement says besides, so that it is not said again in the same step."""


class Narrator:
    """Announces robot states and outcomes.

    Args:
        speaker: Who says it.
    """

    def __init__(self, speaker: Speaker) -> None:
        self._speaker = speaker
        self._last: RobotState | None = None
        self._told: set[str] = set()
        self._deferred: set[str] = set()
        self._refused: tuple[str, str] = ("", "")
        self._carried = ""

    def state(self, state: RobotState) -> None:
        """A new state of the robot: announce the step or movement that begins now."""
        last, self._last = self._last, state
        new_step = last is None or (last.step, str(last.object)) != (state.step, str(state.object))
        elsewhere = last is None or last.destination_location != state.destination_location
        if new_step or elsewhere:
            self._told.clear()
        announce = self._speaker.policy.announce
        everything = announce == "everything"
        situation = _what_begins(state, new_step=new_step, elsewhere=elsewhere, everything=everything)
        if situation == "carry" and not everything:
            # After a change of mind or a stop the same thing is carried on: that is no news.
            carried, self._carried = self._carried, state.object.name
            situation = "" if carried == state.object.name else situation
        elif not state.holding:
            self._carried = ""
        wanted = situation and announce != "results" and situation not in self._told and (
            everything or (situation not in _FULL_STORY and self._speaker.knows("announce", situation, exactly=True))
        )  # fmt: skip
        if not wanted:
            if new_step or elsewhere:
                self._speaker.take_back_announcements(state.id)
            return
        self._told |= {situation, *_INCLUDED.get(situation, ())}
        place = state.destination_location or state.current_location
        self._speaker.say(
            "announce", situation, cause=state.id, urgency="background", object=_the_or_it(state.object),
            place=_at(place), where=where(place),
        )  # fmt: skip

    def outcome(self, outcome: CommandOutcome, *, several: bool) -> Reply | None:
        """What became of a command.

        Args:
            outcome: The outcome.
            several: The command was about several objects; the end of each is told only to who wants all.

        Returns:
            The question that was asked with it, if one was.
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
                return self._failed(outcome, several, slots)
            case "deferred":
                if outcome.command not in self._deferred:
                    self._deferred.add(outcome.command)
                    self._speaker.say("deferred", "atomic_step", cause=outcome.id)
            case _:
                pass
        return None

    def _done(self, outcome: CommandOutcome, several: bool, slots: dict[str, str]) -> None:
        self._deferred.discard(outcome.command)
        if outcome.object == ObjectSpec():
            kind = "setting_breakfast" if outcome.kind == "setting_breakfast" else "everything"
            if several:
                self._speaker.say("done", kind, cause=outcome.id)
            return
        if several and self._speaker.policy.announce == "results":
            return
        if outcome.reason == "already_there":
            self._speaker.say("failed", "already_there", cause=outcome.id, object=slots["object"], where=slots["where"])
            return
        kind = "bring_me" if outcome.kind == "setting_breakfast" else outcome.kind
        if not outcome.place and kind in _DELIVERING:
            kind = "everything"
        if self._speaker.knows("done", kind):
            self._speaker.say(
                "done", kind, cause=outcome.id, object=slots["object"], place=slots["place"], where=slots["where"],
                thing=slots["thing"],
            )  # fmt: skip

    def _failed(self, outcome: CommandOutcome, several: bool, slots: dict[str, str]) -> Reply | None:
        self._deferred.discard(outcome.command)
        if outcome.behind is not None:
            hider = outcome.behind
            self._speaker.say("failed", "may_hide", cause=outcome.id, object=called(hider), where=where(hider.location))
        if outcome.alternative is not None and outcome.reason in {
            "not_found",
            "unknown_object",
            "unreachable",
            "grasp_failed",
        }:
            nearest = the(outcome.alternative)
            return self._speaker.say(
                "ask", "absent_offer", cause=outcome.id, object=noun(outcome.object), nearest=nearest
            )
        if outcome.reason in {"stopped", "replaced"}:
            return None
        if outcome.status == "failed" and outcome.object == ObjectSpec() and not outcome.reason:
            # What failed was told object by object.
            self._speaker.say("failed", "incomplete", cause=outcome.id)
            return None
        names = (f"{outcome.reason}_{outcome.kind}", outcome.reason)
        situation = next((name for name in names if self._speaker.knows("failed", name)), "other")
        if several and situation == "nothing_to_do" and outcome.object.type:
            situation = "no_more"
        if (outcome.command, situation) == self._refused and (not outcome.object.type or situation != outcome.reason):
            return None
        self._refused = (outcome.command, situation)
        if outcome.reason == "not_found" and outcome.object.type:
            slots["object"] = an(outcome.object) if outcome.status == "refused" else slots["object"]
        if outcome.reason == "unknown_place":
            slots["place"] = outcome.place or "such place"
        self._speaker.say(
            "failed", situation, cause=outcome.id, object=slots["object"], place=slots["place"], where=slots["where"],
            thing=slots["thing"],
        )  # fmt: skip
        return None


def _what_begins(state: RobotState, *, new_step: bool, elsewhere: bool, everything: bool) -> str:
    """Which step or movement begins with this state, or ""."""
    match state.step:
        case "transporting_search" if _is_returned(state):
            return _what_moves(state) if everything else ""
        case "transporting_search" if new_step or (elsewhere and everything):
            drives = everything and state.destination_location not in {"", state.current_location}
            return "search_there" if drives else "search"
        case "transporting_deliver" if new_step:
            return "return" if _is_returned(state) else "carry"
        case "recovering" | "clearing" if new_step:
            return state.step
    return _what_moves(state)


def _what_moves(state: RobotState) -> str:
    """Which movement begins with this state, or ""."""
    if not (state.move_arm or state.move_base):
        return ""
    if state.step not in _WORKING:
        return "tidy"
    there = state.current_location == state.destination_location
    if state.move_base:
        return "shift" if there else "drive" if state.destination_location else ""
    return (
        {"transporting_fetch": "reach", "transporting_deliver": "set_down"}.get(state.step, "arm") if there else "arm"
    )


def _is_returned(state: RobotState) -> bool:
    """Whether the object of this state is being brought back to where it came from."""
    return any(task.status == "returning" and task.object.name == state.object.name for task in state.queue)


def _the_or_it(spec: ObjectSpec) -> str:
    return called(spec) if spec.type or spec.color or spec.size else "it"


def _at(place: str) -> str:
    return f"the {place}" if place else "its place"
