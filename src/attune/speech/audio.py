"""Where sound comes from: files, arrays, the microphone. All give frames of 512 samples at 16 kHz, mono."""

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from attune.core.clock import Clock
from attune.core.errors import AttuneError, MissingDependencyError

SAMPLE_RATE = 16_000
FRAME_SAMPLES = 512
"""What Silero VAD takes at once."""
FRAME_SECONDS = FRAME_SAMPLES / SAMPLE_RATE

Samples = NDArray[np.float32]
"""Shape (n,), mono, -1 to 1."""

_SHORTEST = 0.1
_SILENT = 1e-4
"""Under this peak (-80 dB) a recording holds nothing."""


_LEAST_RATE = 11_025
"""Telephone sound (8000 samples per second) is recognised as other words; from here on it works [Hz]."""


class AudioError(AttuneError):
    """A recording cannot be used."""

    def __init__(self, name: str, problem: str, remedy: str) -> None:
        super().__init__(f"{name} {problem}", remedy)


@dataclass(frozen=True, slots=True)
class Frame:
    """A piece of sound.

    Attributes:
        samples: Shape (512,), 16 kHz.
        time: Clock time of the first sample [s].
    """

    samples: Samples
    time: float

    @property
    def end(self) -> float:
        """Clock time after the last sample [s]."""
        return self.time + FRAME_SECONDS


class AudioSource(Protocol):
    """Gives sound frame by frame, each as soon as its last sample is there."""

    def frames(self, clock: Clock) -> AsyncIterator[Frame]:
        """Frames without a gap, until the sound ends. Call once."""
        ...


class ArraySource:
    """Sound in memory, at the clock's pace (under a virtual clock: as fast as it is processed).

    Args:
        samples: Shape (n,), or (n, channels), which are averaged.
        sample_rate: Samples per second; any.
        name: What errors call it.

    Raises:
        AudioError: The samples are empty, not numbers, or too short.
    """

    def __init__(self, samples: NDArray[Any], sample_rate: int = SAMPLE_RATE, name: str = "the recording") -> None:
        self.samples = to_mono_16k(samples, sample_rate, name)

    async def frames(self, clock: Clock) -> AsyncIterator[Frame]:
        """The sound; the last frame is filled up with silence."""
        began = clock.now()
        for index in range(0, len(self.samples), FRAME_SAMPLES):
            samples = self.samples[index : index + FRAME_SAMPLES]
            if len(samples) < FRAME_SAMPLES:
                samples = np.pad(samples, (0, FRAME_SAMPLES - len(samples)))
            frame = Frame(samples, began + index / SAMPLE_RATE)
            await clock.sleep(frame.end - clock.now())
            yield frame


def read_recording(path: Path) -> Samples:
    """A recording (WAV, FLAC, MP3, OGG; any rate, any number of channels) as 16 kHz mono.

    Raises:
        AudioError: It is missing, no recording, empty, broken, too short or silent; the message says which.
        MissingDependencyError: libsndfile cannot be loaded.
    """
    try:
        import soundfile
    except OSError:
        raise MissingDependencyError(
            "libsndfile", "reading recordings", "Install it with `sudo apt install libsndfile1`"
        ) from None
    name = str(path)
    if not path.is_file():
        raise AudioError(name, "is not a file", "Give the path of a recording")
    if path.stat().st_size == 0:
        raise AudioError(name, "is empty", "Record it again")
    try:
        samples, rate = soundfile.read(path, dtype="float32", always_2d=True)
    except soundfile.LibsndfileError:
        known = "WAV, FLAC, MP3 or OGG"
        raise AudioError(name, "is no recording in a known format", f"Convert it to {known}") from None
    except PermissionError:
        raise AudioError(name, "may not be read", "Give yourself the right to read it") from None
    recording = to_mono_16k(samples, rate, name)
    if np.abs(recording).max() < _SILENT:
        raise AudioError(name, "is silent", "Check the microphone it was recorded with")
    return recording


def to_mono_16k(samples: NDArray[Any], sample_rate: int, name: str = "the recording") -> Samples:
    """Sound of any rate and number of channels as the 16 kHz mono that the recogniser needs.

    Integers are scaled by their type's range.

    Raises:
        AudioError: The samples are empty, not numbers, too short, or the rate is impossible.
    """
    import soxr

    if samples.ndim not in {1, 2}:
        raise AudioError(name, f"has the shape {samples.shape}", "Give samples of shape (n,) or (n, channels)")
    if sample_rate < _LEAST_RATE:
        problem = f"has {sample_rate} samples per second, which lack the high sounds that tell words apart"
        raise AudioError(name, problem, f"Record with at least {SAMPLE_RATE}")
    if samples.dtype.kind == "i":
        samples = samples / np.float32(np.iinfo(samples.dtype).max)
    mono = np.asarray(samples.mean(axis=1) if samples.ndim == 2 else samples, dtype=np.float32)
    if len(mono) == 0:
        raise AudioError(name, "holds no sound", "Record it again")
    if not np.isfinite(mono).all():
        raise AudioError(name, "has samples that are not numbers", "Export it again")
    if len(mono) / sample_rate < _SHORTEST:
        milliseconds = 1000 * len(mono) / sample_rate
        raise AudioError(name, f"lasts only {milliseconds:.0f} ms", f"Record at least {1000 * _SHORTEST:.0f} ms")
    if sample_rate != SAMPLE_RATE:
        mono = soxr.resample(mono, sample_rate, SAMPLE_RATE)
    return np.ascontiguousarray(mono, dtype=np.float32)


class Microphone:
    """The sound card's input, through PortAudio; needs a real clock.

    Args:
        device: Name or number of the input device; "" is the system's default.

    Raises:
        MissingDependencyError: PortAudio is not installed.
        AudioError: There is no such device, or it cannot be opened.
    """

    def __init__(self, device: str = "") -> None:
        self._sounddevice = load_sounddevice()
        self._device = (int(device) if device.isdecimal() else device) if device else None
        self._name = f"microphone {device!r}" if device else "the microphone"
        try:
            info = self._sounddevice.query_devices(self._device, "input")
            self._rate = int(info["default_samplerate"])
        except (self._sounddevice.PortAudioError, ValueError) as error:
            raise self._unusable(error) from None

    async def frames(self, clock: Clock) -> AsyncIterator[Frame]:
        """What is heard from now on. Sound that the device lost leaves a gap in the times.

        Raises:
            AudioError: The device was lost, or taken by another program.
        """
        import soxr

        loop = asyncio.get_running_loop()
        blocks: asyncio.Queue[tuple[Samples, float]] = asyncio.Queue()
        resampler = soxr.ResampleStream(self._rate, SAMPLE_RATE, 1, dtype="float32")

        def collect(data: Any, _frames: int, _time: Any, _status: Any) -> None:
            loop.call_soon_threadsafe(blocks.put_nowait, (data[:, 0].copy(), clock.now()))

        try:
            stream = self._sounddevice.InputStream(
                device=self._device,
                samplerate=self._rate,
                channels=1,
                dtype="float32",
                blocksize=round(self._rate * FRAME_SECONDS),
                callback=collect,
            )
        except (self._sounddevice.PortAudioError, ValueError) as error:
            raise self._unusable(error) from None
        with stream:
            rest = np.zeros(0, np.float32)
            while True:
                block, at = await blocks.get()
                rest = np.concatenate([rest, resampler.resample_chunk(block)])
                while len(rest) >= FRAME_SAMPLES:
                    samples, rest = rest[:FRAME_SAMPLES], rest[FRAME_SAMPLES:]
                    yield Frame(samples, at - (len(samples) + len(rest)) / SAMPLE_RATE)

    def _unusable(self, error: Exception) -> AudioError:
        return AudioError(
            self._name,
            f"cannot be used: {error}",
            "See `attune devices`, choose one with `speech.microphone`, or listen to a file",
        )


def load_sounddevice() -> Any:
    """The sound card library.

    Raises:
        MissingDependencyError: PortAudio is not installed.
    """
    try:
        import sounddevice
    except OSError:
        raise MissingDependencyError(
            "PortAudio", "the microphone", "Install it with `sudo apt install libportaudio2`"
        ) from None
    return sounddevice
