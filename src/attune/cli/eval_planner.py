"""`attune eval planner`: whether every command is carried out, whatever it interrupts."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class RobotChoice(StrEnum):
    """Which simulated robot."""

    SYMBOLIC = "symbolic"
    MUJOCO = "mujoco"


def eval_planner(
    robot: Annotated[RobotChoice, typer.Option(help="Without physics, or with.")] = RobotChoice.SYMBOLIC,
    quick: Annotated[bool, typer.Option("--quick", help="A random sample: 400 runs, 10 with physics.")] = False,
    sample: Annotated[int, typer.Option(min=0, help="A sample of this size; 0 plays all.")] = 0,
    seed: Annotated[int, typer.Option(help="Of camera and motion planning.")] = 0,
    jobs: Annotated[int, typer.Option(min=0, help="Processes; 0 takes one for each core.")] = 0,
    out: Annotated[Path, typer.Option(help="Gets planner.md and planner.json.")] = Path("planner-evaluation"),
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Play all permutations of the paper's planner test, and each interruption at each step of the plan.

    All of them take minutes without physics, and days with it: give a sample there.

    Example: attune eval planner --robot mujoco --sample 40
    """
    import os

    from attune.cli.reports import progress, show_report
    from attune.evaluation.planner import evaluate_planner
    from attune.evaluation.planner_report import to_data, to_markdown

    runs = sample or (0 if not quick else 400 if robot is RobotChoice.SYMBOLIC else 10)
    with progress("planning") as advance:
        evaluation = evaluate_planner(
            robot.value, seed=seed, sample=runs, jobs=jobs or os.cpu_count() or 1, on_progress=advance
        )
    show_report("planner", to_markdown(evaluation), to_data(evaluation), out, as_json=as_json)
