"""`attune eval robot`: how reliably the simulated robot fetches and places, in random clutter."""

from pathlib import Path
from typing import Annotated

import typer


def eval_robot(
    trials: Annotated[int, typer.Option(min=1, help="Tasks; draws that are not possible are not counted.")] = 300,
    seed: Annotated[int, typer.Option(help="Of the tasks: another seed gives other tasks.")] = 0,
    only: Annotated[
        list[int] | None,
        typer.Option(help="Number of a task from a report, to play it alone; may be repeated."),
    ] = None,
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
    out: Annotated[Path, typer.Option(help="Gets robot.md and robot.json.")] = Path("robot-evaluation"),
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Fetch random objects from random places and put them elsewhere, through the planner, with real physics.

    A trial takes some five seconds of one core. The report names each trial that went wrong; play it alone with --only.

    Example: attune eval robot --trials 50 --seed 7
    """
    import os

    from attune.cli.reports import progress, show_report
    from attune.evaluation.robot import evaluate_robot
    from attune.evaluation.robot_report import to_data, to_markdown

    with progress("fetching") as advance:
        evaluation = evaluate_robot(
            trials, seed=seed, jobs=jobs or os.cpu_count() or 1, only=only or (), on_progress=advance
        )
    show_report("robot", to_markdown(evaluation), to_data(evaluation), out, as_json=as_json)
