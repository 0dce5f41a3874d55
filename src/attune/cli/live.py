"""`attune live`: type or speak to the running robot in a terminal."""

from __future__ import annotations

import signal
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    import anyio
    from rich.console import Console

    from attune.cli.view import TerminalView
    from attune.core.config import Config
    from attune.core.messages import AgeEstimate
    from attune.session.session import Session
    from attune.speech.audio import AudioSource

HELP = "Type to the robot, or just speak. Ctrl-C or “stop” halts it; Ctrl-C twice or Ctrl-D ends."
QUIT_WITHIN = 2.0
"""Seconds in which a second Ctrl-C ends the program."""


class AgeBand(StrEnum):
    """How old the person says they are."""

    younger = "younger"
    older = "older"


def live(
    text: Annotated[bool, typer.Option("--text", help="Typed text only: no microphone, no voice.")] = False,
    mute: Annotated[bool, typer.Option("--mute", help="The robot answers in text only.")] = False,
    robot: Annotated[str, typer.Option(help="mujoco, or symbolic (no physics).")] = "",
    age: Annotated[AgeBand | None, typer.Option(help="Your age band; else it is estimated.")] = None,
    config: Annotated[Path | None, typer.Option(help="A configuration file instead of ./attune.toml.")] = None,
) -> None:
    """Talk to the robot in its kitchen, in real time, and interrupt it whenever you like.

    Example: attune live --text
    """
    import anyio

    from attune.core.config import load_config, with_values
    from attune.core.log import configure_logging

    configure_logging()
    settings = load_config(config)
    changes = {"robot": {"kind": robot}} if robot else {}
    if mute or text:
        changes["voice"] = {"output": "none"}
    anyio.run(_live, with_values(settings, changes), not text, age)


async def _live(config: Config, listen: bool, age: AgeBand | None) -> None:
    import anyio
    from prompt_toolkit.patch_stdout import patch_stdout
    from rich.console import Console

    from attune.cli.view import TerminalView
    from attune.core.clock import RealClock
    from attune.core.messages import AgeEstimate
    from attune.dialogue.profiles import ProfileStore
    from attune.session.remote import default_socket, serve
    from attune.session.session import Session

    clock = RealClock()
    interactive = sys.stdin.isatty() and sys.stdout.isatty()
    with patch_stdout(raw=True):
        console = Console(force_terminal=interactive or None)
        console.print("Waking the robot …")
        audio = _microphone(config, console) if listen else None
        session = Session(config, clock, audio=audio, profiles=ProfileStore())
        view = TerminalView(session.bus, console)
        known = AgeEstimate(band=age.value, confidence=1.0, source="stated") if age else AgeEstimate()
        async with session.running(), anyio.create_task_group() as group:
            group.start_soon(serve, session, default_socket(), name="remote")
            console.print(HELP, style="dim")
            if interactive:
                await _prompt(session, view, known)
            else:
                group.start_soon(_halt_on_interrupt, session, group.cancel_scope)
                await _read_lines(session, known)
            group.cancel_scope.cancel()


def _microphone(config: Config, console: Console) -> AudioSource | None:
    from attune.core.errors import AttuneError
    from attune.speech.audio import Microphone

    try:
        return Microphone(config.speech.microphone)
    except AttuneError as error:
        console.print(f"Not listening: {error} You can type.", style="yellow")
        return None


async def _prompt(session: Session, view: TerminalView, age: AgeEstimate) -> None:
    """Read lines from a terminal whose last line shows the robot's state and plan."""
    from prompt_toolkit import PromptSession

    prompt: PromptSession[str] = PromptSession(
        "you › ", bottom_toolbar=lambda: _status_line(session), refresh_interval=0.25
    )
    last_interrupt = float("-inf")
    while True:
        try:
            line = await prompt.prompt_async()
        except EOFError:
            return
        except KeyboardInterrupt:
            now = session.clock.now()
            if now - last_interrupt < QUIT_WITHIN:
                return
            last_interrupt = now
            session.stop("keyboard")
            view.note(now, "halted; Ctrl-C again ends the program, “carry on” resumes")
            continue
        if line.strip():
            session.say(line, age)


async def _read_lines(session: Session, age: AgeEstimate) -> None:
    """Read lines from a pipe; at its end, let the robot finish."""
    import anyio.to_thread

    while line := await anyio.to_thread.run_sync(sys.stdin.readline, abandon_on_cancel=True):
        if line.strip():
            session.say(line.strip(), age)
    await session.settled()


async def _halt_on_interrupt(session: Session, scope: anyio.CancelScope) -> None:
    """The first Ctrl-C halts the robot, the second ends the program."""
    import anyio

    with anyio.open_signal_receiver(signal.SIGINT) as signals:
        last = float("-inf")
        async for _ in signals:
            if session.clock.now() - last < QUIT_WITHIN:
                scope.cancel()
            last = session.clock.now()
            session.stop("keyboard")


def _status_line(session: Session) -> str:
    from attune.cli.view import describe_plan, describe_state
    from attune.core.bus import PLAN, ROBOT_STATE

    state, plan = session.bus.latest(ROBOT_STATE), session.bus.latest(PLAN)
    parts = [describe_state(state)] if state else []
    if plan:
        parts.append(describe_plan(plan.root))
    return "  |  ".join(part for part in parts if part)
