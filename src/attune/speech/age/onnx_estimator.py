"""The age model in its fast form: int8 weights, run by onnxruntime. Needs neither torch nor transformers."""

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attune.core.errors import AttuneError
from attune.speech.age.features import features_for
from attune.speech.age.hub import require

MODEL_FILE = "model.onnx"
SETTINGS_FILE = "attune_age.json"


class OnnxModelError(AttuneError):
    """The exported model cannot be used."""


class OnnxAgeModel:
    """An exported age model.

    Args:
        folder: What `attune.training.export.export_onnx` wrote.
        threads: Processor cores to use.

    Raises:
        OnnxModelError: The folder is incomplete or damaged.
        MissingDependencyError: onnxruntime is not installed.
    """

    def __init__(self, folder: Path, threads: int = 1) -> None:
        require("onnxruntime", extra="age-onnx")
        import onnxruntime

        try:
            settings = json.loads((folder / SETTINGS_FILE).read_text(encoding="utf-8"))
            self._bands = int(settings["bands"])
            self._padded = bool(settings["padded"])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise OnnxModelError(
                f"{folder / SETTINGS_FILE} cannot be used: {error}", "Export the model again"
            ) from None
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = threads
        options.inter_op_num_threads = 1
        try:
            self._session = onnxruntime.InferenceSession(
                str(folder / MODEL_FILE), options, providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # noqa: BLE001 - onnxruntime's exceptions have no public base class
            raise OnnxModelError(f"{folder / MODEL_FILE} cannot be loaded: {error}", "Export it again") from None

    def probabilities(
        self, samples: NDArray[np.float32], features: NDArray[np.float32] | None = None
    ) -> NDArray[np.float64]:
        """Over the nine groups, shape (9,), from 16 kHz mono samples."""
        return self.probabilities_of_features(features_for(samples, features, bands=self._bands, padded=self._padded))

    def probabilities_of_features(self, features: NDArray[np.float32]) -> NDArray[np.float64]:
        """The same from log-mel features (bands, even number of frames) that a Whisper recogniser has already."""
        (rows,) = self._session.run(["probabilities"], {"features": features[None]})
        row: NDArray[np.float64] = np.asarray(rows[0], np.float64)
        return np.asarray(row / row.sum())
