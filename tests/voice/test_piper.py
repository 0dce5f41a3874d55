"""Piper behind the voice: real Piper and ONNX runtime; the voice itself is a small graph that hums for each phoneme."""

import json
from pathlib import Path

import anyio
import numpy as np
import pytest

from attune.core.bus import REPLY, VOICE_STATUS, Bus
from attune.core.clock import VirtualClock, run
from attune.core.config import VoiceConfig
from attune.core.messages import Reply
from attune.voice.piper import PiperSynthesiser, PiperVoiceError
from attune.voice.voice import Voice

pytest.importorskip("piper", reason="the extra `piper` is not installed")
onnx = pytest.importorskip("onnx", reason="needed to build a voice")

RATE = 16000


@pytest.fixture(scope="module")
def voice(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A voice of Piper's form: 256 samples of a sine for each phoneme, times the length scale."""
    from onnx import TensorProto, helper, numpy_helper

    def constant(name: str, value: object, kind: type = np.int64) -> onnx.TensorProto:
        return numpy_helper.from_array(np.array(value, kind), name)

    nodes = [
        helper.make_node("Cast", ["input_lengths"], ["count"], to=TensorProto.FLOAT),
        helper.make_node("Gather", ["scales", "one"], ["scale"]),
        helper.make_node("Mul", ["count", "scale"], ["long"]),
        helper.make_node("Mul", ["long", "hop"], ["length"]),
        helper.make_node("Squeeze", ["length"], ["end"]),
        helper.make_node("Range", ["zero", "end", "step"], ["index"]),
        helper.make_node("Mul", ["index", "frequency"], ["phase"]),
        helper.make_node("Sin", ["phase"], ["wave"]),
        helper.make_node("Reshape", ["wave", "shape"], ["output"]),
    ]
    graph = helper.make_graph(
        nodes,
        "hum",
        [
            helper.make_tensor_value_info("input", TensorProto.INT64, [1, None]),
            helper.make_tensor_value_info("input_lengths", TensorProto.INT64, [1]),
            helper.make_tensor_value_info("scales", TensorProto.FLOAT, [3]),
        ],
        [helper.make_tensor_value_info("output", TensorProto.FLOAT, [1, 1, None])],
        [
            constant("one", [1]), constant("hop", 256.0, np.float32), constant("zero", 0.0, np.float32),
            constant("step", 1.0, np.float32), constant("frequency", 0.1, np.float32), constant("shape", [1, 1, -1]),
        ],
    )  # fmt: skip
    path = tmp_path_factory.mktemp("voices") / "hum.onnx"
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    model.ir_version = 9
    onnx.save(model, str(path))
    ids = {symbol: [index] for index, symbol in enumerate("_^$ abcdefghijklmnopqrstuvwxyzɪɛəɹʌðŋʃæɑɔʊˈː.,?!")}
    settings = {"audio": {"sample_rate": RATE}, "espeak": {"voice": "en-us"}, "num_symbols": len(ids),
                "num_speakers": 1, "phoneme_id_map": ids, "phoneme_type": "espeak"}  # fmt: skip
    Path(f"{path}.json").write_text(json.dumps(settings))
    return path


def test_it_speaks_with_marks_for_every_word(voice: Path) -> None:
    speech = PiperSynthesiser(str(voice)).synthesise("Bring me the red cup.", loudness=0.5)
    assert speech.sample_rate == RATE
    assert 0.2 < speech.duration < 5
    assert np.abs(speech.samples).max() == pytest.approx(0.5, abs=0.01)
    assert [speech.text[mark.start : mark.end] for mark in speech.words] == ["Bring", "me", "the", "red", "cup."]
    assert speech.spoken_until(0.0) == "Bring"
    assert speech.spoken_until(speech.duration) == speech.text


def test_a_higher_rate_is_shorter(voice: Path) -> None:
    piper = PiperSynthesiser(str(voice))
    slow, fast = (piper.synthesise("bring me the red cup", rate_wpm=rate).duration for rate in (100, 200))
    assert slow == pytest.approx(2 * fast, rel=0.02)


def test_a_text_without_words_is_silence(voice: Path) -> None:
    speech = PiperSynthesiser(str(voice)).synthesise("")
    assert speech.words == ()
    assert speech.duration < 0.3


def test_a_voice_that_cannot_be_used_says_why_and_how_to_get_one(tmp_path: Path) -> None:
    (tmp_path / "alone.onnx").write_bytes(b"no model")
    (tmp_path / "broken.onnx").write_bytes(b"no model")
    (tmp_path / "broken.onnx.json").write_text("{}")
    for name, problem in (("en_GB-nobody", "not there"), ("alone.onnx", "settings"), ("broken.onnx", "loaded")):
        with pytest.raises(PiperVoiceError, match=problem) as failure:
            PiperSynthesiser(str(tmp_path / name) if name.endswith("onnx") else name)
        assert "piper.download_voices" in failure.value.remedy


def test_the_robot_s_voice_takes_it_from_the_configuration(voice: Path) -> None:
    clock, bus, finished = VirtualClock(), Bus(), []
    bus.on(VOICE_STATUS, lambda status: finished.append(status.spoken) if status.state == "finished" else None)

    async def main() -> None:
        async with anyio.create_task_group() as group:
            group.start_soon(Voice(bus, clock, VoiceConfig(engine="piper", voice=str(voice), output="none")).run)
            await clock.sleep(0)
            bus.publish(REPLY, Reply(time=clock.now(), text="Here is the cup."))
            await clock.sleep(10)
            group.cancel_scope.cancel()

    run(main, clock)
    assert finished == ["Here is the cup."]
