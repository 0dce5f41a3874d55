"""Takes the robot's own voice and steady noise out of what the microphone hears, with WebRTC's audio processing."""

import importlib.util
from collections import deque
from typing import Any

import numpy as np

from attune.core.config import SpeechConfig
from attune.core.errors import MissingDependencyError
from attune.speech.audio import FRAME_SAMPLES, SAMPLE_RATE, Frame, Samples
from attune.speech.loudness import Background, level

_BLOCK = SAMPLE_RATE // 100
"""WebRTC takes 10 ms at once."""
LATENCY = _BLOCK / SAMPLE_RATE
"""What comes out is later than what goes in [s]: frames are no whole number of blocks. Their times say so."""
_OUT_OF_STEP = 0.05
"""A microphone whose times run away from ours by more than this [s] has lost sound."""
_JOINED = 0.002
"""Pieces of playback that follow each other within this time [s] are one sound."""
_NOISY, _QUIET = -50.0, -54.0
"""Level of the background from which on noise is lowered, and under which it is not any more [dB full scale]: in a
quiet room that would only take from the speech."""
_ALMOST_NOISY = -58.0
"""From this level on [dB full scale] the noise is followed, so that it is known when it has to be lowered."""
_LOOKED_AT = 50
"""So many blocks pass between two looks at the background."""
_LEARNS_FROM = 200
"""So many blocks tell the noise: after a sudden one, those that were heard last."""


def make_cleaner(config: SpeechConfig, *, self_talk: bool) -> "EchoCanceller | None":
    """What the configuration asks for; None where there is nothing to clean, or no library to lower noise with.

    Args:
        config: Whether to cancel echo and to lower noise.
        self_talk: Whether the robot's own voice can reach the microphone.

    Raises:
        MissingDependencyError: The robot would hear itself, and the library is not installed.
    """
    echo = config.echo_cancellation and self_talk
    noise = config.noise_suppression and importlib.util.find_spec("livekit") is not None
    return EchoCanceller(echo_cancellation=echo, noise_suppression=noise) if echo or noise else None


class EchoCanceller:
    """Hears what the robot plays and subtracts its echo; lowers steady noise where there is any. Belongs to one thread.

    The echo may come up to about a third of a second after the sound was handed over: WebRTC finds the delay itself.

    Args:
        echo_cancellation: Subtract the echo.
        noise_suppression: Lower steady noise.

    Raises:
        MissingDependencyError: The library is not installed.
    """

    def __init__(self, *, echo_cancellation: bool = True, noise_suppression: bool = False) -> None:
        if importlib.util.find_spec("livekit") is None:
            raise MissingDependencyError("livekit", "echo cancellation", "Run `pip install livekit`")
        from livekit import rtc

        self._rtc = rtc
        self._echo = rtc.AudioProcessingModule(echo_cancellation=True, high_pass_filter=True)
        self._noise = rtc.AudioProcessingModule(noise_suppression=True, high_pass_filter=True)
        self._cancels, self._suppresses = echo_cancellation, noise_suppression
        self._background = Background(LATENCY)
        self._blocks = 0
        self._is_noisy = self._follows = False
        self._latest: deque[Samples] = deque(maxlen=_LEARNS_FROM)
        self._resampler: Any = None
        self._played: Samples = np.zeros(0, np.float32)
        self._played_from = 0
        self._played_until = 0.0
        self._position = 0
        self._next_time: float | None = None
        self._raw: Samples = np.zeros(0, np.float32)
        self._clean: Samples = np.zeros(_BLOCK, np.float32)

    def played(self, samples: Samples, rate: int, time: float) -> None:
        """Take what the robot plays: a `PlaybackHook`.

        Args:
            samples: Float, mono.
            rate: Samples per second.
            time: Clock time at which the first of them sounds [s].
        """
        if not self._cancels:
            return
        import soxr

        end = self._played_from + len(self._played)
        if self._resampler is None or abs(time - self._played_until) > _JOINED:
            self._resampler = soxr.ResampleStream(rate, SAMPLE_RATE, 1, dtype="float32")
            start = round(time * SAMPLE_RATE)
            if start < end:
                # Something else overtakes what was handed over before but has not sounded.
                self._played = self._played[: max(0, start - self._played_from)]
            else:
                self._played = np.concatenate([self._played, np.zeros(start - end, np.float32)])
        self._played = np.concatenate([self._played, self._resampler.resample_chunk(samples)])
        self._played_until = time + len(samples) / rate

    def clean(self, frame: Frame) -> Frame:
        """Take what the microphone hears; give it without the robot's voice, 10 ms later."""
        if self._next_time is None or abs(frame.time - self._next_time) > _OUT_OF_STEP:
            self._position = round(frame.time * SAMPLE_RATE) - len(self._raw)
            self._next_time = frame.time
        self._next_time += FRAME_SAMPLES / SAMPLE_RATE
        self._raw = np.concatenate([self._raw, frame.samples])
        while len(self._raw) >= _BLOCK:
            block, self._raw = self._raw[:_BLOCK], self._raw[_BLOCK:]
            self._clean = np.concatenate([self._clean, self._process(block)])
        samples, self._clean = self._clean[:FRAME_SAMPLES], self._clean[FRAME_SAMPLES:]
        return Frame(samples, frame.time - LATENCY)

    def _process(self, block: Samples) -> Samples:
        if self._cancels:
            self._echo.process_reverse_stream(self._frame(self._reference()))
            self._echo.set_stream_delay_ms(0)
            block = self._through(self._echo, block)
        if not self._suppresses:
            return block
        self._look_at_background(block)
        if not self._follows:
            self._latest.append(block)
            return block
        lowered = self._through(self._noise, block)
        return lowered if self._is_noisy else block

    def _look_at_background(self, block: Samples) -> None:
        self._background.accept(level(block))
        self._blocks += 1
        if self._blocks % _LOOKED_AT:
            return
        loudness = self._background.level
        self._is_noisy = loudness > (_QUIET if self._is_noisy else _NOISY)
        self._follows = loudness > _ALMOST_NOISY
        while self._follows and self._latest:
            self._through(self._noise, self._latest.popleft())

    def _through(self, processing: Any, block: Samples) -> Samples:
        frame = self._frame(block)
        processing.process_stream(frame)
        return np.frombuffer(bytes(frame.data), np.int16).astype(np.float32) / np.float32(32768)

    def _reference(self) -> Samples:
        """What the robot plays during the next block."""
        begin = self._position - self._played_from
        self._position += _BLOCK
        block = np.zeros(_BLOCK, np.float32)
        first, last = max(begin, 0), min(begin + _BLOCK, len(self._played))
        if first < last:
            block[first - begin : last - begin] = self._played[first:last]
        # What is past is not needed any more.
        past = min(max(begin + _BLOCK, 0), len(self._played))
        self._played = self._played[past:]
        self._played_from = self._position if len(self._played) == 0 else self._played_from + past
        return block

    def _frame(self, samples: Samples) -> Any:
        data = (np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes()
        return self._rtc.AudioFrame(bytearray(data), SAMPLE_RATE, 1, len(samples))
