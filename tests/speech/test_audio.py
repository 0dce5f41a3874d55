"""Sound of any kind becomes 16 kHz mono frames; what cannot be used is named in one line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import soundfile

from attune.core.clock import VirtualClock, run
from attune.core.errors import AttuneError
from attune.speech.audio import FRAME_SECONDS, ArraySource, AudioError, Frame, read_recording

TONE = (0.3 * np.sin(2 * np.pi * 440 * np.arange(48000) / 48000)).astype(np.float32)


def collect(source: ArraySource) -> list[tuple[float, Frame]]:
    clock = VirtualClock()

    async def main() -> list[tuple[float, Frame]]:
        await clock.sleep(3.0)
        return [(clock.now(), frame) async for frame in source.frames(clock)]

    return run(main, clock)


def test_a_frame_arrives_when_its_last_sample_has_sounded() -> None:
    frames = collect(ArraySource(TONE[:16000]))
    assert [frame.time for _, frame in frames] == pytest.approx([3.0 + i * FRAME_SECONDS for i in range(len(frames))])
    assert all(arrived == pytest.approx(frame.end) for arrived, frame in frames)
    assert len(frames) == 32


@pytest.mark.parametrize("suffix", ["wav", "flac", "mp3", "ogg"])
def test_recordings_of_any_format_rate_and_channels_become_16_khz_mono(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"tone.{suffix}"
    soundfile.write(path, np.stack([TONE, TONE], axis=1), 48000)
    samples = read_recording(path)
    assert abs(len(samples) - 16000) < 1500
    spectrum = np.abs(np.fft.rfft(samples[2000:12000]))
    assert np.argmax(spectrum) * 16000 / 10000 == pytest.approx(440, abs=5)


def test_integers_are_scaled_to_one() -> None:
    source = ArraySource((TONE[:4800] * 32767).astype(np.int16), 16000)
    assert np.abs(source.samples).max() == pytest.approx(0.3, abs=0.01)


def _write(samples: np.ndarray, **more: str) -> Callable[[Path], None]:
    return lambda path: soundfile.write(path, samples, 16000, format="WAV", **more)


BAD: dict[str, tuple[Callable[[Path], object], str]] = {
    "missing": (lambda path: None, "is not a file"),
    "empty": (lambda path: path.write_bytes(b""), "is empty"),
    "text": (lambda path: path.write_text("hello, this is no sound"), "no recording in a known format"),
    "no samples": (_write(np.zeros(0)), "holds no sound"),
    "silent": (_write(np.zeros(16000)), "is silent"),
    "short": (_write(TONE[:500]), "lasts only 31 ms"),
    "not numbers": (_write(np.full(16000, np.nan), subtype="FLOAT"), "not numbers"),
}


@pytest.mark.parametrize("kind", BAD)
def test_a_recording_that_cannot_be_used_is_named_with_the_reason(tmp_path: Path, kind: str) -> None:
    make, reason = BAD[kind]
    path = tmp_path / "recording.wav"
    make(path)
    with pytest.raises(AudioError, match=reason) as failure:
        read_recording(path)
    assert str(path) in str(failure.value)
    assert "\n" not in str(failure.value)
    assert failure.value.remedy


def test_a_truncated_recording_is_read_as_far_as_it_goes_or_named(tmp_path: Path) -> None:
    path = tmp_path / "cut.wav"
    soundfile.write(path, TONE, 48000)
    path.write_bytes(path.read_bytes()[:20000])
    try:
        assert len(read_recording(path)) > 1000
    except AttuneError as error:
        assert str(path) in str(error)
