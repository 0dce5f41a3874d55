"""General age classifiers of the hub: Whisper or wav2vec2 and its relatives, with classes or a regression.

Three layouts are known: an audio classifier of transformers whose labels name ages (`female_20-29`), one with a single
output that is an age, and wav2vec2 with one head for age and one for gender (weights `wav2vec2.*`, `age.*`,
`gender.*`, as in audEERING's published models; its age is in units of 100 years).

This module needs torch and transformers.
"""

from pathlib import Path
from typing import cast

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from transformers import (
    AutoConfig,
    AutoFeatureExtractor,
    AutoModelForAudioClassification,
    Wav2Vec2Config,
    Wav2Vec2Model,
)

from attune.speech.age.checkpoints import CheckpointError, read_config, read_weights
from attune.speech.age.features import SAMPLE_RATE, log_mel
from attune.speech.age.groups import groups_from_labels, groups_from_years

AGE_AND_GENDER_YEARS = 100.0
"""Years that the output 1 of an age-and-gender model stands for."""
_SHORTEST = 0.2
"""wav2vec2's convolutions need some sound [s]."""


class HeadWithTanh(nn.Module):
    """Linear, tanh, linear, as in the age-and-gender models."""

    def __init__(self, width: int, outputs: int) -> None:
        super().__init__()
        self.dense = nn.Linear(width, width)
        self.out_proj = nn.Linear(width, outputs)

    def forward(self, pooled: Tensor) -> Tensor:
        """From shape (batch, width) to (batch, outputs)."""
        return cast(Tensor, self.out_proj(torch.tanh(self.dense(pooled))))


class AgeAndGenderModel(nn.Module):
    """wav2vec2 with an age and a gender head. The gender is not used."""

    def __init__(self, config: Wav2Vec2Config, genders: int) -> None:
        super().__init__()
        self.wav2vec2 = Wav2Vec2Model(config)
        self.age = HeadWithTanh(config.hidden_size, 1)
        self.gender = HeadWithTanh(config.hidden_size, genders)

    def forward(self, samples: Tensor) -> Tensor:
        """Age of shape (batch,), in the unit of the model, from normalised samples of shape (batch, n)."""
        frames = self.wav2vec2(samples).last_hidden_state
        return cast(Tensor, self.age(frames.mean(dim=1)).squeeze(-1))


class HubAudioClassifier:
    """An audio classifier of the hub as an age model.

    Args:
        folder: Of the model.
        years_per_unit: What the output 1 of a regression stands for; None takes the usual unit of the layout (100
            for age-and-gender models, 1 otherwise).
        device: Where to run: `cpu`, `cuda` ...

    Raises:
        CheckpointError: The layout is not known, or the weights do not fit.
        LabelMappingError: The labels name no ages.
    """

    def __init__(self, folder: Path, years_per_unit: float | None = None, device: str = "cpu") -> None:
        self._device = device
        config = read_config(folder)
        self._whisper_bands = int(config.get("num_mel_bins", 80)) if config.get("model_type") == "whisper" else 0
        self._extractor = None
        if (folder / "preprocessor_config.json").exists() and not self._whisper_bands:
            self._extractor = AutoFeatureExtractor.from_pretrained(folder)
        # Only the age-and-gender layout has these names.
        weights = read_weights(folder)
        self._matrix: NDArray[np.float64] | None = None
        self._model: nn.Module
        if "age.out_proj.weight" in weights:
            self._model = self._age_and_gender(folder, weights)
            self._unit = years_per_unit or AGE_AND_GENDER_YEARS
        else:
            try:
                settings = AutoConfig.from_pretrained(folder)
                self._model = AutoModelForAudioClassification.from_pretrained(folder, config=settings)
            except (ValueError, OSError, RuntimeError) as error:
                raise CheckpointError(f"{folder} holds no audio classifier: {error}", "Give another model") from None
            self._unit = years_per_unit or 1.0
            if settings.num_labels > 1:
                labels = [str(settings.id2label[index]) for index in range(settings.num_labels)]
                self._matrix = groups_from_labels(labels)
        self._model.eval().to(device)

    def probabilities(
        self, samples: NDArray[np.float32], features: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """Over the nine groups, shape (9,), from 16 kHz mono samples."""
        with torch.inference_mode():
            output = self._model(self._input(samples).to(self._device))
            if isinstance(output, Tensor):
                return groups_from_years(float(output[0]) * self._unit)
            logits = output.logits[0].double().cpu()
            if self._matrix is None:
                return groups_from_years(float(logits[0]) * self._unit)
            return cast(NDArray[np.float64], torch.softmax(logits, dim=-1).numpy() @ self._matrix)

    def _input(self, samples: NDArray[np.float32]) -> Tensor:
        if self._whisper_bands:
            return torch.from_numpy(log_mel(samples, bands=self._whisper_bands, padded=True))[None]
        sound = np.pad(samples, (0, max(0, int(_SHORTEST * SAMPLE_RATE) - len(samples))))
        if self._extractor is not None:
            values = self._extractor(sound, sampling_rate=SAMPLE_RATE, return_tensors="np").input_values
            return torch.from_numpy(np.asarray(values, np.float32))
        return torch.from_numpy((sound - sound.mean()) / np.sqrt(sound.var() + 1e-7))[None]

    @staticmethod
    def _age_and_gender(folder: Path, weights: dict[str, Tensor]) -> AgeAndGenderModel:
        genders = len(weights["gender.out_proj.weight"]) if "gender.out_proj.weight" in weights else 0
        if not genders or weights["age.out_proj.weight"].shape[0] != 1:
            raise CheckpointError(f"{folder} is no age-and-gender model with one age output", "Give another model")
        model = AgeAndGenderModel(Wav2Vec2Config.from_pretrained(folder), genders)
        # Older checkpoints carry the weight norm of the positional convolution under its former names.
        renamed = {
            key.replace("conv.weight_g", "conv.parametrizations.weight.original0").replace(
                "conv.weight_v", "conv.parametrizations.weight.original1"
            ): value
            for key, value in weights.items()
        }
        missing, unexpected = model.load_state_dict(renamed, strict=False)
        # Only needed while pre-training with masks.
        missing = [key for key in missing if key != "wav2vec2.masked_spec_embed"]
        if missing or unexpected:
            raise CheckpointError(
                f"{folder} is not laid out as an age-and-gender model (missing: {missing[:3]}, unknown: "
                f"{unexpected[:3]})",
                "Give another model",
            )
        return model
