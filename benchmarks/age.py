"""Age model of the size of whisper-small, with random weights: how fast it runs, and how fast it trains.

One utterance of 3 s at a time on one core; training on synthetic voices in Common Voice's layout, on a GPU where torch
sees one. On a busy machine read the least times: they come closest to an idle one.
"""

import csv
import importlib.util
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import soundfile

SECONDS = 3.0
SPEAKERS = 8
CLIPS_EACH = 3
BATCH = 8
TEXT = "could you please bring me the big red cup from the table"


def main() -> dict[str, Any]:
    needed = ("torch", "transformers", "accelerate", "onnxscript", "tensorboard")
    missing = [name for name in needed if not importlib.util.find_spec(name)]
    if missing:
        return {"skipped": f"{', '.join(missing)} not installed: pip install 'attune-hri[age]'"}
    import torch

    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whisper = _random_whisper_small(folder / "whisper-small")
        return {
            "device of training": torch.cuda.get_device_name() if torch.cuda.is_available() else "cpu, 1 thread",
            "inference of 3 s on 1 core [ms]": _inference(whisper, folder),
            "training [utterances/s]": _training(whisper, folder),
        }


def _random_whisper_small(folder: Path) -> Path:
    import torch
    from transformers import WhisperConfig, WhisperModel

    torch.manual_seed(0)
    sizes = {"d_model": 768, "encoder_layers": 12, "encoder_attention_heads": 12, "encoder_ffn_dim": 3072}
    WhisperModel(WhisperConfig(**sizes, decoder_layers=1)).save_pretrained(folder)
    return folder


def _inference(whisper: Path, folder: Path) -> dict[str, Any]:
    import torch

    from attune.speech.age.checkpoints import new_classifier
    from attune.speech.age.features import log_mel
    from attune.speech.age.models import WhisperAgeModel
    from attune.speech.age.onnx_estimator import OnnxAgeModel
    from attune.speech.age.options import AgeModelOptions
    from attune.training.export import export_onnx

    model = new_classifier(str(whisper), AgeModelOptions())
    begin = time.perf_counter()
    export_onnx(model, folder / "int8")
    exporting = time.perf_counter() - begin
    export_onnx(model, folder / "fp32", int8=False)
    sound = (np.random.default_rng(0).normal(size=int(SECONDS * 16_000)) * 0.1).astype(np.float32)
    features, padded = log_mel(sound), log_mel(sound, padded=True)
    slow = WhisperAgeModel(model)
    figures: dict[str, Any] = {"features": _times(lambda: log_mel(sound), 20)}
    expected = slow.probabilities_of_features(features)
    figures["torch"] = _times(lambda: slow.probabilities_of_features(features), 7)
    figures["torch, padded to 30 s"] = _times(lambda: slow.probabilities_of_features(padded), 2)
    for kind in ("fp32", "int8"):
        fast = OnnxAgeModel(folder / kind)
        figures[f"onnx {kind}"] = _times(lambda fast=fast: fast.probabilities_of_features(features), 15)
        if kind == "int8":
            figures["onnx int8, padded to 30 s"] = _times(lambda fast=fast: fast.probabilities_of_features(padded), 3)
        figures[f"onnx {kind} against torch, largest difference of a probability"] = float(
            np.abs(fast.probabilities_of_features(features) - expected).max()
        )
        figures[f"onnx {kind} [MB]"] = round((folder / kind / "model.onnx").stat().st_size / 1e6)
    figures["export to int8 [s]"] = round(exporting, 1)
    if torch.cuda.is_available():
        on_gpu = WhisperAgeModel(model, "cuda")
        figures["torch on the GPU"] = _times(lambda: on_gpu.probabilities_of_features(features), 20)
    return figures


def _times(call: Callable[[], object], rounds: int) -> dict[str, float]:
    """Wall time, and processor time, which other work on the machine does not lengthen."""
    call()
    taken, worked = [], []
    for _ in range(rounds):
        begin, begin_work = time.perf_counter(), time.process_time()
        call()
        taken.append((time.perf_counter() - begin) * 1000)
        worked.append((time.process_time() - begin_work) * 1000)
    return {
        "least": round(min(taken), 1),
        "median": round(float(np.median(taken)), 1),
        "worst": round(max(taken), 1),
        "median of processor time": round(float(np.median(worked)), 1),
    }


def _training(whisper: Path, folder: Path) -> dict[str, Any]:
    from accelerate import Accelerator

    from attune.speech.age.checkpoints import new_classifier
    from attune.speech.age.options import AgeModelOptions
    from attune.training.common_voice import read_common_voice
    from attune.training.feature_cache import FeatureCache
    from attune.training.settings import TrainingSettings
    from attune.training.sources import CachedSource, SoundSource
    from attune.training.trainer import Trainer

    clips = read_common_voice(_corpus(folder / "corpus"), ("train",), minimum=CLIPS_EACH).clips
    accelerator = Accelerator()
    model = new_classifier(str(whisper), AgeModelOptions())
    begin = time.perf_counter()
    cache = FeatureCache(folder / "cache", model)
    cache.add(clips, model, device=str(accelerator.device))
    filling = time.perf_counter() - begin
    size = sum(path.stat().st_size for path in (folder / "cache").rglob("*.npy"))
    cached, sound = CachedSource(clips, cache), SoundSource(clips, model)
    few = CachedSource(clips[:2], cache)

    def rate(epochs: int, **how: Any) -> dict[str, float]:
        # From the end of the first step on, so that nothing of the start counts; validation lies between epochs.
        ends: list[tuple[float, float]] = []
        trainer = Trainer(
            new_classifier(str(whisper), AgeModelOptions()),
            how.get("training", cached),
            how.get("validation", few),
            TrainingSettings(epochs=epochs, batch_size=BATCH, patience=99, unfreeze_after=how.get("unfreeze_after")),
            folder / f"run-{how.get('name')}",
            sound=how.get("sound"),
            progress=lambda done, total: ends.append((time.perf_counter(), time.process_time())),
            accelerator=accelerator,
        )
        trainer.train()
        wall, work = np.diff(np.array(ends), axis=0).T
        return {
            "best step": round(BATCH / float(wall.min()), 1),
            "median step": round(BATCH / float(np.median(wall)), 1),
            "by processor time": round(BATCH / float(np.median(work)), 1),
        }

    return {
        "clips": len(clips),
        "filling the cache, by the clock": round(len(clips) / filling, 1),
        "size of the cache [MB per minute of speech]": round(size / 1e6 / (len(clips) * SECONDS / 60), 1),
        "with cached features": rate(6, name="cached"),
        "without cache, encoder frozen": rate(2, name="frozen", training=sound),
        "encoder learns too": rate(1, name="unfrozen", sound=(sound, SoundSource(clips[:2], model)), unfreeze_after=0),
    }


def _corpus(folder: Path) -> Path:
    import soxr

    from attune.voice.synthesis import Synthesiser

    (folder / "clips").mkdir(parents=True)
    with (folder / "train.tsv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, delimiter="\t", lineterminator="\n")
        writer.writerow(["client_id", "path", "age", "gender"])
        for speaker in range(SPEAKERS):
            speech = Synthesiser().synthesise(TEXT, voice=f"en-us+m{speaker % 4 + 1}", pitch=20 + 8 * speaker)
            sound = np.resize(soxr.resample(speech.samples, speech.sample_rate, 16_000), int(SECONDS * 16_000))
            for number in range(CLIPS_EACH):
                name = f"clip_{speaker}_{number}.mp3"
                soundfile.write(folder / "clips" / name, sound, 16_000)
                writer.writerow([str(speaker), name, "sixties" if speaker % 2 else "twenties", "male"])
    return folder
