"""From a Common Voice folder to a trained model: everything that `attune train-age` does."""

import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from accelerate import Accelerator

from attune.core.errors import AttuneError
from attune.core.messages import AGE_GROUPS
from attune.speech.age.checkpoints import new_classifier, save_classifier
from attune.speech.age.options import AgeModelOptions
from attune.speech.age.whisper_classifier import WhisperAgeClassifier
from attune.training.common_voice import (
    Clip,
    Split,
    read_common_voice,
    split_clips,
)
from attune.training.feature_cache import FeatureCache
from attune.training.metrics import Predictions, measure, softmax
from attune.training.model_card import model_card
from attune.training.prediction import predict
from attune.training.report import training_report
from attune.training.request import TrainingRequest, Variant
from attune.training.sources import CachedSource, SoundSource, Source
from attune.training.trainer import Trainer

MODEL_FOLDER = "model"
RUNS_FOLDER = "runs"
REPORT_FILE = "training_report.json"

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What training came to.

    Attributes:
        model: Folder of the model that was kept.
        report: What its `training_report.json` holds.
        damaged: File names of clips that were skipped, and why.
        is_main: False in all but one of several processes that trained together.
    """

    model: Path
    kept: Variant
    variants: tuple[Variant, ...]
    report: dict[str, Any]
    damaged: dict[str, str]
    is_main: bool


def train_age_model(request: TrainingRequest, progress: Progress | None = None) -> Outcome:
    """Train, measure and write the model. An interrupted run of the same request goes on where it was.

    Args:
        request: What to do.
        progress: Called with the name of the step, what is done and its total.

    Raises:
        CommonVoiceError: The corpus is not as expected.
        ModelNotFoundError: The encoder cannot be had.
        TrainingError: `out` holds an interrupted run of another plan.
        AttuneError: `out` already holds a model.
    """
    accelerator = Accelerator(mixed_precision=request.settings.precision)
    if progress is None or not accelerator.is_main_process:
        progress = _silent
    target = request.out / MODEL_FOLDER
    if target.exists() and not request.restart:
        raise AttuneError(f"{target} already holds a trained model", "Give another folder, or use --restart")
    if request.restart and accelerator.is_main_process:
        # At once, so that the new run can be taken up when it is interrupted.
        shutil.rmtree(target, ignore_errors=True)
        shutil.rmtree(request.out / RUNS_FOLDER, ignore_errors=True)
    accelerator.wait_for_everyone()
    corpus = read_common_voice(request.corpus, request.files, request.minimum)
    split = split_clips(
        corpus.clips,
        training_share=request.training_share,
        validation_share=request.validation_share,
        by=request.split_by,
        seed=request.settings.seed,
    )
    trial = _Trial(request, split, accelerator, progress)
    variants = []
    best: tuple[Variant, WhisperAgeClassifier] | None = None
    for name, options in _variants(request):
        variant, model = trial.run(name, options)
        variants.append(variant)
        if best is None or variant.validation_loss < best[0].validation_loss:
            best = variant, model
    if best is None:
        raise AttuneError("there is no variant to train")
    kept, model = best
    report = training_report(request, split, corpus.dropped, kept, variants, trial.damaged)
    if accelerator.is_main_process:
        extra = {
            REPORT_FILE: json.dumps(report, indent=2) + "\n",
            "labels.json": json.dumps(list(AGE_GROUPS)) + "\n",
            "README.md": model_card(report),
        }
        save_classifier(model, target, extra)
        trial.discard_state()
    accelerator.wait_for_everyone()
    return Outcome(target, kept, tuple(variants), report, trial.damaged, accelerator.is_main_process)


class _Trial:
    """One corpus, cut and ready, on which variants are trained."""

    def __init__(self, request: TrainingRequest, split: Split, accelerator: Accelerator, progress: Progress) -> None:
        self._request = request
        self._split = split
        self._accelerator = accelerator
        self._progress = progress
        self._cache: FeatureCache | None = None
        self._trainers: list[Trainer] = []
        self.damaged: dict[str, str] = {}
        if request.cached:
            self._cache = self._filled_cache()
            # The cache may know more clips than this request takes.
            names = {clip.path.name for part in (split.training, split.validation, split.test) for clip in part}
            self.damaged |= {name: why for name, why in self._cache.failed.items() if name in names}

    def run(self, name: str, options: AgeModelOptions) -> tuple[Variant, WhisperAgeClassifier]:
        """Train one variant and measure it on the test clips."""
        request, accelerator = self._request, self._accelerator
        model = new_classifier(request.encoder, options, request.settings.seed)
        training, validation, test = (
            self._source(clips, model) for clips in (self._split.training, self._split.validation, self._split.test)
        )
        sound: tuple[Source, Source] | None = None
        if request.settings.unfreeze_after is not None:
            good = [
                [clip for clip in clips if clip.path.name not in self.damaged]
                for clips in (self._split.training, self._split.validation)
            ]
            sound = SoundSource(good[0], model, request.workers), SoundSource(good[1], model, request.workers)
        folder = request.out / RUNS_FOLDER / name.replace(" ", "-")
        trainer = Trainer(
            model,
            training,
            validation,
            request.settings,
            folder,
            sound=sound,
            progress=lambda done, total: self._progress(f"training {name}", done, total),
            accelerator=accelerator,
        )
        result = trainer.train()
        self._trainers.append(trainer)
        learnt = request.settings.unfreeze_after is not None and result.best_epoch > request.settings.unfreeze_after
        if learnt:
            # The cached features are of the encoder as it was.
            validation, test = (SoundSource(source.clips, model, request.workers) for source in (validation, test))
        model.options = replace(options, temperature=result.temperature)
        logits, found = self._predict(model, test)
        held_out, truth = self._predict(model, validation)
        loss = measure(replace(truth, probabilities=softmax(held_out, result.temperature))).log_loss
        for source in (training, validation, test):
            self.damaged |= source.failed
        variant = Variant(
            name,
            model.options,
            result,
            measure(replace(found, probabilities=softmax(logits)), request.older_from),
            measure(replace(found, probabilities=softmax(logits, result.temperature)), request.older_from),
            loss,
        )
        return variant, model

    def discard_state(self) -> None:
        """Remove what an interrupted run would need."""
        for trainer in self._trainers:
            trainer.discard_state()

    def _filled_cache(self) -> FeatureCache:
        request, accelerator = self._request, self._accelerator
        layers: Literal["last", "weighted"] = "weighted" if request.compare else request.options.layers
        model = new_classifier(request.encoder, replace(request.options, layers=layers), request.settings.seed)
        cache = FeatureCache(request.out / "cache", model)
        cache.add(
            (*self._split.training, *self._split.validation, *self._split.test),
            model,
            device=str(accelerator.device),
            workers=request.workers,
            share=(accelerator.process_index, accelerator.num_processes),
            progress=lambda done, total: self._progress("encoding", done, total),
        )
        accelerator.wait_for_everyone()
        cache.refresh()
        return cache

    def _source(self, clips: Sequence[Clip], model: WhisperAgeClassifier) -> Source:
        if self._cache is None:
            return SoundSource(clips, model, self._request.workers)
        return CachedSource(clips, self._cache, last_only=self._request.compare and model.options.layers == "last")

    def _predict(self, model: WhisperAgeClassifier, source: Source) -> tuple[Any, Predictions]:
        rows = predict(model, source, range(len(source.clips)), self._request.settings.batch_size, self._accelerator)
        clips = [source.clips[index] for index, _, _ in rows]
        logits = np.array([row for _, _, row in rows])
        return logits, Predictions(
            probabilities=softmax(logits),
            groups=np.array([clip.group for clip in clips]),
            genders=tuple(clip.gender for clip in clips),
            durations=np.array([seconds for _, seconds, _ in rows]),
        )


def _silent(what: str, done: int, total: int) -> None:
    """Show no progress."""


def _variants(request: TrainingRequest) -> list[tuple[str, AgeModelOptions]]:
    if not request.compare:
        return [("model", request.options)]
    paper = replace(request.options, pooling="mean", layers="last", targets="groups")
    return [
        ("paper", paper),
        ("ordinal targets", replace(paper, targets="ordinal")),
        ("attention pooling", replace(paper, pooling="attention")),
        ("layer sum", replace(paper, layers="weighted")),
        ("all options", replace(paper, targets="ordinal", pooling="attention", layers="weighted")),
    ]
