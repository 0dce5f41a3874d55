"""`attune listen`: what is heard in recordings or at the microphone, one JSON line for each utterance."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from attune.core.clock import Clock
    from attune.core.config import SpeechConfig
    from attune.core.events import Event
    from attune.core.messages import StopSignal, Utterance
    from attune.speech.audio import AudioSource
    from attune.speech.recogniser import Recogniser

MICROPHONE = "microphone"
RECORDINGS = {".wav", ".flac", ".mp3", ".ogg", ".opus", ".aiff", ".aif", ".au"}


def listen(
    sources: Annotated[list[str], typer.Argument(help="Recordings, folders of recordings, or `microphone`.")],
    asr: Annotated[str, typer.Option(help="The recogniser: auto, sphinx or whisper.")] = "",
    as_json: Annotated[
        bool, typer.Option("--json", help="Print warnings about the sound as JSON Lines, too, not on standard error.")
    ] = False,
    config: Annotated[Path | None, typer.Option(help="A configuration file instead of ./attune.toml.")] = None,
) -> None:
    """Print what is said as JSON Lines: utterances with times, confidence and age; stop signals as they are spotted.

    Recordings are worked through as fast as possible. A bad one gives one line on standard error and exit status 1.
    A microphone that is dead, hums, or is too loud or too soft gives one line as well, each at most once a minute.

    Example: attune listen recording.wav
    """
    from attune.core.clock import RealClock, VirtualClock, run
    from attune.core.config import load_config, with_values
    from attune.core.errors import AttuneError
    from attune.core.scene import load_scene
    from attune.dialogue.corpus import domain_sentences
    from attune.speech.audio import ArraySource, AudioError, Microphone, read_recording
    from attune.speech.choice import choose_recogniser

    settings = with_values(load_config(config), {"speech": {"asr": asr}} if asr else {})
    scene = load_scene(Path(settings.robot.scene) if settings.robot.scene else None)
    chosen = choose_recogniser(settings.speech, domain_sentences(scene))
    if settings.speech.asr == "auto":
        typer.echo(f"attune: {chosen}", err=True)
    recogniser = chosen.recogniser
    failed = False

    def hear(source: str, audio: AudioSource, clock: Clock) -> None:
        run(lambda: _listen(source, audio, clock, settings.speech, recogniser, as_json), clock)

    for source in sources:
        try:
            if source == MICROPHONE:
                hear(source, Microphone(settings.speech.microphone), RealClock())
                continue
            recordings = _recordings(Path(source))
        except AttuneError as error:
            typer.echo(f"attune: {error}", err=True)
            failed = True
            continue
        if not recordings:
            typer.echo(f"attune: {AudioError(source, 'has no recordings in it', 'Put WAV files there')}", err=True)
            failed = True
        for path in recordings:
            try:
                audio = ArraySource(read_recording(path), name=str(path))
            except AttuneError as error:
                typer.echo(f"attune: {error}", err=True)
                failed = True
            else:
                hear(str(path), audio, VirtualClock())
    if failed:
        raise typer.Exit(1)


def _recordings(source: Path) -> list[Path]:
    """The file itself, or the recordings of a folder in alphabetical order."""
    if not source.is_dir():
        return [source]
    return sorted(path for path in source.rglob("*") if path.suffix.lower() in RECORDINGS)


async def _listen(
    source: str, audio: AudioSource, clock: Clock, settings: SpeechConfig, recogniser: Recogniser, as_json: bool
) -> None:
    from attune.core.bus import EVENT, SPEECH_STOP, UTTERANCE, Bus
    from attune.core.codec import to_data
    from attune.speech.age.choice import make_age_estimator
    from attune.speech.listener import Listener

    heard_anything = False

    def utterance(heard: Utterance) -> None:
        nonlocal heard_anything
        heard_anything = True
        fields = ("start", "end", "text", "alternatives", "confidence", "in_domain", "age")
        data = to_data(heard)
        _print({"file": source} | {name: data[name] for name in fields})

    def stop(signal: StopSignal) -> None:
        nonlocal heard_anything
        if signal.state == "spotted":
            heard_anything = True
            _print({"file": source, "stop_at": signal.time})

    def warn(event: Event) -> None:
        if event.kind != "warning":
            return
        if as_json:
            _print({"file": source, "at": event.time, "warning": event.text})
        else:
            typer.echo(f"attune: {source}: {event.text}", err=True)

    age = make_age_estimator(settings.age, settings.older_from)
    bus = Bus()
    bus.on(UTTERANCE, utterance)
    bus.on(SPEECH_STOP, stop)
    bus.on(EVENT, warn)
    await Listener(bus, clock, audio, (), settings, age=age, recogniser=recogniser).run()
    if not heard_anything:
        typer.echo(f"attune: {source}: no speech that could be understood", err=True)


def _print(data: dict[str, Any]) -> None:
    rounded = {name: round(value, 3) if isinstance(value, float) else value for name, value in data.items()}
    # Each line at once, also into a pipe: somebody may act on it.
    print(json.dumps(rounded, ensure_ascii=False), flush=True)  # noqa: T201 - this is the command's output
