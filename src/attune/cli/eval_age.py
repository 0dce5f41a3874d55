"""`attune eval age`: how good an age model is, beside the paper's."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class PartName(StrEnum):
    """Which clips."""

    HELD_OUT = "held-out"
    TEST = "test"
    DEV = "dev"
    TRAIN = "train"


def eval_age(
    common_voice: Annotated[Path, typer.Option(help="Folder of one language: TSV files and clips.")],
    model: Annotated[str, typer.Option(help="Folder or hub name.")] = "TPekarekRosin/uhh_ub_cv_ar_big_ds",
    part: Annotated[
        PartName, typer.Option(help="The clips that training held out, or all with an age of test, dev or train.")
    ] = PartName.TEST,
    training: Annotated[
        Path | None, typer.Option(help="For held-out clips: the folder with training_report.json, if not the model's.")
    ] = None,
    older_from: Annotated[str, typer.Option(help="The first group that counts as older.")] = "sixties",
    limit: Annotated[int, typer.Option(min=0, help="Use only so many clips, spread evenly; 0 uses all.")] = 0,
    threads: Annotated[int, typer.Option(min=1, help="Processor cores for onnxruntime.")] = 1,
    device: Annotated[str, typer.Option(help="For torch: cpu, cuda ...; auto takes a GPU if there is one.")] = "auto",
    years_per_unit: Annotated[
        float | None, typer.Option(help="For regressions: what the output 1 stands for, if not the usual.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Gets age.md, age.json and confusion.png.")] = Path("age-evaluation"),
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON.")] = False,
) -> None:
    """Measure an age model on Common Voice, by gender and duration, beside the paper's 97.8 % and 59.5 %.

    Example: attune eval age --common-voice cv-corpus-11.0/en --model age-model/model --part held-out
    """
    import json

    from rich.console import Console
    from rich.markdown import Markdown
    from rich.progress import Progress

    from attune.cli.age_options import age_group
    from attune.evaluation.age import as_markdown, choose_clips, evaluate_age, write_report
    from attune.speech.age.hub import fetch
    from attune.speech.age.models import load_age_model

    older = age_group(older_from)
    clips = choose_clips(common_voice, part.value, training or (fetch(model) if part is PartName.HELD_OUT else None))
    if 0 < limit < len(clips):
        clips = tuple(clips[index * len(clips) // limit] for index in range(limit))
    loaded = load_age_model(model, device=device, years_per_unit=years_per_unit, threads=threads)
    with Progress(console=Console(stderr=True)) as bars:
        task = bars.add_task("estimating", total=len(clips))
        evaluation = evaluate_age(
            loaded,
            clips,
            name=Path(model).name if Path(model).is_dir() else model,
            part=part.value,
            older_from=older,
            progress=lambda done, total: bars.update(task, completed=done),
        )
    write_report(evaluation, out)
    if as_json:
        typer.echo(json.dumps(evaluation.to_data(), indent=2))
    else:
        Console().print(Markdown(as_markdown(evaluation)))
        typer.echo(f"written to {out}")
