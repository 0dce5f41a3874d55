"""The training loop: frozen encoder first, optionally the whole model then; stops early, resumes after a crash."""

import copy
import hashlib
import json
import math
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from accelerate import Accelerator
from accelerate.utils import gather_object
from numpy.typing import NDArray
from torch import Tensor, nn

from attune.speech.age.whisper_classifier import WhisperAgeClassifier
from attune.training.feature_cache import encoder_fingerprint
from attune.training.losses import age_loss, class_weights
from attune.training.metrics import fit_temperature
from attune.training.prediction import predict
from attune.training.saved_state import STATE_FILE, TrainingProgress, read_state, write_state
from attune.training.schedule import linear_rate
from attune.training.settings import Epoch, TrainingError, TrainingResult, TrainingSettings
from attune.training.sources import Batch, CachedSource, Source, plan_batches, read_ahead


class Trainer:
    """Trains one model.

    Args:
        model: Changed in place.
        training: Clips to learn from while the encoder is frozen.
        validation: Clips of other speakers; they decide when to stop, and the temperature.
        settings: How.
        folder: For the state that a crash leaves behind, and for TensorBoard's logs.
        sound: (training, validation) from sound, needed when `unfreeze_after` is set and the others are cached.
        progress: Called with the steps done and their total.
        accelerator: From `accelerate`, when several models are trained in one process.
    """

    def __init__(
        self,
        model: WhisperAgeClassifier,
        training: Source,
        validation: Source,
        settings: TrainingSettings,
        folder: Path,
        *,
        sound: tuple[Source, Source] | None = None,
        progress: Callable[[int, int], None] = lambda done, total: None,
        accelerator: Accelerator | None = None,
    ) -> None:
        if settings.unfreeze_after is not None and sound is None:
            raise TrainingError("the encoder cannot learn from cached features", "Give the sound as well")
        self._model = model
        self._frozen_sources = (training, validation)
        self._sound_sources = sound
        self._settings = settings
        self._folder = folder
        self._progress = progress
        self._accelerator = accelerator or Accelerator(mixed_precision=settings.precision)
        groups = np.array([clip.group for clip in training.clips])
        weights = class_weights(groups) if settings.class_weights == "balanced" else np.ones(9, np.float32)
        self._weights = torch.from_numpy(weights).to(self._accelerator.device)
        self._ordinal = model.options.targets == "ordinal"
        self._run = TrainingProgress()
        self._best: dict[str, Tensor] = {}
        self._plan = self._hash_of_plan()

    def train(self) -> TrainingResult:
        """Train, or go on with an interrupted run of the same plan.

        Raises:
            TrainingError: The folder holds a run of another plan, or the loss is no longer a number.
        """
        self._folder.mkdir(parents=True, exist_ok=True)
        torch.manual_seed(self._settings.seed)
        self._model.to(self._accelerator.device)
        saved = read_state(self._folder, self._plan)
        if saved is not None:
            self._run = TrainingProgress(**saved["run"])
            self._best = saved["best"]
        resumed_at = self._run.step
        writer = self._writer()
        stopped = self._is_stale()
        for frozen in self._phases():
            if stopped:
                break
            stopped = self._phase(frozen, saved, writer)
            saved = None
        if writer is not None:
            writer.close()
        self._model.load_state_dict(self._best, strict=False)
        logits, groups, _ = self._validate(self._model)
        return TrainingResult(
            history=tuple(Epoch(**epoch) for epoch in self._run.history),
            best_epoch=self._run.best_epoch,
            temperature=fit_temperature(logits, groups),
            steps=self._run.step,
            resumed_at=resumed_at,
            stopped_early=self._run.epoch < self._settings.epochs,
        )

    def discard_state(self) -> None:
        """Remove what a crash would need, once the result is safe."""
        if self._accelerator.is_main_process:
            (self._folder / STATE_FILE).unlink(missing_ok=True)

    def _phases(self) -> list[bool]:
        """Whether the encoder is frozen, for each phase that is still to do."""
        border = self._border()
        phases = [True] if self._run.epoch < border else []
        return phases + ([False] if border < self._settings.epochs else [])

    def _border(self) -> int:
        after = self._settings.unfreeze_after
        return self._settings.epochs if after is None else min(after, self._settings.epochs)

    def _is_stale(self) -> bool:
        return bool(self._run.history) and self._run.epoch - self._run.best_epoch >= self._settings.patience

    def _sources(self, frozen: bool) -> tuple[Source, Source]:
        if frozen or self._sound_sources is None:
            return self._frozen_sources
        return self._sound_sources

    def _phase(self, frozen: bool, saved: dict[str, Any] | None, writer: Any) -> bool:
        """Epochs with the encoder frozen, or with all weights learning; True when it stopped early."""
        settings, accelerator, run = self._settings, self._accelerator, self._run
        first, last = (0, self._border()) if frozen else (self._border(), settings.epochs)
        training, _ = self._sources(frozen)
        share = (accelerator.process_index, accelerator.num_processes)
        lengths = training.lengths()
        per_epoch = len(plan_batches(len(training.clips), settings.batch_size, seed=0, share=share))
        self._model.encoder.requires_grad_(not frozen)
        trained: nn.Module = self._model.head if frozen and isinstance(training, CachedSource) else self._model
        groups = [{"params": list(self._model.head.parameters()), "lr": settings.learning_rate}]
        if not frozen:
            learning = [
                value for name, value in self._model.encoder.named_parameters() if "embed_positions" not in name
            ]
            groups.append({"params": learning, "lr": settings.encoder_learning_rate})
            self._model.encoder.embed_positions.requires_grad_(False)
            # Should no later epoch be better, the encoder goes back with the classifier.
            for name, value in self._model.encoder.state_dict().items():
                self._best.setdefault(f"encoder.{name}", value.detach().cpu().clone())
        optimizer = torch.optim.AdamW(groups, weight_decay=settings.weight_decay)
        steps = per_epoch * (last - first)
        scheduler = torch.optim.lr_scheduler.LambdaLR(optimizer, partial(linear_rate, steps, settings.warmup))
        if saved is not None:
            self._model.load_state_dict(saved["model"], strict=False)
        if saved is not None and saved["frozen"] == frozen:
            optimizer.load_state_dict(saved["optimizer"])
            scheduler.load_state_dict(saved["scheduler"])
            torch.set_rng_state(saved["rng"].cpu())
        module, optimizer = accelerator.prepare(trained, optimizer)
        if saved is not None and saved["frozen"] == frozen and accelerator.scaler is not None and saved["scaler"]:
            accelerator.scaler.load_state_dict(saved["scaler"])
        total = per_epoch * settings.epochs
        while run.epoch < last:
            seed = settings.seed * 100_003 + run.epoch
            plan = plan_batches(len(training.clips), settings.batch_size, seed=seed, lengths=lengths, share=share)
            module.train()
            if frozen:
                self._model.encoder.eval()
            for batch in read_ahead([partial(training.batch, each) for each in plan[run.step_in_epoch :]]):
                run.loss_sum += self._step(module, optimizer, batch)
                scheduler.step()
                run.step += 1
                run.step_in_epoch += 1
                if run.step % settings.save_every == 0:
                    self._save_state(frozen, optimizer, scheduler)
                self._progress(run.step, total)
            stop = self._end_epoch(module, frozen, per_epoch, scheduler.get_last_lr()[0], writer)
            self._save_state(frozen, optimizer, scheduler)
            if stop:
                break
        accelerator.free_memory(module, optimizer)
        return self._is_stale()

    def _step(self, module: nn.Module, optimizer: Any, batch: Batch) -> float:
        accelerator = self._accelerator
        inputs, mask, groups = (
            None if each is None else each.to(accelerator.device) for each in (batch.inputs, batch.mask, batch.groups)
        )
        with accelerator.autocast():
            logits = module(inputs, mask)
        loss = age_loss(logits, groups, self._weights, ordinal=self._ordinal)
        value = float(loss.detach())
        if not math.isfinite(value):
            raise TrainingError(
                f"the loss is {value} at step {self._run.step}", "Lower the learning rate, or train with --precision no"
            )
        accelerator.backward(loss)
        accelerator.clip_grad_norm_(module.parameters(), 1.0)
        optimizer.step()
        optimizer.zero_grad()
        return value

    def _end_epoch(self, module: nn.Module, frozen: bool, per_epoch: int, rate: float, writer: Any) -> bool:
        """Validate, remember the best weights; True when the loss has not fallen for too long."""
        run = self._run
        logits, groups, loss = self._validate(self._accelerator.unwrap_model(module), frozen)
        run.epoch += 1
        epoch = Epoch(
            number=run.epoch,
            training_loss=run.loss_sum / per_epoch,
            validation_loss=loss,
            validation_accuracy=float((logits.argmax(axis=1) == groups).mean()),
            learning_rate=rate,
        )
        run.history.append(asdict(epoch))
        run.step_in_epoch, run.loss_sum = 0, 0.0
        if loss < run.best_loss:
            run.best_loss, run.best_epoch = loss, run.epoch
            self._best = self._learnt_state()
        if writer is not None:
            for name, value in asdict(epoch).items():
                writer.add_scalar(name.replace("_", "/", 1), value, run.step)
        return self._is_stale()

    def _validate(
        self, module: nn.Module, frozen: bool | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], float]:
        """Logits and groups of the validation clips, and their loss; the work is shared among the processes."""
        if frozen is None:
            frozen = self._run.best_epoch <= self._border()
        _, source = self._sources(frozen)
        accelerator = self._accelerator
        own = range(len(source.clips))[accelerator.process_index :: accelerator.num_processes]
        rows = predict(module, source, own, self._settings.batch_size, accelerator)
        gathered = gather_object(rows) if accelerator.num_processes > 1 else rows
        by_index = {index: logits for index, _, logits in gathered}
        order = sorted(by_index)
        table = np.array([by_index[index] for index in order])
        groups = np.array([source.clips[index].group for index in order])
        loss = age_loss(torch.from_numpy(table), torch.from_numpy(groups), self._weights.cpu(), ordinal=self._ordinal)
        return table, groups, float(loss)

    def _learnt_state(self) -> dict[str, Tensor]:
        """The weights that differ from the start: the head, and the encoder once it has learnt."""
        encoder = self._run.epoch > self._border()
        return {
            key: value.detach().cpu().clone()
            for key, value in self._model.state_dict().items()
            if encoder or key.startswith("head.")
        }

    def _hash_of_plan(self) -> str:
        """Hash of everything that must be the same when a run is taken up."""
        training, validation = self._frozen_sources
        facts = {
            "settings": asdict(self._settings) | {"save_every": 0},
            "options": self._model.options.to_data(),
            "encoder": encoder_fingerprint(self._model),
            "clips": [[clip.path.name for clip in source.clips] for source in (training, validation)],
            "processes": self._accelerator.num_processes,
        }
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()

    def _save_state(self, frozen: bool, optimizer: Any, scheduler: Any) -> None:
        if self._accelerator.is_main_process:
            scaler = self._accelerator.scaler
            data = {
                "plan": self._plan,
                "frozen": frozen,
                "run": copy.deepcopy(asdict(self._run)),
                "best": self._best,
                "model": {
                    key: value
                    for key, value in self._model.state_dict().items()
                    if self._run.epoch >= self._border() or key.startswith("head.")
                },
                "optimizer": optimizer.state_dict(),
                "scheduler": scheduler.state_dict(),
                "scaler": scaler.state_dict() if scaler is not None else {},
                "rng": torch.get_rng_state(),
            }
            write_state(self._folder, data)

    def _writer(self) -> Any:
        if not self._accelerator.is_main_process:
            return None
        from torch.utils.tensorboard import SummaryWriter

        return SummaryWriter(str(self._folder / "logs"))
