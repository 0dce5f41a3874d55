"""The terminal view: what is heard, understood, done and said, with times, one line each."""

from collections.abc import Callable

from rich.console import Console
from rich.markup import escape

from attune.core import messages as m
from attune.core.bus import COMMAND, EVENT, OUTCOME, ROBOT_STATE, ROBOT_STOP, UTTERANCE, VOICE_STATUS, Bus
from attune.core.events import Event

STYLES = {
    "heard": "bold cyan",
    "ignored": "dim cyan",
    "understood": "green",
    "does": "blue",
    "stop": "bold red",
    "result": "magenta",
    "says": "yellow",
    "note": "dim",
}


def describe_command(command: m.Command) -> str:
    """A command in words: `bring_me small red cup to the table`."""
    match command:
        case m.BringMe(objects=objects, destination=destination):
            what = ", ".join(_object(o) for o in objects)
            return f"bring_me {what}{_to(destination)}"
        case m.ReplaceObject(remove=remove, add=add, destination=destination):
            return f"replace_object {_object(remove)} by {_object(add)}{_to(destination)}"
        case m.ChangeLocation(destination=destination, objects=objects):
            return f"change_location {', '.join(map(_object, objects)) or 'everything'}{_to(destination)}"
        case m.CancelObject(object=spec) | m.PutBack(object=spec):
            return f"{command.kind} {_object(spec) if spec != m.ObjectSpec() else ''}".rstrip()
        case _:
            return command.kind


def describe_state(state: m.RobotState) -> str:
    """The robot's state in words: `transporting_deliver the white cup, driving to the table, holding white cup`."""
    parts = [state.step + (f" the {state.object}" if state.object != m.ObjectSpec() else "")]
    if state.move_base and state.destination_location:
        parts.append(f"driving to the {state.destination_location}")
    elif state.current_location:
        parts.append(f"at the {state.current_location}")
    if state.move_arm:
        parts.append("moving the arm")
    if state.holding:
        parts.append("holding " + " and ".join(f"the {spec}" for spec in state.holding))
    if not state.interruptible:
        parts.append("not interruptible")
    return ", ".join(parts)


def describe_outcome(outcome: m.CommandOutcome) -> str:
    """An outcome in words: `bring_me refused (not_found): red bowl`."""
    reason = f" ({outcome.reason})" if outcome.reason else ""
    about = f": {outcome.object}" if outcome.object != m.ObjectSpec() else ""
    return f"{outcome.kind} {outcome.status}{reason}{about}"


def describe_plan(node: m.PlanNode) -> str:
    """The running branch of a plan: `bring white cup › deliver › navigate`."""
    branch = []
    current: m.PlanNode | None = node
    while current is not None and current.status == "running":
        branch.append(current.name)
        current = next((child for child in current.children if child.status == "running"), None)
    return " › ".join(branch)


def _object(spec: m.ObjectSpec) -> str:
    return str(spec) + (f" from the {spec.location}" if spec.location else "")


def _to(destination: str) -> str:
    return f" to the {destination}" if destination else ""


class TerminalView:
    """Prints what happens on the bus as it happens.

    Args:
        bus: What to show.
        console: Where to print.
    """

    def __init__(self, bus: Bus, console: Console) -> None:
        self._console = console
        self._phase: tuple[m.Step, m.ObjectSpec, str, tuple[m.ObjectSpec, ...], bool]
        self._phase = ("idle", m.ObjectSpec(), "", (), True)
        self.forget: list[Callable[[], None]] = [
            bus.on(UTTERANCE, self._utterance),
            bus.on(EVENT, self._event),
            bus.on(COMMAND, lambda command: self._line(command.time, "understood", describe_command(command))),
            bus.on(ROBOT_STOP, lambda stop: self._line(stop.time, "stop", f"{stop.state} ({stop.source})")),
            bus.on(ROBOT_STATE, self._state),
            bus.on(OUTCOME, lambda outcome: self._line(outcome.time, "result", describe_outcome(outcome))),
            bus.on(VOICE_STATUS, self._voice),
        ]

    def note(self, time: float, text: str) -> None:
        """A line about the run itself."""
        self._line(time, "note", text)

    def _line(self, time: float, kind: str, text: str) -> None:
        style = STYLES[kind]
        self._console.print(f"[dim]{time:7.2f} s[/dim]  [{style}]{kind:<10}[/{style}]  {escape(text)}", highlight=False)

    def _utterance(self, utterance: m.Utterance) -> None:
        if utterance.is_final:
            how = "typed" if utterance.typed else f"confidence {utterance.confidence:.2f}"
            self._line(utterance.time, "heard", f"“{utterance.text}” ({how})")

    def _event(self, event: Event) -> None:
        match event.kind:
            case "ignored":
                self._line(event.time, "ignored", event.text)
            case "warning" | "error":
                self._line(event.time, "note", f"{event.kind}: {event.text}")

    def _state(self, state: m.RobotState) -> None:
        # Arms start and stop all the time, and places are passed: a line for each would bury the rest.
        driving_to = state.destination_location if state.move_base else ""
        phase = (state.step, state.object, driving_to or self._phase[2], state.holding, state.interruptible)
        if phase != self._phase:
            self._phase = phase
            self._line(state.time, "does", describe_state(state))

    def _voice(self, status: m.VoiceStatus) -> None:
        match status.state:
            case "finished":
                self._line(status.time, "says", f"“{status.spoken}”")
            case "interrupted":
                self._line(status.time, "says", f"“{status.spoken} …” (interrupted)")
