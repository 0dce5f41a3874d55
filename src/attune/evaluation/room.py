"""A simulated room: a loudspeaker that the robot speaks through, a person, and a microphone that hears both."""

from collections.abc import AsyncIterator

import numpy as np
import soxr
from scipy.signal import fftconvolve

from attune.core.clock import Clock
from attune.evaluation.speakers import Speaker, UserAudio, in_room
from attune.speech.audio import FRAME_SAMPLES, SAMPLE_RATE, Frame, Samples
from attune.voice.playback import Output


class RoomAudio(Output):
    """Give it to the voice as its output and to the listener as its source.

    Args:
        clock: The session's clock.
        speaker: The person.
        echo_level: Of the robot's voice at the microphone, relative to what is played [dB].
        delay: From handing samples over to hearing them [s]: sound card and way.
        reverberation: Time in which the room's echo falls by 60 dB [s].
        floor: Root mean square of the room's noise [dB full scale].
        seed: Draws the room and the noise.
    """

    def __init__(
        self,
        clock: Clock,
        speaker: Speaker,
        *,
        echo_level: float = -6.0,
        delay: float = 0.05,
        reverberation: float = 0.3,
        floor: float = -65.0,
        seed: int = 0,
    ) -> None:
        self._clock = clock
        self.person = UserAudio(clock, speaker, floor=floor, seed=seed)
        """What they say is heard together with the robot."""
        impulse = np.zeros(round(0.4 * SAMPLE_RATE), np.float32)
        impulse[0] = 10 ** (echo_level / 20)
        way = in_room(impulse, np.random.default_rng(seed), reverberation)[: len(impulse)]
        self._way = np.concatenate([np.zeros(round(delay * SAMPLE_RATE), np.float32), way])
        self._sounded: Samples = np.zeros(len(self._way), np.float32)
        self._waiting: Samples = np.zeros(0, np.float32)
        self._resampler: soxr.ResampleStream | None = None

    def send(self, samples: Samples, rate: int) -> None:
        """Play."""
        if self._resampler is None:
            self._resampler = soxr.ResampleStream(rate, SAMPLE_RATE, 1, dtype="float32")
        self._waiting = np.concatenate([self._waiting, self._resampler.resample_chunk(samples)])

    def silence(self) -> None:
        """Drop what has not sounded."""
        self._waiting = np.zeros(0, np.float32)
        self._resampler = None

    def close(self) -> None:
        """Do nothing."""

    async def frames(self, clock: Clock) -> AsyncIterator[Frame]:
        """What the microphone hears; it never ends."""
        async for frame in self.person.frames(clock):
            now, self._waiting = self._waiting[:FRAME_SAMPLES], self._waiting[FRAME_SAMPLES:]
            now = np.pad(now, (0, FRAME_SAMPLES - len(now)))
            self._sounded = np.concatenate([self._sounded, now])[-(len(self._way) + FRAME_SAMPLES) :]
            echo = fftconvolve(self._sounded, self._way)[len(self._sounded) - FRAME_SAMPLES : len(self._sounded)]
            yield Frame((frame.samples + echo).astype(np.float32), frame.time)
