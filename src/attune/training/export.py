"""From a trained model to its fast form: one ONNX graph with int8 weights."""

import json
import logging
import warnings
from pathlib import Path
from typing import cast

import torch
from torch import Tensor, nn

from attune.core.messages import AGE_GROUPS
from attune.speech.age.checkpoints import replaced_folder
from attune.speech.age.hub import require
from attune.speech.age.onnx_estimator import MODEL_FILE, SETTINGS_FILE
from attune.speech.age.whisper_classifier import WhisperAgeClassifier

_OPSET = 18


class _Probabilities(nn.Module):
    def __init__(self, model: WhisperAgeClassifier) -> None:
        super().__init__()
        self.model = model

    def forward(self, features: Tensor) -> Tensor:
        return cast(Tensor, self.model.probabilities(features))


def export_onnx(model: WhisperAgeClassifier, folder: Path, *, int8: bool = True) -> None:
    """Write a model for onnxruntime, atomically.

    The graph takes any even number of feature frames up to Whisper's 3000 and gives calibrated probabilities. With
    int8, the matrices are stored in 8 bits and multiplied so (the activations are scaled as they come); the two
    convolutions stay as they are. Weights use only seven of the bits: processors without VNNI add two products in 16
    bits, which full eight bits overflow (https://onnxruntime.ai/docs/performance/model-optimizations/quantization.html).

    Args:
        model: The trained model; it is left in evaluation mode.
        folder: Where to; replaced if it is there.
        int8: Quantise the matrices.

    Raises:
        MissingDependencyError: onnx or onnxscript is not installed.
    """
    require("onnx", "onnxscript", "onnxruntime")
    import onnx
    from onnxruntime.quantization import QuantType, quantize_dynamic

    model.eval().cpu()
    example = torch.zeros(1, model.config.num_mel_bins, 200)
    frames = 2 * torch.export.Dim("steps", min=5, max=model.config.max_source_positions)
    with replaced_folder(folder) as fresh:
        full = fresh / "full.onnx"
        with warnings.catch_warnings(), _quiet("torch.onnx", "onnxscript", "onnx_ir"):
            # The exporter warns about its own parts.
            warnings.simplefilter("ignore")
            torch.onnx.export(
                _Probabilities(model),
                (example,),
                str(full),
                input_names=["features"],
                output_names=["probabilities"],
                dynamic_shapes={"features": {2: frames}},
                opset_version=_OPSET,
                dynamo=True,
                external_data=False,
                verbose=False,
            )
        if int8:
            graph = onnx.load(full)
            # The quantiser turns matrices round and stumbles over the shapes that the exporter noted.
            del graph.graph.value_info[:]
            with _quiet(""):
                quantize_dynamic(
                    graph,
                    fresh / MODEL_FILE,
                    op_types_to_quantize=["MatMul", "Gemm"],
                    weight_type=QuantType.QInt8,
                    per_channel=True,
                    reduce_range=True,
                )
            full.unlink()
        else:
            full.rename(fresh / MODEL_FILE)
        settings = {
            "bands": model.config.num_mel_bins,
            "padded": model.options.length == "padded",
            "groups": list(AGE_GROUPS),
            "int8": int8,
        }
        (fresh / SETTINGS_FILE).write_text(json.dumps(settings, indent=2) + "\n", encoding="utf-8")


class _quiet:  # noqa: N801 - used like a function
    """Only errors of these loggers while the block runs."""

    def __init__(self, *names: str) -> None:
        self._loggers = [logging.getLogger(name) for name in names]

    def __enter__(self) -> None:
        self._levels = [logger.level for logger in self._loggers]
        for logger in self._loggers:
            logger.setLevel(logging.ERROR)

    def __exit__(self, *_: object) -> None:
        for logger, level in zip(self._loggers, self._levels, strict=True):
            logger.setLevel(level)
