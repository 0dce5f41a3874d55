"""`attune eval speech`: how well and how fast Attune hears, on synthetic speech or on recordings."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, cast, get_args

import typer


def eval_speech(
    samples: Annotated[
        Path | None, typer.Argument(help="Common Voice folder or TSV, or a JSON Lines list; without: synthetic speech.")
    ] = None,
    asr: Annotated[str, typer.Option(help="The recogniser: auto, sphinx or whisper.")] = "",
    snr: Annotated[
        list[float] | None, typer.Option(help="Also with noise at this signal-to-noise ratio [dB]; repeatable.")
    ] = None,
    noise: Annotated[str, typer.Option(help="Which noise: pink, white, babble or kitchen.")] = "pink",
    sample: Annotated[int, typer.Option(min=0, help="At most so many sentences (of each kind); 0 takes all.")] = 0,
    voices: Annotated[int, typer.Option(min=0, help="At most so many synthetic voices; 0 takes all.")] = 0,
    out: Annotated[Path, typer.Option(help="Gets speech.md, speech.json and speech.png.")] = Path("speech-evaluation"),
    config: Annotated[Path | None, typer.Option(help="Configuration file, if not attune.toml.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Measure error rates, end of sentences, stop words and off-topic speech.

    Example: attune eval speech --sample 10 --snr 20 --snr 10
    """
    import json

    from rich.console import Console
    from rich.markdown import Markdown
    from rich.progress import Progress

    from attune.core.config import load_config, with_values
    from attune.core.errors import MissingDependencyError
    from attune.core.scene import load_scene
    from attune.dialogue.completeness import completeness
    from attune.dialogue.corpus import domain_sentences, scene_lexicon
    from attune.dialogue.grammar.interpreter import GrammarInterpreter
    from attune.evaluation.noises import Noise
    from attune.evaluation.speech import Ears, evaluate_speech
    from attune.evaluation.speech_samples import held_out_speakers, read_samples, synthetic_set
    from attune.speech.age.hub import require
    from attune.speech.audio import Frame
    from attune.speech.choice import choose_recogniser
    from attune.speech.echo import make_cleaner

    require("jiwer", extra="eval", needed_for="`attune eval speech`")
    from attune.evaluation.speech_report import draw, to_data, to_markdown, write_report

    if noise not in get_args(Noise):
        raise typer.BadParameter(f"{noise!r} is none of {', '.join(get_args(Noise))}", param_hint="--noise")
    kind: Noise = cast(Noise, noise)
    settings = with_values(load_config(config), {"speech": {"asr": asr}} if asr else {})
    scene = load_scene(Path(settings.robot.scene) if settings.robot.scene else None)
    sentences = domain_sentences(scene)
    interpreter = GrammarInterpreter(scene_lexicon(scene))
    speakers = held_out_speakers()
    # Spread, so that a few voices are of both engines.
    count = min(voices, len(speakers)) if voices else len(speakers)
    chosen = [speakers[index * len(speakers) // count] for index in range(count)]
    spoken = read_samples(samples, sample) if samples else synthetic_set(chosen, sample)

    def clean() -> Callable[[Frame], Frame]:
        cleaner = make_cleaner(settings.speech, self_talk=False)
        return cleaner.clean if cleaner else lambda frame: frame

    ears = Ears(
        make_recogniser=lambda: choose_recogniser(settings.speech, sentences).recogniser,
        config=settings.speech,
        is_complete=completeness(scene) if spoken.domain else lambda _: None,
        make_clean=clean,
        intent=lambda text: interpreter.read(text).intent,
        confidence_ask=settings.dialogue.confidence_ask,
        confidence_ignore=settings.dialogue.confidence_ignore,
    )
    words = scene.vocabulary
    keywords = frozenset({*words.types, *words.colors, *words.places, "small", "big", "breakfast"})
    conditions = (None, *(snr or ()))
    with Progress(console=Console(stderr=True), transient=True) as bars:
        bar = bars.add_task("listening", total=len(spoken.samples) * len(conditions))
        evaluation = evaluate_speech(spoken, ears, conditions, kind, lambda heard: bars.advance(bar, heard))
    written = write_report(evaluation, keywords, out)
    if as_json:
        typer.echo(json.dumps(to_data(evaluation, keywords), indent=2))
    else:
        Console().print(Markdown(to_markdown(evaluation, keywords).split("\n## Errors")[0]))
        typer.echo(f"Written: {', '.join(map(str, written))}.")
    try:
        draw(evaluation, keywords, out / "speech.png")
    except MissingDependencyError as error:
        typer.echo(f"attune: no plot: {error}", err=True)
