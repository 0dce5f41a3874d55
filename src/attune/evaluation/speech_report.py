"""The report of hearing: figures, Markdown with tables, JSON, plots. Each figure says on what audio it was measured."""

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jiwer
import numpy as np

from attune.core.errors import AttuneError
from attune.evaluation.speech import Condition, Heard, SpeechEvaluation
from attune.evaluation.speech_samples import Kind
from attune.speech.age.hub import require

PAPER_WER, PAPER_CER = 14.84, 5.20
"""Of Whisper small on Common Voice in the paper [%]."""
_LISTED_ERRORS = 40

Row = dict[str, Any]


def figures(evaluation: SpeechEvaluation, keywords: frozenset[str]) -> dict[str, dict[str, Row]]:
    """All figures, as `{condition: {group of voices: {figure: value}}}`; rates in percent, times in milliseconds.

    Args:
        evaluation: What was heard.
        keywords: The words that carry the meaning: things, colours, sizes, places.
    """
    found: dict[str, dict[str, Row]] = {}
    for condition in evaluation.conditions:
        groups = sorted({_group(heard) for heard in condition.heard})
        parts = {group: [heard for heard in condition.heard if _group(heard) == group] for group in groups}
        if len(groups) > 1:
            parts["all"] = list(condition.heard)
        found[condition.name] = {
            group: _transcript(heard, keywords)
            | (_domain(heard, keywords, condition.seconds) if evaluation.samples.domain else {})
            for group, heard in parts.items()
        }
    return found


def to_data(evaluation: SpeechEvaluation, keywords: frozenset[str]) -> dict[str, Any]:
    """The report as plain data, for JSON."""
    data: dict[str, Any] = {
        "recogniser": evaluation.recogniser,
        "measured on": evaluation.samples.description,
        "source": evaluation.samples.source,
        "figures": figures(evaluation, keywords),
        "computing": {condition.name: _computing(condition) for condition in evaluation.conditions},
    }
    if evaluation.samples.source == "common_voice":
        data["paper"] = {"word error rate [%]": PAPER_WER, "character error rate [%]": PAPER_CER}
    return data


def to_markdown(evaluation: SpeechEvaluation, keywords: frozenset[str]) -> str:
    """The report as text with tables."""
    about = evaluation.samples
    lines = [f"# Hearing: {evaluation.recogniser}", "", f"Measured on {about.description}.", ""]
    if about.source == "synthetic":
        lines += [
            "Nobody human was heard: these figures compare versions of Attune, not Attune with people's talk.",
            "",
        ]
    if about.source == "common_voice":
        whole = next(iter(figures(evaluation, keywords)["clean"].values()))
        lines += [
            f"The paper reports for Whisper small on Common Voice: word error rate {PAPER_WER} %, character error rate "
            f"{PAPER_CER:.2f} %. Here: {whole['word error rate [%]']} % and {whole['character error rate [%]']} %. The "
            "clips may be others.",
            "",
        ]
    for condition, groups in figures(evaluation, keywords).items():
        lines += [f"## {condition}", "", f"| | {' | '.join(groups)} |", "|---" * (len(groups) + 1) + "|"]
        names = dict.fromkeys(name for row in groups.values() for name in row)
        lines += [f"| {name} | {' | '.join(_cell(row.get(name)) for row in groups.values())} |" for name in names]
        lines += [""]
    lines += ["## Computing", "", f"| | {' | '.join(c.name for c in evaluation.conditions)} |"]
    lines += ["|---" * (len(evaluation.conditions) + 1) + "|"]
    rows = [_computing(condition) for condition in evaluation.conditions]
    lines += [f"| {name} | {' | '.join(_cell(row[name]) for row in rows)} |" for name in rows[0]]
    wrong = [heard for heard in evaluation.conditions[0].heard if heard.text != heard.reference]
    lines += ["", f"## Errors ({evaluation.conditions[0].name}, the first {_LISTED_ERRORS} of {len(wrong)})", ""]
    lines += [f"- {h.sample.speaker[:12]}: *{h.reference}* → *{h.text or '(nothing)'}*" for h in wrong[:_LISTED_ERRORS]]
    return "\n".join(lines) + "\n"


def write_report(evaluation: SpeechEvaluation, keywords: frozenset[str], folder: Path) -> tuple[Path, ...]:
    """Write `speech.md`, `speech.json`, and `speech.png` where matplotlib is installed.

    Returns:
        What was written.

    Raises:
        AttuneError: The folder cannot be written.
    """
    texts = {
        "speech.md": to_markdown(evaluation, keywords),
        "speech.json": json.dumps(to_data(evaluation, keywords), indent=2) + "\n",
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise AttuneError(f"{folder} cannot be written: {error.strerror}", "Give another folder with --out") from None
    return tuple(folder / name for name in texts)


def draw(evaluation: SpeechEvaluation, keywords: frozenset[str], path: Path) -> None:
    """Draw error rates by noise, and how long the end of a sentence takes to be found.

    Raises:
        MissingDependencyError: matplotlib is not installed.
    """
    require("matplotlib", extra="eval", needed_for="drawing the report")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    table = figures(evaluation, keywords)
    figure = Figure(figsize=(11, 4), layout="constrained")
    FigureCanvasAgg(figure)
    rates, delays = figure.subplots(1, 2)
    names = list(table)
    for group in table[names[0]]:
        values = [table[name][group].get("word error rate [%]") or 0 for name in names]
        rates.plot(names, values, marker="o", label=group)
    if evaluation.samples.source == "common_voice":
        rates.axhline(PAPER_WER, linestyle="--", color="grey", label="the paper, Whisper small")
    rates.set_ylabel("word error rate [%]")
    rates.set_ylim(bottom=0)
    rates.legend()
    for condition in evaluation.conditions:
        found = [1000 * heard.delay for heard in condition.heard if heard.delay is not None]
        delays.hist(found, bins=30, histtype="step", label=condition.name)
    delays.set_xlabel("from the end of the speech to the utterance [ms]")
    delays.set_ylabel("sentences")
    delays.legend()
    figure.suptitle(f"{evaluation.recogniser}: {evaluation.samples.description}", fontsize=9)
    figure.savefig(path, dpi=120)


def _group(heard: Heard) -> str:
    if heard.sample.voice is None:
        return "recordings"
    return "flite" if heard.sample.voice.voice.startswith("flite:") else "espeak-ng"


def _of(heard: Sequence[Heard], *kinds: Kind) -> list[Heard]:
    return [each for each in heard if each.sample.kind in kinds]


def _transcript(heard: Sequence[Heard], keywords: frozenset[str]) -> Row:
    requests = _of(heard, "request")
    if not requests:
        return {}
    said, text = [each.reference for each in requests], [each.text for each in requests]
    delays = [1000 * each.delay for each in requests if each.delay is not None]
    return {
        "sentences": len(requests),
        "word error rate [%]": _rounded(100 * jiwer.wer(said, text)),
        "character error rate [%]": _rounded(100 * jiwer.cer(said, text)),
        "incomplete or erroneous [%]": _percent(each.text != each.reference for each in requests),
        "nothing heard [%]": _percent(not each.text for each in requests),
        "cut off [%]": _percent(each.utterances > 1 for each in requests),
        "endpoint delay, median [ms]": _rounded(float(np.median(delays))) if delays else None,
        "endpoint delay, 95th percentile [ms]": _rounded(float(np.percentile(delays, 95))) if delays else None,
    }


def _domain(heard: Sequence[Heard], keywords: frozenset[str], seconds: float) -> Row:
    requests, off_topic = _of(heard, "request"), _of(heard, "off_topic")
    stops, others = _of(heard, "stop"), _of(heard, "request", "off_topic")
    not_stops = _of(heard, "not_stop")
    row: Row = {}
    if requests:
        right = [_keywords_right(each, keywords) for each in requests]
        said = sum(total for _, total in right)
        row |= {
            "keywords heard [%]": _rounded(100 * sum(hit for hit, _ in right) / said) if said else None,
            "acted on [%]": _percent(each.accepted for each in requests),
            "acted on with a wrong or missing keyword [%]": _percent(
                each.accepted and not _same_keywords(each, keywords) for each in requests
            ),
            "asked back [%]": _percent(each.asked for each in requests),
            "ignored [%]": _percent(not each.accepted and not each.asked for each in requests),
        }
    if off_topic:
        row["off-topic speech acted on [%]"] = _percent(each.accepted for each in off_topic)
        row["off-topic speech asked back [%]"] = _percent(each.asked for each in off_topic)
    if stops:
        delays = [1000 * each.stop_delay for each in stops if each.stop_delay is not None]
        row |= {
            "stops": len(stops),
            "stop spotted after the end of the word, median [ms]": _rounded(float(np.median(delays)))
            if delays
            else None,
            "stop spotted, 95th percentile [ms]": _rounded(float(np.percentile(delays, 95))) if delays else None,
            "stops not spotted [%]": _percent(each.stop_delay is None for each in stops),
            "stops missed, also by the text [%]": _percent(
                each.stop_delay is None and not each.halts for each in stops
            ),
        }
    if others:
        hours = sum(len(each.sample.text.split()) for each in others) / 140 / 60
        pauses = [each.paused for each in [*others, *not_stops] if each.stop_delay is not None]
        row |= {
            "other sentences": len(others),
            "spotted stops in them": sum(each.stop_delay is not None for each in others),
            "spotted stops per hour of speech (140 words a minute)": _rounded(
                sum(each.stop_delay is not None for each in others) / hours
            ),
            "halted for good by them": sum(each.halts for each in others),
            "longest wrongful pause [ms]": _rounded(1000 * max(pauses, default=0.0)),
        }
    if not_stops:
        row |= {
            "sounds like stop, or negated": len(not_stops),
            "spotted in them [%]": _percent(each.stop_delay is not None for each in not_stops),
            "halted for good by them [%]": _percent(each.halts for each in not_stops),
        }
    return row


def _computing(condition: Condition) -> Row:
    ends = [1000 * seconds for seconds in condition.finish_seconds]
    return {
        "seconds of sound": _rounded(condition.seconds),
        "share of one core [%]": _rounded(100 * condition.processor_seconds / max(condition.seconds, 1e-9)),
        "transcript after the endpoint, median [ms]": _rounded(float(np.median(ends))) if ends else None,
        "transcript after the endpoint, 95th percentile [ms]": _rounded(float(np.percentile(ends, 95)))
        if ends
        else None,
    }


def _keywords_right(heard: Heard, keywords: frozenset[str]) -> tuple[int, int]:
    said, text = _keyword_counts(heard.reference, keywords), _keyword_counts(heard.text, keywords)
    return (said & text).total(), said.total()


def _same_keywords(heard: Heard, keywords: frozenset[str]) -> bool:
    return _keyword_counts(heard.reference, keywords) == _keyword_counts(heard.text, keywords)


def _keyword_counts(text: str, keywords: frozenset[str]) -> Counter[str]:
    return Counter(word for word in text.split() if word in keywords)


def _percent(flags: Any) -> float:
    values = list(flags)
    return _rounded(100 * sum(values) / len(values))


def _rounded(value: float) -> float:
    return round(value, 1)


def _cell(value: Any) -> str:
    return "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
