"""The report of the robot's evaluation: by object type, by place, and every trial that went wrong."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from attune.evaluation.robot import RobotEvaluation, Trial


def to_data(evaluation: RobotEvaluation) -> dict[str, Any]:
    """Everything, as JSON can hold it."""
    trials = evaluation.trials
    good = [trial for trial in trials if not trial.problem]
    return {
        "seed": evaluation.seed,
        "trials": len(trials),
        "succeeded": len(good),
        "without_retry": sum(not trial.retries for trial in good),
        "retries": sum(trial.retries for trial in trials),
        "with_something_cleared": sum(bool(trial.cleared) for trial in trials),
        "forbidden_contacts": sum(len(trial.contacts) for trial in trials),
        "placement_error_mm": _spread([1000 * trial.error for trial in good]),
        "robot_time_s": _spread([trial.robot_time for trial in good]),
        "computing_time_s": _spread([trial.computing_time for trial in trials]),
        "grasp_search_ms": _spread([1000 * seconds for trial in trials for seconds in trial.searches]),
        "simulated_s_per_processor_s": _speed(trials),
        "by_type": _groups(trials, lambda trial: trial.draw.type),
        "from": _groups(trials, lambda trial: trial.draw.source),
        "to": _groups(trials, lambda trial: trial.draw.goal),
        "setbacks": dict(Counter(text for trial in trials for text in trial.setbacks).most_common()),
        "contacts": dict(Counter(text for trial in trials for text in trial.contacts).most_common()),
        "failures": [
            {
                "trial": trial.draw.number,
                "task": _task(trial),
                "problem": trial.problem,
                "retries": trial.retries,
                "setbacks": trial.setbacks,
                "contacts": trial.contacts,
                "robot_time_s": round(trial.robot_time, 1),
                "computing_time_s": round(trial.computing_time, 1),
            }
            for trial in trials
            if trial.problem
        ],
        "cleared": {trial.draw.number: trial.cleared for trial in trials if trial.cleared},
        "touched": {trial.draw.number: trial.contacts for trial in trials if trial.contacts},
        "not_possible": dict(Counter(draw.why_not for draw in evaluation.impossible).most_common()),
    }


def to_markdown(evaluation: RobotEvaluation) -> str:
    """For people."""
    data = to_data(evaluation)
    lines = [
        f"# Fetch and place: {data['succeeded']} of {data['trials']}",
        "",
        f"Random objects, places, clutter and motion planning; seed {evaluation.seed}. Success: the planner reports it "
        "done, the object stands upright within 4 cm of its spot, nothing else was moved or knocked over, and every "
        "door is closed. What was in the way may have been moved, if the robot told so, stands upright and is where "
        "the robot believes it.",
        "",
        "| | |",
        "|---|---|",
        f"| Succeeded | {data['succeeded']} of {data['trials']} |",
        f"| of these without a retry | {data['without_retry']} |",
        f"| Retries | {data['retries']} |",
        f"| Tasks in which something was moved out of the way first | {data['with_something_cleared']} |",
        f"| Forbidden contacts | {data['forbidden_contacts']} |",
        f"| Placement error [mm] | {_words(data['placement_error_mm'])} |",
        f"| Robot time [s] | {_words(data['robot_time_s'])} |",
        f"| Search for a grasp and a base pose [ms of processor time] | {_words(data['grasp_search_ms'])} |",
        f"| Simulated seconds per processor second, planning included | {data['simulated_s_per_processor_s']} |",
        f"| Draws that are not possible (not counted) | {len(evaluation.impossible)} |",
    ]
    for title, key in (("Object", "by_type"), ("From", "from"), ("To", "to")):
        lines += ["", f"| {title} | Succeeded | Retries |", "|---|---|---|"]
        lines += [f"| {name} | {row['succeeded']} of {row['trials']} | {row['retries']} |"
                  for name, row in data[key].items()]  # fmt: skip
    lines += ["", f"## Failed: {len(data['failures'])}", ""]
    if data["failures"]:
        lines += [f"Each can be played alone: `attune eval robot --seed {evaluation.seed} --only NUMBER`.", ""]
    for failure in data["failures"]:
        lines.append(f"- {failure['trial']}: {failure['task']}: {failure['problem']}; retries: {failure['retries']}")
        lines += [f"    - {text}" for text in (*failure["setbacks"], *failure["contacts"])]
    if data["touched"]:
        lines += ["", "## Trials with forbidden contacts", ""]
        lines += [f"- {number}: {'; '.join(contacts)}" for number, contacts in data["touched"].items()]
    for title, key in (("Setbacks on the way", "setbacks"), ("Contacts", "contacts"), ("Not possible", "not_possible")):
        lines += ["", f"## {title}", ""]
        lines += [f"- {count} x {text}" for text, count in data[key].items()]
    return "\n".join(lines) + "\n"


def _task(trial: Trial) -> str:
    return f"{trial.draw.size} {trial.draw.type} from {trial.draw.source} to {trial.draw.goal}"


def _groups(trials: Iterable[Trial], key: Callable[[Trial], str]) -> dict[str, dict[str, int]]:
    groups: dict[str, list[Trial]] = {}
    for trial in trials:
        groups.setdefault(key(trial), []).append(trial)
    return {
        name: {
            "trials": len(members),
            "succeeded": sum(not trial.problem for trial in members),
            "retries": sum(trial.retries for trial in members),
        }
        for name, members in sorted(groups.items())
    }


def _spread(values: Sequence[float]) -> dict[str, float]:
    if not values:
        return {}
    return {
        "mean": round(float(np.mean(values)), 1),
        "median": round(float(np.median(values)), 1),
        "p99": round(float(np.quantile(values, 0.99)), 1),
        "max": round(max(values), 1),
    }


def _words(values: dict[str, float]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())


def _speed(trials: Sequence[Trial]) -> float:
    computing = sum(trial.computing_time for trial in trials)
    return round(sum(trial.robot_time for trial in trials) / computing, 1) if computing else 0.0
