"""The report of the language benchmark: the paper's table with ours in it, the harder part by difficulty, errors."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, get_args

from attune.evaluation.language.items import Part
from attune.evaluation.language.scoring import PROPERTIES, Answer, Score, score

PAPER_ROWS: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("paper, 1106", (81.57, 89.08, 86.60, 68.40, 84.53, 83.12, 85.54, 83.77, 99.96)),
    ("paper, 0125", (80.93, 82.43, 88.56, 69.28, 85.48, 76.48, 84.75, 82.04, 99.99)),
)
"""The paper's table, gpt-3.5-turbo-1106 and -0125: command; type, colour, size, location of objects to add; the same
of objects to delete [%]."""
_HARDER: dict[Part, str] = {"hard": "The harder part", "fresh": "Fresh sentences of the same kinds"}


@dataclass(frozen=True, slots=True)
class LanguageReport:
    """All answers of one interpreter.

    Attributes:
        interpreter: Its name.
        model: The language model behind it; "" for the embedded interpreter.
    """

    interpreter: str
    answers: tuple[Answer, ...]
    model: str = ""

    @property
    def by_model(self) -> int:
        """Answers of the language model itself. Stops, and what it did not answer, are the embedded interpreter's."""
        return sum(f"language model {self.model}" in answer.note for answer in self.answers) if self.model else 0

    def part(self, name: Part) -> tuple[Answer, ...]:
        """The answers to one part of the benchmark."""
        return tuple(answer for answer in self.answers if answer.item.part == name)

    @property
    def errors(self) -> tuple[Answer, ...]:
        """Answers that are wrong somewhere."""
        return tuple(answer for answer in self.answers if answer.wrong)

    def to_data(self) -> dict[str, Any]:
        """Everything, as JSON can hold it."""
        return {
            "interpreter": self.interpreter,
            "answered_by_language_model": self.by_model,
            "paper": [{"model": model, "percent": list(values)} for model, values in PAPER_ROWS],
            "parts": {name: _part_data(self.part(name)) for name in get_args(Part) if self.part(name)},
            "errors": [_error_data(answer) for answer in self.errors],
        }

    def to_markdown(self) -> str:
        """For people."""
        lines = [f"# Language benchmark: {self.interpreter}", ""]
        if self.model:
            rest = "the rest by the embedded interpreter, which decides about stopping and stands in for the model"
            lines += [f"Answered by the model itself: {self.by_model} of {len(self.answers)}; {rest}.", ""]
        if paper := self.part("paper"):
            lines += [
                f"## The paper's recipe: {len(paper)} instructions",
                "",
                *_paper_table(self.interpreter, paper),
                "",
            ]
            lines += _extras(score(paper), paper)
        for name, title in _HARDER.items():
            if hard := self.part(name):
                lines += [f"## {title}: {len(hard)} utterances", "", *_group_table(hard), ""]
                lines += _extras(score(hard), hard)
        lines += [f"## Errors: {len(self.errors)}", ""]
        lines += [line for answer in self.errors for line in _error_lines(answer)]
        return "\n".join(lines) + "\n"


def _groups(answers: Sequence[Answer]) -> dict[str, tuple[Answer, ...]]:
    names = dict.fromkeys(answer.item.group for answer in answers)
    return {name: tuple(answer for answer in answers if answer.item.group == name) for name in names}


def _score_data(result: Score) -> dict[str, Any]:
    def tally(name: str) -> dict[str, int]:
        value = getattr(result, name)
        return {"count": value.right, "of": value.of}

    data: dict[str, Any] = {
        name: tally(name)
        for name in ("command", "whole", "destination", "false_commands", "missed_stops", "false_stops", "failed")
    }
    for role in ("add", "remove"):
        data[role] = {name: {"count": t.right, "of": t.of} for name, t in getattr(result, role).items()}
    return data


def _part_data(answers: Sequence[Answer]) -> dict[str, Any]:
    return {
        "items": len(answers),
        "score": _score_data(score(answers)),
        "seconds": {"median": latency(answers, 50), "p99": latency(answers, 99)},
        "groups": {name: _score_data(score(members)) for name, members in _groups(answers).items()},
    }


def _error_data(answer: Answer) -> dict[str, Any]:
    return {
        "id": answer.item.id,
        "group": answer.item.group,
        "utterance": answer.item.utterance,
        "wrong": list(answer.wrong),
        "expected": answer.item.expected.model_dump(),
        "found": answer.meaning.model_dump() if answer.meaning else None,
        "note": answer.note,
    }


def _paper_table(name: str, answers: Sequence[Answer]) -> list[str]:
    result = score(answers)
    lines = [
        "Accuracy in percent; the paper's rows are gpt-3.5-turbo-1106 and gpt-3.5-turbo-0125.",
        "",
        "| | Command | Add type | colour | size | location | Delete type | colour | size | location |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for model, values in PAPER_ROWS:
        lines.append(f"| {model} | " + " | ".join(f"{value:.2f}" for value in values) + " |")
    tallies = (result.command, *(result.add[p] for p in PROPERTIES), *(result.remove[p] for p in PROPERTIES))
    lines.append(f"| **{name}** | " + " | ".join(f"**{tally}**" for tally in tallies) + " |")
    lines += ["", "| Command | Items | Command right | Everything right |", "|---|---|---|---|"]
    for group, members in _groups(answers).items():
        part = score(members)
        lines.append(f"| {group} | {len(members)} | {part.command} | {part.whole} |")
    return lines


def _group_table(answers: Sequence[Answer]) -> list[str]:
    lines = ["| Difficulty | Items | Command right | Everything right |", "|---|---|---|---|"]
    for group, members in _groups(answers).items():
        part = score(members)
        lines.append(f"| {group} | {len(members)} | {part.command} | {part.whole} |")
    result = score(answers)
    lines.append(f"| **all** | **{len(answers)}** | **{result.command}** | **{result.whole}** |")
    for title, tallies in (("Add", result.add), ("Delete", result.remove)):
        lines += ["", f"{title}: " + ", ".join(f"{name} {tally} %" for name, tally in tallies.items())]
    return [*lines, "", f"Destination: {result.destination} %"]


def latency(answers: Sequence[Answer], percentile: float) -> float:
    """The time [s] within which so many percent of the answers came."""
    times = sorted(answer.seconds for answer in answers)
    return times[min(len(times) - 1, int(len(times) * percentile / 100))]


def _extras(result: Score, answers: Sequence[Answer]) -> list[str]:
    rows = (
        ("Commands made from non-commands", result.false_commands),
        ("Missed stops", result.missed_stops),
        ("False stops", result.false_stops),
        ("No valid answer", result.failed),
    )
    times = f"- Time for an answer: median {_ms(answers, 50)}, 99 % within {_ms(answers, 99)}"
    return [*(f"- {title}: {tally.right} of {tally.of}" for title, tally in rows if tally.of), times, ""]


def _ms(answers: Sequence[Answer], percentile: float) -> str:
    return f"{1000 * latency(answers, percentile):.1f} ms"


def _error_lines(answer: Answer) -> list[str]:
    item = answer.item
    found = str(answer.meaning) if answer.meaning else f"no answer ({answer.note})"
    note = f" ({answer.note})" if answer.meaning and answer.note else ""
    return [
        f"- `{item.id}` {item.group}: “{item.utterance}”",
        f"  - expected: {item.expected}",
        f"  - found: {found}{note}",
    ]
