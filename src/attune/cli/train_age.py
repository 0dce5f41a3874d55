"""`attune train-age`: train the paper's age model on Common Voice."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from attune.training.pipeline import Outcome


class Precision(StrEnum):
    """Mixed precision."""

    NO = "no"
    FP16 = "fp16"
    BF16 = "bf16"


class SplitBy(StrEnum):
    """How the corpus is cut."""

    SPEAKER = "speaker"
    SAMPLE = "sample"


class Pooling(StrEnum):
    """How frames become one vector."""

    MEAN = "mean"
    ATTENTION = "attention"


class Layers(StrEnum):
    """Which encoder layers are heard."""

    LAST = "last"
    WEIGHTED = "weighted"


class Targets(StrEnum):
    """What is trained."""

    GROUPS = "groups"
    ORDINAL = "ordinal"


class Length(StrEnum):
    """What the encoder hears."""

    TRUE = "true"
    PADDED = "padded"


def train_age(
    common_voice: Annotated[Path, typer.Option(help="Folder of one language: TSV files and clips.")],
    out: Annotated[
        Path, typer.Option(help="Gets model/, onnx/, runs/ (logs, what is needed to go on) and cache/.")
    ] = Path("age-model"),
    encoder: Annotated[str, typer.Option(help="Folder or hub name of a Whisper model.")] = "openai/whisper-small",
    epochs: Annotated[int, typer.Option(help="Passes over the data.")] = 10,
    batch_size: Annotated[int, typer.Option(help="Clips per step and process.")] = 32,
    learning_rate: Annotated[float, typer.Option(help="Of the classifier, after the warm-up.")] = 1e-3,
    warmup: Annotated[float, typer.Option(help="Share of all steps over which the rates rise.")] = 0.1,
    unfreeze_after: Annotated[
        int | None, typer.Option(help="Epochs after which the encoder learns too; never if not given.")
    ] = None,
    encoder_learning_rate: Annotated[float, typer.Option(help="Of the encoder, once it learns.")] = 1e-5,
    pooling: Annotated[Pooling, typer.Option(help="How frames become one vector.")] = Pooling.MEAN,
    layers: Annotated[Layers, typer.Option(help="The last encoder layer, or a learnt sum.")] = Layers.LAST,
    targets: Annotated[Targets, typer.Option(help="Nine classes, or their order too.")] = Targets.GROUPS,
    length: Annotated[
        Length, typer.Option(help="The true length, or filled up to 30 s as in the paper.")
    ] = Length.TRUE,
    frame_stride: Annotated[int, typer.Option(help="Average so many encoder frames into one.")] = 1,
    dropout: Annotated[float, typer.Option(help="Share of values dropped in the classifier.")] = 0.0,
    compare: Annotated[bool, typer.Option(help="Train the paper's variant and each option; keep the best.")] = False,
    split_by: Annotated[SplitBy, typer.Option(help="`sample` is the paper's, with voices on both sides.")] = (
        SplitBy.SPEAKER
    ),
    minimum_clips: Annotated[int, typer.Option(help="Clips that a speaker must have.")] = 5,
    older_from: Annotated[str, typer.Option(help="The first group that counts as older.")] = "sixties",
    class_weights: Annotated[bool, typer.Option(help="Count every group alike.")] = True,
    cache: Annotated[bool, typer.Option(help="Keep encoder features on disk (77 kB a second of speech).")] = True,
    precision: Annotated[Precision, typer.Option(help="Mixed precision.")] = Precision.NO,
    patience: Annotated[int, typer.Option(help="Epochs without progress after which it stops.")] = 3,
    save_every: Annotated[int, typer.Option(help="Steps between saved states.")] = 500,
    workers: Annotated[int, typer.Option(help="Threads that decode sound.")] = 4,
    seed: Annotated[int, typer.Option(help="Of the split, the order and the first weights.")] = 0,
    onnx: Annotated[bool, typer.Option(help="Also write the fast form for onnxruntime, int8.")] = True,
    restart: Annotated[bool, typer.Option(help="Forget an interrupted run or a model in --out.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the training report as JSON.")] = False,
) -> None:
    """Train the age model; interrupted, the same command goes on where it was.

    Several GPUs: accelerate launch "$(command -v attune)" train-age ...

    Example: attune train-age --common-voice cv-corpus-11.0/en --out age-model --compare
    """
    from attune.speech.age.hub import require

    require("torch", "transformers", "accelerate", "tensorboard", needed_for="training")
    import json

    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

    from attune.cli.age_options import age_group
    from attune.speech.age.options import AgeModelOptions
    from attune.training.pipeline import MODEL_FOLDER, train_age_model
    from attune.training.request import TrainingRequest
    from attune.training.settings import TrainingSettings

    fast = out / "onnx"
    if onnx and not restart and (out / MODEL_FOLDER).exists() and not fast.exists():
        # The run was interrupted after the training, or did without.
        _export(out / MODEL_FOLDER, fast)
        typer.echo(f"{out / MODEL_FOLDER} was trained already; its fast form: {fast}")
        return
    console = Console(stderr=True)
    request = TrainingRequest(
        corpus=common_voice,
        out=out,
        encoder=encoder,
        minimum=minimum_clips,
        split_by=split_by.value,
        older_from=age_group(older_from),
        options=AgeModelOptions(
            pooling=pooling.value,
            layers=layers.value,
            targets=targets.value,
            length=length.value,
            frame_stride=frame_stride,
            dropout=dropout,
        ),
        settings=TrainingSettings(
            epochs=epochs,
            batch_size=batch_size,
            learning_rate=learning_rate,
            warmup=warmup,
            encoder_learning_rate=encoder_learning_rate,
            unfreeze_after=unfreeze_after,
            class_weights="balanced" if class_weights else "none",
            precision=precision.value,
            patience=patience,
            save_every=save_every,
            seed=seed,
        ),
        cached=cache,
        compare=compare,
        restart=restart,
        workers=workers,
    )
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as bars:
        tasks: dict[str, TaskID] = {}

        def show(what: str, done: int, total: int) -> None:
            if what not in tasks:
                tasks[what] = bars.add_task(what)
            bars.update(tasks[what], completed=done, total=total)

        outcome = train_age_model(request, show)
    if not outcome.is_main:
        return
    if onnx:
        _export(outcome.model, fast)
    if as_json:
        typer.echo(json.dumps(outcome.report, indent=2))
        return
    _print(outcome, Console())
    typer.echo(f"model: {outcome.model}" + (f"\nfast form: {fast}" if onnx else ""))


def _export(model: Path, folder: Path) -> None:
    from attune.speech.age.checkpoints import load_classifier
    from attune.training.export import export_onnx

    export_onnx(load_classifier(str(model)), folder)


def _print(outcome: "Outcome", console: "Console") -> None:
    from rich.table import Table

    from attune.speech.age.groups import PAPER_BINARY_ACCURACY, PAPER_GROUP_ACCURACY

    table = Table(title=f"{outcome.kept.after.count} test clips, with temperature", box=None)
    table.add_column("variant", no_wrap=True)
    for name in ("young/old", "balanced", "9 groups", "or beside", "calibration"):
        table.add_column(name, justify="right")
    for variant in outcome.variants:
        each = variant.after
        table.add_row(
            f"{variant.name} (kept)" if variant is outcome.kept else variant.name,
            f"{each.binary_accuracy:.1%}",
            f"{each.binary_balanced:.1%}",
            f"{each.group_accuracy:.1%}",
            f"{each.off_by_one:.1%}",
            f"{variant.before.calibration_error:.3f}→{each.calibration_error:.3f}",
        )
    some = outcome.kept.after
    table.add_row("commonest", f"{some.binary_baseline:.1%}", "50.0%", f"{some.group_baseline:.1%}", "", "")
    table.add_row("the paper", f"{PAPER_BINARY_ACCURACY:.1%}", "", f"{PAPER_GROUP_ACCURACY:.1%}", "", "")
    console.print(table)
    if outcome.kept.result.resumed_at:
        console.print(f"went on with an interrupted run, from step {outcome.kept.result.resumed_at}")
    if outcome.damaged:
        console.print(f"{len(outcome.damaged)} damaged clips were skipped; {outcome.model.name}/training_report.json")
