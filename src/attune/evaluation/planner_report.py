"""The report of the planner's evaluation: the paper's table with ours beside it, and every command that went wrong."""

from collections import Counter
from collections.abc import Iterable
from typing import Any

from attune.evaluation.planner import PlannerEvaluation, Run, failures
from attune.evaluation.planner_judge import Status, Verdict
from attune.evaluation.planner_sayings import Part

PAPER: dict[str, dict[str, float]] = {
    "bring_me": {"bring_me": 50, "replace_object": 48, "ignored": 2},
    "setting_breakfast": {"setting_breakfast": 46, "bring_me": 42, "stop": 4, "ignored": 8},
}
"""The paper's module test: percent of the received commands that were executed, by kind, and ignored."""
SCENARIOS: dict[str, str] = {"bring_me": "1: bring_me", "setting_breakfast": "2: setting_breakfast"}
PARTS: dict[Part, str] = {
    "paper": "The paper's test",
    "every step": "The paper's commands, interrupted at every step",
    "each other": "Each command, also those that the paper does not have, interrupted by each other at every step",
}
STATUSES: tuple[Status, ...] = ("executed", "refused", "ignored", "failed")


def to_data(evaluation: PlannerEvaluation) -> dict[str, Any]:
    """Everything, as JSON can hold it."""
    return {
        "robot": evaluation.robot,
        "seed": evaluation.seed,
        "runs": len(evaluation.runs),
        "permutations": evaluation.of_all,
        "paper": PAPER,
        "results": [
            {"part": part, "scenario": scenario, "command": kind, **{status: count[status] for status in STATUSES}}
            for (part, scenario, kind), count in _counts(evaluation.runs).items()
        ],
        "robot_time_s": round(sum(run.robot_time for run in evaluation.runs), 1),
        "processor_time_s": round(sum(run.computing_time for run in evaluation.runs), 1),
        "failures": [
            {"run": str(run.permutation), "command": str(verdict.saying), "status": verdict.status,
             "reason": verdict.reason}
            for run, verdict in failures(evaluation.runs)
        ],
    }  # fmt: skip


def to_markdown(evaluation: PlannerEvaluation) -> str:
    """For people."""
    runs, count = evaluation.runs, len(evaluation.runs)
    sampled = "" if count == evaluation.of_all else f" (a random sample of {evaluation.of_all})"
    hours = sum(run.robot_time for run in runs) / 3600
    minutes = sum(run.computing_time for run in runs) / 60
    lines = [
        f"# Planner test: {evaluation.robot} robot",
        "",
        f"{count} runs{sampled}, {sum(len(run.verdicts) for run in runs)} commands; {hours:.1f} hours of robot time in "
        f"{minutes:.1f} minutes of processor time; seed {evaluation.seed}.",
        "",
        "Executed: the simulated world at the end is what was asked for. Refused: nothing could be done, and the "
        "reason was told. Ignored: it could have been done. Failed: the world is wrong.",
    ]
    for part, title in PARTS.items():
        members = [run for run in runs if run.permutation.part == part]
        if members:
            lines += ["", f"## {title}: {len(members)} runs", "", *_table(members, beside_paper=part == "paper")]
    wrong = failures(runs)
    lines += ["", f"## Ignored or failed: {len(wrong)}", ""]
    lines += [
        f"- {run.permutation}: {verdict.saying.kind} {verdict.status}, {verdict.reason}" for run, verdict in wrong
    ]
    return "\n".join(lines) + "\n"


def executed_share(verdicts: Iterable[Verdict]) -> float:
    """Share of the commands that could be carried out and were [%]."""
    counts = Counter(verdict.status for verdict in verdicts)
    feasible = sum(counts[status] for status in STATUSES if status != "refused")
    return 100 * counts["executed"] / feasible if feasible else 100.0


def _counts(runs: Iterable[Run]) -> dict[tuple[str, str, str], Counter[str]]:
    found: dict[tuple[str, str, str], Counter[str]] = {}
    for run in runs:
        for verdict in run.verdicts:
            key = (run.permutation.part, run.permutation.scenario, verdict.saying.kind)
            found.setdefault(key, Counter())[verdict.status] += 1
    return found


def _table(runs: list[Run], *, beside_paper: bool) -> list[str]:
    head = ["Scenario", "Command", "Commands", "Executed", "Refused", "Ignored", "Failed"]
    head += ["Paper"] if beside_paper else []
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for scenario in dict.fromkeys(run.permutation.scenario for run in runs):
        title = SCENARIOS.get(scenario, scenario)
        members = [run for run in runs if run.permutation.scenario == scenario]
        all_ = [verdict for run in members for verdict in run.verdicts]
        for (_, _, kind), count in _counts(members).items():
            cells = [title, kind, str(count.total()), *(str(count[status]) for status in STATUSES)]
            if beside_paper:
                share = PAPER[scenario].get(kind)
                cells.append(f"{share:.0f} % of all executed" if share else "")
            lines.append(f"| {' | '.join(cells)} |")
        total = Counter(verdict.status for verdict in all_)
        cells = [f"**{title}**", f"**executed of feasible: {executed_share(all_):.2f} %**", str(len(all_))]
        cells += [str(total[status]) for status in STATUSES]
        if beside_paper:
            cells.append(f"**{100 - PAPER[scenario]['ignored']:.0f} %**")
        lines.append(f"| {' | '.join(cells)} |")
    return lines
