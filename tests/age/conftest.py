"""Tiny stand-ins with the real layouts: a Whisper of 2 layers with random weights, and a corpus of synthetic voices."""

import csv
import importlib.util
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import soundfile
import typer
from typer.testing import CliRunner

from attune.cli.train_age import train_age

os.environ["HF_HUB_OFFLINE"] = "1"

if importlib.util.find_spec("torch"):
    from attune.training.request import TrainingRequest
    from attune.training.settings import TrainingSettings

    SETTINGS = TrainingSettings(batch_size=8, epochs=12, learning_rate=3e-3, patience=12)
else:
    # `test_extra.py` says so.
    collect_ignore = [f"test_{name}.py" for name in ("checkpoints", "evaluation", "features", "model_estimator")]
    collect_ignore += ["test_onnx.py", "test_training.py"]

COLUMNS = ("client_id", "path", "sentence", "up_votes", "down_votes", "age", "gender", "accents", "locale", "segment")
SENTENCES = (
    "bring me the red cup",
    "could you set the table please",
    "no I meant the other bowl",
    "where is the milk",
    "put it over there",
    "that is fine thank you",
)
# What the corpus calls an age is how high and fast a synthetic voice speaks, so that there is something to hear.
PITCH_AND_RATE = {"twenties": (85, 210), "fourties": (60, 180), "sixties": (30, 140), "eighties": (8, 115)}
VARIANTS = ("m1", "m2", "m3", "m4", "m5", "m6", "f1", "f2", "f3", "f4")


@pytest.fixture(scope="session")
def whisper_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pre-trained Whisper as the hub has it, with random weights."""
    import torch
    from transformers import WhisperModel

    folder = tmp_path_factory.mktemp("tiny-whisper")
    torch.manual_seed(0)
    WhisperModel(tiny_config()).save_pretrained(folder)
    return folder


def tiny_config(**changes: object):  # type: ignore[no-untyped-def]
    from transformers import WhisperConfig

    ids = {f"{name}_token_id": 0 for name in ("pad", "bos", "eos", "decoder_start")}
    sizes = dict(
        d_model=32,
        encoder_layers=2,
        encoder_attention_heads=2,
        encoder_ffn_dim=64,
        decoder_layers=1,
        decoder_attention_heads=2,
        decoder_ffn_dim=64,
        vocab_size=64,
        init_std=0.15,
    )
    return WhisperConfig(**(sizes | ids | changes))


@pytest.fixture(scope="session")
def corpus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Common Voice's layout: 40 speakers of 5 or 6 clips, one with too few, some without age, two damaged clips."""
    from attune.voice.synthesis import Synthesiser

    folder = tmp_path_factory.mktemp("cv-corpus-11.0") / "en"
    (folder / "clips").mkdir(parents=True)
    rng = np.random.default_rng(1)
    voice = Synthesiser()
    rows: list[dict[str, str]] = []

    def say(speaker: str, age: str, gender: str, text: str, variant: str, pitch: int, rate: int) -> None:
        # Encoding mp3 takes most of the time.
        name = f"common_voice_en_{len(rows):05d}.{'wav' if len(rows) % 4 else 'mp3'}"
        speech = voice.synthesise(text, voice=f"en-us+{variant}", pitch=pitch, rate_wpm=rate)
        soundfile.write(folder / "clips" / name, speech.samples, speech.sample_rate)
        rows.append(
            dict.fromkeys(COLUMNS, "") | dict(client_id=speaker, path=name, sentence=text, age=age, gender=gender)
        )

    for group, (pitch, rate) in PITCH_AND_RATE.items():
        for number, variant in enumerate(VARIANTS):
            own_pitch, own_rate = pitch + int(rng.integers(-7, 8)), rate + int(rng.integers(-10, 11))
            gender = "male" if variant.startswith("m") else "female"
            for text in SENTENCES[: 5 + number % 2]:
                say(f"{group}-{number}", group, gender, text, variant, own_pitch, own_rate)
    for text in SENTENCES[:3]:
        say("speaks-little", "thirties", "other", text, "m1", 50, 160)
    for text in SENTENCES:
        say("gives-no-age", "", "", text, "f1", 50, 160)
    (folder / "clips" / rows[0]["path"]).write_bytes(b"this is no sound")
    (folder / "clips" / rows[7]["path"]).unlink()
    half = len(rows) // 2
    for file_name, part in (("train", rows[:half]), ("dev", rows[half:])):
        with (folder / f"{file_name}.tsv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, delimiter="\t", lineterminator="\n")
            writer.writeheader()
            writer.writerows(part)
    return folder


@pytest.fixture(scope="session")
def paper_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A checkpoint in the layout of the paper's authors: their names of weights, their keys in config.json."""
    import torch
    from safetensors.torch import save_file
    from transformers.models.whisper.modeling_whisper import WhisperEncoder

    folder = tmp_path_factory.mktemp("uhh_ub_cv_ar_big_ds")
    torch.manual_seed(3)
    config = tiny_config()
    weights = {f"encoder.{name}": value for name, value in WhisperEncoder(config).state_dict().items()}
    for name in ("k_proj", "v_proj", "q_proj", "out_proj"):
        weights[f"projector.attention.{name}.weight"] = torch.randn(32, 32) * 0.2
    for name in ("self_attn_layer_norm", "final_layer_norm"):
        weights[f"projector.{name}.weight"] = 1 + 0.1 * torch.randn(32)
        weights[f"projector.{name}.bias"] = 0.1 * torch.randn(32)
    weights["projector.linear.weight"], weights["projector.linear.bias"] = torch.randn(256, 32) * 0.2, torch.zeros(256)
    weights["classifier.weight"], weights["classifier.bias"] = torch.randn(9, 256) * 0.5, torch.randn(9)
    save_file(weights, folder / "model.safetensors", metadata={"format": "pt"})
    data = config.to_dict() | {
        "architectures": ["ClassificationWhisperModel"],
        "id2label": {str(index): f"LABEL_{index}" for index in range(9)},
        "label2id": {f"LABEL_{index}": index for index in range(9)},
        "num_classification_layers": 1,
        "num_classifier_attention_heads": 4,
    }
    (folder / "config.json").write_text(json.dumps(data))
    return folder


@pytest.fixture(scope="session")
def speech() -> np.ndarray:
    """About 1.5 s of a synthetic voice, 16 kHz."""
    import soxr

    from attune.voice.synthesis import Synthesiser

    spoken = Synthesiser().synthesise("bring me the red cup please", voice="en-us+m3")
    return soxr.resample(spoken.samples, spoken.sample_rate, 16_000).astype(np.float32)


@pytest.fixture(autouse=True, scope="session")
def _one_thread() -> None:
    """Tiny models are slower on two threads, and the machine is shared."""
    if importlib.util.find_spec("torch"):
        import torch

        torch.set_num_threads(1)


class Trained(NamedTuple):
    """What `attune train-age` left, and what it printed."""

    model: Path
    onnx: Path
    printed: str


@pytest.fixture(scope="session")
def trained(corpus: Path, whisper_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Trained:
    """The paper's variant, trained as people do it."""
    out = tmp_path_factory.mktemp("trained")
    app = typer.Typer()
    app.command()(train_age)
    options = {"common-voice": corpus, "encoder": whisper_folder, "out": out} | {
        name.replace("_", "-"): getattr(SETTINGS, name)
        for name in ("batch_size", "epochs", "learning_rate", "patience")
    }
    arguments = [str(part) for name, value in options.items() for part in (f"--{name}", value)]
    result = CliRunner().invoke(app, [*arguments, "--no-onnx"], catch_exceptions=False)
    assert result.exit_code == 0
    assert not (out / "onnx").exists()
    # The same command goes on where it was: only the export is missing.
    exported = CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert "was trained already" in exported.stdout.replace("\n", " ")
    return Trained(out / "model", out / "onnx", result.stdout)


@pytest.fixture(scope="session")
def request_for(  # type: ignore[no-untyped-def]
    corpus: Path, whisper_folder: Path, trained: Trained, tmp_path_factory: pytest.TempPathFactory
):
    """Makes a request to train on the corpus into a folder of its own, with or without features computed before."""

    def make(*, with_features: bool = True, **changes: object) -> "TrainingRequest":
        out = tmp_path_factory.mktemp("out")
        if with_features:
            shutil.copytree(trained.model.parent / "cache", out / "cache")
        base = TrainingRequest(corpus=corpus, out=out, encoder=str(whisper_folder), settings=SETTINGS)
        return replace(base, **changes)  # type: ignore[arg-type]

    return make
