"""From what was meant to the commands that the planner understands."""

from attune.core.messages import (
    Band,
    BringMe,
    CancelObject,
    CarryOn,
    ChangeLocation,
    Command,
    ObjectSpec,
    PutBack,
    ReplaceObject,
    SettingBreakfast,
    Stop,
)
from attune.dialogue.context import Context
from attune.dialogue.grammar.references import is_described_by
from attune.dialogue.interpreter import Interpretation


def commands_for(  # noqa: PLR0911 - one rule per return
    meaning: Interpretation, context: Context, *, now: float, cause: str, band: Band
) -> tuple[Command, ...]:
    """The commands for a meaning, in the order in which they take effect; none for talk.

    Args:
        meaning: What the person wants.
        context: The situation.
        now: The time [s].
        cause: Id of the utterance.
        band: The person's age band.
    """
    match meaning.intent:
        case "bring_me":
            return (BringMe(time=now, cause=cause, band=band, objects=meaning.add, destination=meaning.destination),)
        case "setting_breakfast":
            return (SettingBreakfast(time=now, cause=cause, band=band),)
        case "replace_object":
            return _replacing(meaning, now, cause, band)
        case "change_location":
            objects = tuple(_as_known(spec, context) for spec in meaning.add)
            return (ChangeLocation(time=now, cause=cause, band=band, destination=meaning.destination, objects=objects),)
        case "cancel_object":
            return tuple(
                CancelObject(time=now, cause=cause, band=band, object=_as_known(spec, context))
                for spec in meaning.remove
            )
        case "put_back":
            objects = tuple(_as_known(spec, context) for spec in meaning.remove) or (ObjectSpec(),)
            return tuple(PutBack(time=now, cause=cause, band=band, object=spec) for spec in objects)
        case "carry_on":
            return (CarryOn(time=now, cause=cause, band=band),)
        case "stop":
            return (Stop(time=now, cause=cause, band=band),)
        case _:
            return ()


def _replacing(meaning: Interpretation, now: float, cause: str, band: Band) -> tuple[Command, ...]:
    """A replacement for each pair; what is left over on one side is brought, or cancelled."""
    pairs = tuple(zip(meaning.remove, meaning.add, strict=False))
    commands: list[Command] = [
        ReplaceObject(time=now, cause=cause, band=band, remove=old, add=new, destination=meaning.destination)
        for old, new in pairs
    ]
    more = meaning.add[len(pairs) :]
    if more:
        commands.append(BringMe(time=now, cause=cause, band=band, objects=more, destination=meaning.destination))
    commands += [CancelObject(time=now, cause=cause, band=band, object=old) for old in meaning.remove[len(pairs) :]]
    return tuple(commands)


def _as_known(spec: ObjectSpec, context: Context) -> ObjectSpec:
    """The one object of the task that fits, so that "the cup" cancels the red cup that is on its way."""
    fitting = [has for has in context.recent if is_described_by(spec, has)]
    return fitting[0] if len(set(fitting)) == 1 else spec
