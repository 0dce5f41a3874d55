"""Logits of many clips, batch by batch."""

from collections.abc import Sequence
from functools import partial

import torch
from accelerate import Accelerator
from torch import nn

from attune.speech.age.whisper_classifier import WhisperAgeClassifier
from attune.training.sources import CachedSource, Source, read_ahead


def predict(
    module: nn.Module, source: Source, indices: Sequence[int], batch_size: int, accelerator: Accelerator
) -> list[tuple[int, float, list[float]]]:
    """Index, length [s] and logits of the clips with these indices, without damaged ones."""
    if isinstance(module, WhisperAgeClassifier) and isinstance(source, CachedSource):
        module = module.head
    module.eval()
    batches = [indices[start : start + batch_size] for start in range(0, len(indices), batch_size)]
    rows: list[tuple[int, float, list[float]]] = []
    for batch in read_ahead([partial(source.batch, each) for each in batches]):
        mask = None if batch.mask is None else batch.mask.to(accelerator.device)
        with torch.inference_mode(), accelerator.autocast():
            logits = module(batch.inputs.to(accelerator.device), mask).float().cpu().tolist()
        rows += list(zip(batch.clips, batch.seconds, logits, strict=True))
    return rows
