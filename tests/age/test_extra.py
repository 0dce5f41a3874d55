"""Most tests of age models need the extra `age`; without torch only this file says so."""

import importlib

import pytest

LIBRARIES = ("accelerate", "huggingface_hub", "matplotlib", "onnx", "onnxruntime", "onnxscript", "safetensors",
             "tensorboard", "transformers")  # fmt: skip


def test_the_extra_is_complete_where_torch_is_installed() -> None:
    pytest.importorskip("torch", reason="the tests of age models need `pip install 'attune-hri[age]'`")
    for name in LIBRARIES:
        importlib.import_module(name)
