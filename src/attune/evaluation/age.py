"""Evaluation of age models on Common Voice: the numbers, by gender and length, beside the paper's."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from attune.core.errors import AttuneError
from attune.core.messages import AGE_GROUPS, AgeGroup
from attune.speech.age.features import SAMPLE_RATE
from attune.speech.age.groups import OLDER_FROM, PAPER_BINARY_ACCURACY, PAPER_GROUP_ACCURACY
from attune.speech.age.models import AgeModel
from attune.training.clips import ClipError, read_clip
from attune.training.common_voice import Clip, fingerprint_of_clips, read_common_voice, split_clips
from attune.training.metrics import Measures, Predictions, confusion, measure, measure_parts

Part = Literal["held-out", "test", "dev", "train"]
REPORT_FILE = "training_report.json"


class EvaluationError(AttuneError):
    """The evaluation would not measure what it says."""


@dataclass(frozen=True, slots=True)
class AgeEvaluation:
    """What came out.

    Attributes:
        part: Which clips were used.
        skipped: File names of damaged clips, and why.
    """

    model: str
    part: Part
    older_from: AgeGroup
    predictions: Predictions
    skipped: dict[str, str]

    @property
    def measures(self) -> Measures:
        """Of all clips."""
        return measure(self.predictions, self.older_from)

    def to_data(self) -> dict[str, Any]:
        """Everything as plain data, for JSON."""
        parts = measure_parts(self.predictions, self.older_from)
        return {
            "model": self.model,
            "part": self.part,
            "older_from": self.older_from,
            "skipped": len(self.skipped),
            "all": self.measures.to_data(),
            "paper": {"binary_accuracy": PAPER_BINARY_ACCURACY, "group_accuracy": PAPER_GROUP_ACCURACY},
            "parts": {kind: {name: each.to_data() for name, each in rows.items()} for kind, rows in parts.items()},
            "groups": list(AGE_GROUPS),
            "confusion": confusion(self.predictions).tolist(),
        }


def choose_clips(corpus: Path, part: Part, model_folder: Path | None = None) -> tuple[Clip, ...]:
    """The clips of an evaluation.

    Args:
        corpus: Common Voice of one language.
        part: `held-out`: those that the training of this model set aside. `test`, `dev` or `train`: of that TSV file,
            everything with an age.
        model_folder: Of the model; needed for `held-out`.

    Raises:
        EvaluationError: The model does not say what it held out, or the corpus is another than in training.
        CommonVoiceError: The corpus is not as expected.
    """
    if part != "held-out":
        return read_common_voice(corpus, (part,), minimum=1).clips
    path = (model_folder or Path()) / REPORT_FILE
    if model_folder is None or not path.exists():
        raise EvaluationError(
            "the model does not say which clips its training held out", "Use --part test, which its training never saw"
        )
    report = json.loads(path.read_text(encoding="utf-8"))
    split = report["split"]
    clips = read_common_voice(corpus, report["corpus"]["files"], report["corpus"]["minimum_clips"]).clips
    test = split_clips(
        clips,
        training_share=split["training_share"],
        validation_share=split["validation_share"],
        by=split["by"],
        seed=split["seed"],
    ).test
    if fingerprint_of_clips(test) != split["test_clips"]:
        raise EvaluationError(
            f"{corpus} is not the corpus of the training (the held-out clips differ)",
            "Give the same corpus, or use --part test",
        )
    return test


def evaluate_age(
    model: AgeModel,
    clips: Sequence[Clip],
    *,
    name: str,
    part: Part,
    older_from: AgeGroup = OLDER_FROM,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> AgeEvaluation:
    """Run a model over clips, one at a time, as it runs in a session.

    Args:
        model: The model.
        clips: From `choose_clips`.
        name: Of the model, for the report.
        part: Which clips they are.
        older_from: The first group that counts as older.
        progress: Called with the clips done and their total.

    Raises:
        EvaluationError: Not one clip can be read.
    """
    rows, used, seconds = [], [], []
    skipped: dict[str, str] = {}
    for done, clip in enumerate(clips, start=1):
        try:
            samples = read_clip(clip.path)
        except ClipError as error:
            skipped[clip.path.name] = str(error)
        else:
            rows.append(model.probabilities(samples))
            used.append(clip)
            seconds.append(len(samples) / SAMPLE_RATE)
        progress(done, len(clips))
    if not rows:
        raise EvaluationError(f"none of {len(clips)} clips can be read", "Check the folder 'clips' of the corpus")
    predictions = Predictions(
        probabilities=np.array(rows),
        groups=np.array([clip.group for clip in used]),
        genders=tuple(clip.gender for clip in used),
        durations=np.array(seconds),
    )
    return AgeEvaluation(name, part, older_from, predictions, skipped)


def write_report(evaluation: AgeEvaluation, folder: Path) -> None:
    """Write `age.json`, `age.md` and `confusion.png`.

    Raises:
        MissingDependencyError: matplotlib is not installed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "age.json").write_text(json.dumps(evaluation.to_data(), indent=2) + "\n", encoding="utf-8")
    (folder / "age.md").write_text(as_markdown(evaluation), encoding="utf-8")
    _draw(evaluation, folder / "confusion.png")


def as_markdown(evaluation: AgeEvaluation) -> str:
    """The report as text with tables."""
    total = evaluation.measures
    lines = [
        f"# Age recognition: {evaluation.model}",
        "",
        f"{total.count} clips of the part `{evaluation.part}`; {len(evaluation.skipped)} damaged ones skipped. "
        f"Older is who is in the {evaluation.older_from} or beyond.",
        "",
        "| | this model | always the commonest | the paper |",
        "|---|---|---|---|",
        f"| younger or older | {total.binary_accuracy:.1%} | {total.binary_baseline:.1%} | "
        f"{PAPER_BINARY_ACCURACY:.1%} |",
        f"| younger or older, balanced | {total.binary_balanced:.1%} | 50.0% | not given |",
        f"| nine groups | {total.group_accuracy:.1%} | {total.group_baseline:.1%} | {PAPER_GROUP_ACCURACY:.1%} |",
        f"| right group or one beside it | {total.off_by_one:.1%} | | not given |",
        f"| nine groups, balanced | {total.balanced_accuracy:.1%} | | not given |",
        f"| calibration error, nine groups | {total.calibration_error:.3f} | | not given |",
        f"| calibration error, younger or older | {total.binary_calibration_error:.3f} | | not given |",
        "",
        "The paper's numbers are of its own split by sample of Common Voice 11.0, where the same voices are in "
        "training and test; they compare only roughly.",
    ]
    for kind, rows in measure_parts(evaluation.predictions, evaluation.older_from).items():
        lines += [
            "",
            f"## By {kind}",
            "",
            "| | clips | younger or older | balanced | nine groups | right or beside | calibration error |",
            "|---|---|---|---|---|---|---|",
        ]
        lines += [
            f"| {name} | {each.count} | {each.binary_accuracy:.1%} | {each.binary_balanced:.1%} | "
            f"{each.group_accuracy:.1%} | {each.off_by_one:.1%} | {each.calibration_error:.3f} |"
            for name, each in rows.items()
        ]
    lines += ["", "## Confusion", "", "| true \\ said | " + " | ".join(AGE_GROUPS) + " |", "|---" * 10 + "|"]
    lines += [
        f"| {group} | " + " | ".join(map(str, row)) + " |"
        for group, row in zip(AGE_GROUPS, confusion(evaluation.predictions).tolist(), strict=True)
    ]
    return "\n".join(lines) + "\n"


def _draw(evaluation: AgeEvaluation, path: Path) -> None:
    from attune.speech.age.hub import require

    require("matplotlib", needed_for="drawing the confusion matrix")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    table = confusion(evaluation.predictions)
    share = table / np.maximum(table.sum(axis=1, keepdims=True), 1)
    figure = Figure(figsize=(7, 6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    image = axes.imshow(share, cmap="Blues", vmin=0, vmax=1)
    axes.set_xticks(range(len(AGE_GROUPS)), AGE_GROUPS, rotation=45, ha="right")
    axes.set_yticks(range(len(AGE_GROUPS)), AGE_GROUPS)
    axes.set_xlabel("said")
    axes.set_ylabel("true")
    for row, column in np.argwhere(table):
        colour = "white" if share[row, column] > 0.5 else "black"
        axes.text(column, row, str(table[row, column]), ha="center", va="center", color=colour, fontsize=8)
    figure.colorbar(image, label="share of the true group")
    axes.set_title(f"{evaluation.model}: {evaluation.measures.count} clips")
    figure.savefig(path, dpi=120)
