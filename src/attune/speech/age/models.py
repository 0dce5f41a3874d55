"""One door to every age model: ours, the paper's, general ones of the hub, and their fast form for onnxruntime."""

from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from attune.speech.age.features import features_for
from attune.speech.age.hub import fetch, require


class AgeModel(Protocol):
    """Estimates the age group from one utterance."""

    def probabilities(
        self, samples: NDArray[np.float32], features: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """Over the nine groups of `AGE_GROUPS`, shape (9,), sums to 1. Blocks; call it in a thread.

        Args:
            samples: Shape (n,), 16 kHz, mono, -1 to 1.
            features: Their `log_mel`, if a recogniser computed it; a model that hears otherwise leaves it aside.
        """
        ...


class WhisperAgeModel:
    """The paper's model, run by torch.

    Args:
        classifier: A `WhisperAgeClassifier`.
        device: Where to run: `cpu`, `cuda` ...
    """

    def __init__(self, classifier: Any, device: str = "cpu") -> None:
        self.classifier = classifier.eval().to(device)
        self._device = device

    def probabilities(
        self, samples: NDArray[np.float32], features: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """Over the nine groups, shape (9,), from 16 kHz mono samples."""
        padded = self.classifier.options.length == "padded"
        bands = self.classifier.config.num_mel_bins
        return self.probabilities_of_features(features_for(samples, features, bands=bands, padded=padded))

    def probabilities_of_features(self, features: NDArray[np.float32]) -> NDArray[np.float64]:
        """The same from log-mel features (bands, even number of frames) that a Whisper recogniser has already."""
        import torch

        with torch.inference_mode():
            rows = self.classifier.probabilities(torch.from_numpy(features)[None].to(self._device))
        row: NDArray[np.float64] = rows[0].double().cpu().numpy()
        return np.asarray(row / row.sum())


def load_age_model(
    name: str, *, device: str = "cpu", years_per_unit: float | None = None, threads: int = 1
) -> AgeModel:
    """Load an age model by folder or hub name, whatever its layout.

    Args:
        name: Folder or hub name. A folder with `model.onnx` is run by onnxruntime, without torch.
        device: For models that run in torch: `cpu`, `cuda` ..., or `auto`, which is a GPU where torch sees one.
        years_per_unit: For regressions: what the output 1 stands for; None takes the layout's usual unit.
        threads: For onnxruntime.

    Raises:
        ModelNotFoundError: It is neither a folder nor can it be fetched.
        CheckpointError: The layout is not known, or the weights are damaged.
        LabelMappingError: Its labels name no ages.
        MissingDependencyError: The libraries that it needs are not installed.
    """
    folder = fetch(name)
    if (folder / "model.onnx").exists():
        from attune.speech.age.onnx_estimator import OnnxAgeModel

        return OnnxAgeModel(folder, threads=threads)
    require("torch", "transformers")
    if device == "auto":
        import torch

        device = "cuda" if torch.cuda.is_available() else "cpu"
    if _is_attention_classifier(folder):
        from attune.speech.age.checkpoints import load_classifier

        return WhisperAgeModel(load_classifier(str(folder)), device)
    from attune.speech.age.audio_classifiers import HubAudioClassifier

    return HubAudioClassifier(folder, years_per_unit, device)


def _is_attention_classifier(folder: Path) -> bool:
    """Whether it is ours or the authors': Whisper, with attention where transformers has one linear layer."""
    from attune.speech.age.checkpoints import OPTIONS_KEY, read_config

    config = read_config(folder)
    return config.get("model_type") == "whisper" and (
        OPTIONS_KEY in config or "WhisperForAudioClassification" not in (config.get("architectures") or [])
    )
