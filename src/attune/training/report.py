"""The report of a training: it is kept beside the weights, and the evaluation finds the held-out clips by it."""

from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import torch

from attune.training.common_voice import Split, describe, fingerprint_of_clips
from attune.training.request import TrainingRequest, Variant


def training_report(
    request: TrainingRequest,
    split: Split,
    dropped: dict[str, int],
    kept: Variant,
    variants: Sequence[Variant],
    damaged: dict[str, str],
) -> dict[str, Any]:
    """What was trained, from what and how well, as JSON can hold it; counts and file names, no speakers."""
    return {
        "encoder": Path(request.encoder).name if Path(request.encoder).is_dir() else request.encoder,
        "corpus": {
            "name": request.corpus.resolve().name,
            "files": list(request.files),
            "minimum_clips": request.minimum,
            "dropped": dropped,
            "damaged": {"count": len(damaged), "examples": dict(list(damaged.items())[:20])},
            "training": describe(split.training),
            "validation": describe(split.validation),
            "test": describe(split.test),
        },
        "split": {
            "by": request.split_by,
            "training_share": request.training_share,
            "validation_share": request.validation_share,
            "seed": request.settings.seed,
            "test_clips": fingerprint_of_clips(split.test),
        },
        "older_from": request.older_from,
        "options": kept.options.to_data(),
        "settings": asdict(request.settings),
        "kept": kept.name,
        "best_epoch": kept.result.best_epoch,
        "stopped_early": kept.result.stopped_early,
        "steps": kept.result.steps,
        "history": [asdict(epoch) for epoch in kept.result.history],
        "test": kept.after.to_data(),
        "variants": {
            variant.name: {
                "without_temperature": variant.before.to_data(),
                "with_temperature": variant.after.to_data(),
                "temperature": variant.result.temperature,
                "validation_log_loss": variant.validation_loss,
                "epochs": len(variant.result.history),
            }
            for variant in variants
        },
        "versions": {name: version(name) for name in ("torch", "transformers", "accelerate", "attune-hri")},
        "device": torch.cuda.get_device_name() if torch.cuda.is_available() else "cpu",
    }
