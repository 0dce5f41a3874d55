"""`attune demo`: the paper's two scenarios, spoken by a synthetic person through the whole audio path."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from attune.core.config import Config
    from attune.evaluation.scenarios import Scenario
    from attune.evaluation.trial import TrialResult
    from attune.session.session import Session


class Choice(StrEnum):
    """The scenarios."""

    bring_me = "bring_me"
    breakfast = "breakfast"


def demo(
    scenario: Annotated[Choice | None, typer.Argument(help="One scenario; without it, both.")] = None,
    fast: Annotated[bool, typer.Option("--fast", help="Virtual time: as fast as the machine can.")] = False,
    text: Annotated[bool, typer.Option("--text", help="The person types: no audio.")] = False,
    voice: Annotated[str, typer.Option(help="Where the robot's voice goes: speaker, file or none.")] = "none",
    as_json: Annotated[bool, typer.Option("--json", help="Print the verdicts as JSON, nothing else.")] = False,
    config: Annotated[Path | None, typer.Option(help="A configuration file instead of ./attune.toml.")] = None,
) -> None:
    """Show a robot that is talked to, and interrupted, in its kitchen; exit status 1 if the verdict is bad.

    Example: attune demo bring_me --fast
    """
    import json

    from rich.console import Console

    from attune.core.config import load_config, with_values
    from attune.core.log import configure_logging
    from attune.evaluation.scenarios import SCENARIOS

    configure_logging()
    settings = with_values(load_config(config), {"voice": {"output": voice}})
    console = Console(quiet=as_json, soft_wrap=True)
    results: dict[str, TrialResult] = {}
    for name in [scenario.value] if scenario else list(SCENARIOS):
        results[name] = _play(SCENARIOS[name], settings, console, fast=fast, text=text)
    if as_json:
        verdicts = {
            name: {
                "passed": result.passed,
                "repetitions": result.repetitions,
                "robot_time": round(result.robot_time, 2),
                "checks": [{"claim": c.claim, "holds": c.holds, "detail": c.detail} for c in result.checks],
            }
            for name, result in results.items()
        }
        typer.echo(json.dumps(verdicts, indent=2))
    console.print("\nNow talk to the robot yourself: [bold]make live[/bold]  (or [bold].venv/bin/attune live[/bold])")
    if not all(result.passed for result in results.values()):
        raise typer.Exit(1)


def _play(scenario: Scenario, config: Config, console: Console, *, fast: bool, text: bool) -> TrialResult:
    from attune.cli.view import TerminalView
    from attune.core.clock import RealClock, VirtualClock, run
    from attune.evaluation.speakers import Speaker, UserAudio
    from attune.evaluation.trial import run_trial

    console.rule(scenario.title)
    clock = VirtualClock() if fast else RealClock()
    user = None if text else UserAudio(clock, Speaker())

    def watch(session: Session) -> None:
        TerminalView(session.bus, console)

    result = run(lambda: run_trial(scenario, config, clock, user, watch), clock)
    for check in result.checks:
        mark = "[green]✓[/green]" if check.holds else "[red]✗[/red]"
        console.print(f"  {mark} {check.claim}" + (f"  [dim]{check.detail}[/dim]" if check.detail else ""))
    word = "[bold green]passed[/bold green]" if result.passed else "[bold red]failed[/bold red]"
    console.print(f"  {word} after {result.robot_time:.0f} s of robot time, {result.repetitions} repetitions")
    return result
