"""The model card: what a model is, what it saw, how good it was, and what it must not be used for."""

from typing import Any

from attune.core.messages import AGE_GROUPS
from attune.speech.age.groups import PAPER_BINARY_ACCURACY, PAPER_GROUP_ACCURACY


def model_card(report: dict[str, Any]) -> str:
    """Markdown from the training report, with the metadata that the Hugging Face hub reads."""
    corpus, split, test, options = report["corpus"], report["split"], report["test"], report["options"]
    parts = ("training", "validation", "test")
    groups = "\n".join(
        f"| {group} | " + " | ".join(str(corpus[part]["by_group"][group]) for part in parts) + " |"
        for group in AGE_GROUPS
    )
    genders = sorted({gender for part in parts for gender in corpus[part]["by_gender"]})
    by_gender = "\n".join(
        f"| {gender} | " + " | ".join(str(corpus[part]["by_gender"].get(gender, 0)) for part in parts) + " |"
        for gender in genders
    )
    dropped = ", ".join(f"{count} {reason}" for reason, count in corpus["dropped"].items()) or "none"
    by_sample = split["by"] == "sample"
    caution = (
        "\n**The split is by sample: the same voices are in training and test, so these numbers are too good.**\n"
        if by_sample
        else ""
    )
    variants = _variants(report) if len(report["variants"]) > 1 else ""
    return f"""---
library_name: transformers
pipeline_tag: audio-classification
base_model: {report["encoder"]}
tags: [age-recognition, speech, human-robot-interaction]
---

# Age group from speech

Whisper encoder ({report["encoder"]}) with an attention-based classifier for nine age groups, trained with
`attune train-age`. Load it with `attune.speech.age.models.load_age_model`.

## Data

{corpus["name"]}, files {", ".join(corpus["files"])}. Left out: {dropped}; damaged: {corpus["damaged"]["count"]}.
Speakers with fewer than {corpus["minimum_clips"]} clips are left out. Split by {split["by"]}, seed {split["seed"]}.

| | training | validation | test |
|---|---|---|---|
| clips | {" | ".join(str(corpus[part]["clips"]) for part in parts)} |
| speakers | {" | ".join(str(corpus[part]["speakers"]) for part in parts)} |
{groups}
{by_gender}

## Training

{len(report["history"])} epochs, the best was number {report["best_epoch"]}. Options: pooling {options["pooling"]},
layers {options["layers"]}, targets {options["targets"]}, length {options["length"]}, frame stride
{options["frame_stride"]}, temperature {options["temperature"]:.3f}.

## Measured on the test clips ({test["count"]})

| | this model | always the commonest | the paper |
|---|---|---|---|
| younger or older (from {report["older_from"]}) | {test["binary_accuracy"]:.1%} | {test["binary_baseline"]:.1%} | \
{PAPER_BINARY_ACCURACY:.1%} |
| younger or older, balanced | {test["binary_balanced"]:.1%} | 50.0% | not given |
| nine groups | {test["group_accuracy"]:.1%} | {test["group_baseline"]:.1%} | {PAPER_GROUP_ACCURACY:.1%} |
| right or one beside | {test["off_by_one"]:.1%} | | not given |
| calibration error, nine groups | {test["calibration_error"]:.3f} | | not given |
{caution}
The paper's numbers are of its own split by sample of Common Voice 11.0; they compare only roughly.
{variants}
## Use and limits

For choosing how a robot speaks, until the person says what they like. The ages are what volunteers said of
themselves; groups, accents and sexes that are rare in the data are estimated worse, and illness, a microphone or a cold
can shift the estimate by decades. Not for identifying people, for checking an age, or for any decision about a person.
"""


def _variants(report: dict[str, Any]) -> str:
    rows = []
    for name, each in report["variants"].items():
        before, after = each["without_temperature"], each["with_temperature"]
        kept = " (this model)" if name == report["kept"] else ""
        rows.append(
            f"| {name}{kept} | {after['binary_accuracy']:.1%} | "
            f"{after['binary_balanced']:.1%} | {after['group_accuracy']:.1%} | {after['off_by_one']:.1%} | "
            f"{before['calibration_error']:.3f} | {after['calibration_error']:.3f} | "
            f"{each['validation_log_loss']:.3f} |"
        )
    table = "\n".join(rows)
    return f"""
## Variants compared on the same clips

The one with the least log loss on the validation speakers was kept; the test clips decided nothing.

| | younger or older | balanced | nine groups | right or beside | calibration error before temperature | after | \
validation log loss |
|---|---|---|---|---|---|---|---|
{table}
"""
