"""`attune devices`: the microphones and loudspeakers that Attune can use, and how loud a microphone is."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from attune.core.clock import Clock
    from attune.speech.audio import AudioSource

_VOICE = 0.5
"""Voice activity probability from which somebody speaks."""


def devices(
    level: Annotated[
        float, typer.Option(min=0, max=600, metavar="SECONDS", help="Show the microphone's level for so long.")
    ] = 0.0,
    config: Annotated[Path | None, typer.Option(help="A configuration file instead of ./attune.toml.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List microphones and loudspeakers; `*` marks the system's defaults. With --level: how loud you are.

    Choose one with `speech.microphone` and `voice.device` in attune.toml, by its number or name.

    Example: attune devices --level 5
    """
    from attune.speech.audio import load_sounddevice

    if level:
        _show_levels(level, config, as_json)
        return
    sounddevice = load_sounddevice()
    default_input, default_output = sounddevice.default.device
    found: list[dict[str, Any]] = [
        {
            "number": number,
            "name": device["name"],
            "inputs": device["max_input_channels"],
            "outputs": device["max_output_channels"],
            "sample_rate": device["default_samplerate"],
            "default": number in {default_input, default_output},
        }
        for number, device in enumerate(sounddevice.query_devices())
    ]
    if as_json:
        typer.echo(json.dumps(found, indent=2, ensure_ascii=False))
        return
    if not found:
        typer.echo("No microphone and no loudspeaker found. Attune can still listen to files and take typed text.")
    for device in found:
        kinds = [kind for kind, count in (("hears", device["inputs"]), ("speaks", device["outputs"])) if count]
        typer.echo(f"{'*' if device['default'] else ' '} {device['number']:>2}  {device['name']}  ({', '.join(kinds)})")


def _show_levels(seconds: float, config: Path | None, as_json: bool) -> None:
    from attune.core.clock import RealClock, run
    from attune.core.config import load_config
    from attune.speech.audio import Microphone

    microphone = Microphone(load_config(config).speech.microphone)
    clock = RealClock()
    run(lambda: show_levels(microphone, clock, seconds, as_json=as_json), clock)


async def show_levels(source: "AudioSource", clock: "Clock", seconds: float, *, as_json: bool = False) -> None:
    """Print a line for each second: level, peak, and what is wrong with them."""
    import numpy as np

    from attune.speech.audio import FRAME_SAMPLES, SAMPLE_RATE
    from attune.speech.levels import advice, measure
    from attune.speech.voice_activity import VoiceActivity

    voice = VoiceActivity()
    frames = []
    voiced = 0
    told = set()
    until = clock.now() + seconds
    async for frame in source.frames(clock):
        frames.append(frame.samples)
        voiced += voice.probability(frame.samples) >= _VOICE
        if len(frames) * FRAME_SAMPLES >= SAMPLE_RATE:
            measured = measure(np.concatenate(frames), speech=2 * voiced > len(frames))
            frames, voiced = [], 0
            data = {"level": round(measured.level, 1), "peak": round(measured.peak, 1), "problems": measured.problems}
            bar = "#" * round((max(measured.level, -80) + 80) / 2)
            typer.echo(json.dumps(data) if as_json else f"{measured.level:6.1f} dB  {bar}")
            for problem in [] if as_json else measured.problems:
                if problem not in told:
                    told.add(problem)
                    typer.echo(f"attune: {advice(problem)}", err=True)
        if frame.end >= until:
            return
