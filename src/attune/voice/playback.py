"""Where speech sounds: a loudspeaker, a file, or nowhere."""

import threading
import wave
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from attune.core.clock import Clock
from attune.core.errors import AttuneError, MissingDependencyError

Samples = NDArray[np.float32]
PlaybackHook = Callable[[Samples, int, float], None]
"""Called with samples (float32 mono), their rate, and the clock time at which the first of them sounds."""

_CHUNK = 0.02
"""Samples are handed over in pieces of this length [s]."""
_LEAD = 0.1
"""How far ahead of its time a piece is handed over [s], so that a busy moment does not tear the sound."""


class OutputError(AttuneError):
    """The output cannot be opened."""

    def __init__(self, output: str, reason: str) -> None:
        super().__init__(
            f"the voice cannot be played to {output}: {reason}",
            "Choose another with `voice.output` (speaker, file, none), `voice.device` or `voice.file`",
        )


class Output(Protocol):
    """Takes samples a little before they are to sound. No call blocks."""

    def send(self, samples: Samples, rate: int) -> None:
        """Add samples to what is to sound."""
        ...

    def silence(self) -> None:
        """Drop at once what has not sounded yet."""
        ...

    def close(self) -> None:
        """Release the device or file."""
        ...


class NoOutput:
    """Nobody hears it; the pace is the same."""

    def send(self, samples: Samples, rate: int) -> None:
        """Drop them."""

    def silence(self) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""


class FileOutput:
    """A WAV file that is valid at every moment and holds exactly what was audible, without the pauses between.

    Raises:
        OutputError: The file cannot be written.
    """

    def __init__(self, path: Path, rate: int) -> None:
        try:
            # Unbuffered, so that the header and the samples on disk always agree.
            self._file = path.open("wb", buffering=0)
        except OSError as error:
            raise OutputError(str(path), error.strerror or "cannot be written") from None
        self._rate = rate
        self._writer = wave.open(self._file, "wb")  # noqa: SIM115 - open until close()
        self._writer.setnchannels(1)
        self._writer.setsampwidth(2)
        self._writer.setframerate(rate)
        self._writer.writeframes(b"")

    def send(self, samples: Samples, rate: int) -> None:
        """Write them."""
        if rate != self._rate:
            raise ValueError(f"the file has {self._rate} samples per second, not {rate}")
        self._writer.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())

    def silence(self) -> None:
        """Do nothing: what is written has sounded, to within the lead of 0.1 s."""

    def close(self) -> None:
        """Close the file."""
        self._writer.close()
        self._file.close()


class SpeakerOutput:
    """The sound card, through PortAudio.

    Args:
        device: Name or number of the device; "" is the system's default.
        rate: Samples per second.

    Raises:
        MissingDependencyError: PortAudio is not installed.
        OutputError: There is no such device, or it cannot be opened.
    """

    def __init__(self, device: str, rate: int) -> None:
        try:
            import sounddevice
        except OSError:
            raise MissingDependencyError(
                "PortAudio", "a loudspeaker", "Install it with `sudo apt install libportaudio2`"
            ) from None
        self._guard = threading.Lock()
        self._waiting: Samples = np.zeros(0, np.float32)
        self._rate = rate
        try:
            self._stream = sounddevice.OutputStream(
                samplerate=rate,
                channels=1,
                dtype="float32",
                device=(int(device) if device.isdecimal() else device) if device else None,
                blocksize=round(rate * _CHUNK),
                callback=self._fill,
            )
            self._stream.start()
        except (sounddevice.PortAudioError, ValueError) as error:
            raise OutputError(f"loudspeaker {device!r}" if device else "the loudspeaker", str(error)) from None

    def send(self, samples: Samples, rate: int) -> None:
        """Add them to what the sound card takes next."""
        if rate != self._rate:
            raise ValueError(f"the loudspeaker has {self._rate} samples per second, not {rate}")
        with self._guard:
            self._waiting = np.concatenate([self._waiting, samples])

    def silence(self) -> None:
        """Drop what the sound card has not taken; a block of 20 ms may still sound."""
        with self._guard:
            self._waiting = np.zeros(0, np.float32)

    def close(self) -> None:
        """Release the sound card."""
        self._stream.close()

    def _fill(self, out: Any, frames: int, _time: Any, _status: Any) -> None:
        with self._guard:
            now, self._waiting = self._waiting[:frames], self._waiting[frames:]
        out[: len(now), 0] = now
        out[len(now) :, 0] = 0


class Player:
    """Plays samples through an output at the clock's pace, and can be paused while it does.

    Args:
        on_playback: Gets everything that sounds; echo cancellation takes it as its reference.
    """

    def __init__(self, clock: Clock, output: Output, on_playback: PlaybackHook | None = None) -> None:
        self._clock = clock
        self._output = output
        self._on_playback = on_playback
        self.paused = False
        """Set it to fall silent within 20 ms; unset it to go on from there."""

    async def play(self, samples: Samples, rate: int, on_position: Callable[[float], None] = lambda _: None) -> None:
        """Play to the end. Cancelling falls silent at once.

        Args:
            samples: Shape (n,), mono.
            rate: Samples per second.
            on_position: Called with the position [s] up to which the samples have sounded, about each 20 ms.
        """
        began = self._clock.now()
        step = max(1, round(rate * _CHUNK))
        length = len(samples) / rate
        sent = 0
        ended = False
        try:
            # A remainder under a microsecond is rounding: time may not move by so little.
            while (position := self._clock.now() - began) < length - 1e-6:
                if self.paused:
                    self._output.silence()
                    while self.paused:
                        on_position(position)
                        await self._clock.sleep(_CHUNK)
                    began = self._clock.now() - position
                    sent = round(position * rate)
                while sent < len(samples) and sent / rate <= position + _LEAD:
                    piece = samples[sent : sent + step]
                    self._output.send(piece, rate)
                    if self._on_playback:
                        self._on_playback(piece, rate, began + sent / rate)
                    sent += len(piece)
                on_position(position)
                await self._clock.sleep(min(_CHUNK, length - position))
            ended = True
        finally:
            if not ended:
                self._output.silence()
        on_position(length)
