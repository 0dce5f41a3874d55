"""Synthetic people: voices for the demo, tests and trials. Nothing here is a human recording."""

import shutil
import subprocess
import tempfile
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import soxr

from attune.core.clock import Clock
from attune.core.errors import MissingDependencyError
from attune.speech.audio import FRAME_SAMPLES, SAMPLE_RATE, Frame, Samples, read_recording
from attune.voice.synthesis import Synthesiser

_FLITE = "flite:"


@dataclass(frozen=True, slots=True)
class Speaker:
    """A synthetic person.

    Attributes:
        voice: An espeak-ng voice (`en-us+f3`), or `flite:` and a voice of the Debian package flite (`flite:slt`).
        rate_wpm: Words per minute (espeak-ng only).
        pitch: 0 to 100, 50 is the voice's own (espeak-ng only).
        level: Root mean square of the speech [dB relative to full scale].
        sounds: What a listener would guess; not what the person is.
    """

    name: str = "anna"
    voice: str = "en-us+f3"
    rate_wpm: int = 150
    pitch: int = 50
    level: float = -23.0
    sounds: Literal["younger", "older"] = "younger"

    def say(self, text: str) -> Samples:
        """Speech as 16 kHz mono. The same text gives the same samples.

        Raises:
            UnknownVoiceError: There is no such espeak-ng voice.
            MissingDependencyError: The voice needs flite, which is not installed.
        """
        if self.voice.startswith(_FLITE):
            samples = _flite(text, self.voice.removeprefix(_FLITE))
        else:
            speech = Synthesiser().synthesise(
                text, voice=self.voice, rate_wpm=self.rate_wpm, pitch=self.pitch, loudness=1.0
            )
            samples = soxr.resample(speech.samples, speech.sample_rate, SAMPLE_RATE).astype(np.float32)
        return at_level(_trimmed(samples), self.level)


def people() -> tuple[Speaker, ...]:
    """The synthetic people that every machine has (espeak-ng), then flite's where it is installed."""
    espeak = (
        Speaker("anna", "en-us+f3", 150, 50),
        Speaker("belinda", "en-us+f2", 160, 55),
        Speaker("clara", "en-gb+f2", 150, 50),
        Speaker("dan", "en-us+m1", 155, 50),
        Speaker("erik", "en-us+m6", 150, 45),
        Speaker("fred", "en-us+edward", 165, 50),
        Speaker("george", "en-us+grandpa", 130, 45, sounds="older"),
        Speaker("hilda", "en-us+f1", 125, 35, sounds="older"),
    )
    if not shutil.which("flite"):
        return espeak
    return espeak + tuple(Speaker(f"flite-{voice}", _FLITE + voice) for voice in ("slt", "rms", "awb", "kal16"))


def at_level(samples: Samples, level: float) -> Samples:
    """Scale so that the parts that sound have this root mean square [dB full scale]; peaks are kept from clipping."""
    sounding = samples[np.abs(samples) > 0.02 * max(float(np.abs(samples).max(initial=0.0)), 1e-9)]
    if len(sounding) == 0:
        return samples
    gain = 10 ** (level / 20) / float(np.sqrt(np.mean(sounding**2)))
    return (samples * min(gain, 0.99 / float(np.abs(samples).max()))).astype(np.float32)


def noise(count: int, level: float, rng: np.random.Generator, colour: Literal["white", "pink"] = "pink") -> Samples:
    """Noise of a root mean square [dB full scale]. Pink falls by 3 dB an octave, as in most rooms."""
    white = rng.standard_normal(count)
    if colour == "pink" and count > 1:
        spectrum = np.fft.rfft(white)
        spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
        spectrum[0] = 0
        white = np.fft.irfft(spectrum, count)
    power = float(np.sqrt(np.mean(white**2))) if count else 1.0
    return (white / max(power, 1e-12) * 10 ** (level / 20)).astype(np.float32)


def with_noise(
    samples: Samples, snr: float, rng: np.random.Generator, colour: Literal["white", "pink"] = "pink"
) -> Samples:
    """Add noise at a signal-to-noise ratio [dB], measured where the speech sounds."""
    sounding = samples[np.abs(samples) > 0.02 * float(np.abs(samples).max(initial=0.0))]
    level = 10 * float(np.log10(max(np.mean(sounding**2) if len(sounding) else 0.0, 1e-12)))
    return (samples + noise(len(samples), level - snr, rng, colour)).astype(np.float32)


def in_room(samples: Samples, rng: np.random.Generator, reverberation: float = 0.4, direct: float = 6.0) -> Samples:
    """Add the echo of a room: exponentially falling noise.

    Args:
        samples: The speech.
        rng: Draws the room.
        reverberation: Time in which the echo falls by 60 dB [s].
        direct: Level of the direct sound over the whole echo [dB].
    """
    from scipy.signal import fftconvolve

    times = np.arange(int(reverberation * SAMPLE_RATE)) / SAMPLE_RATE
    echo = rng.standard_normal(len(times)) * 10 ** (-3 * times / reverberation)
    # The first reflection comes after about a metre of detour.
    echo[: int(0.003 * SAMPLE_RATE)] = 0
    echo *= 10 ** (-direct / 20) / np.sqrt(np.sum(echo**2))
    echo[0] = 1
    return np.asarray(fftconvolve(samples, echo), dtype=np.float32)


class UserAudio:
    """A person in front of the microphone: what they are told to say sounds into a quiet room.

    Args:
        clock: The session's clock.
        speaker: Who speaks.
        floor: Root mean square of the room's noise [dB full scale].
        seed: Of the noise.
    """

    def __init__(self, clock: Clock, speaker: Speaker, *, floor: float = -65.0, seed: int = 0) -> None:
        self._clock = clock
        self._speaker = speaker
        self._rng = np.random.default_rng(seed)
        self._floor = floor
        self._spoken: list[tuple[float, Samples]] = []

    def say(self, text: str, at: float | None = None, speaker: Speaker | None = None) -> float:
        """Speak, as soon as what was said before has ended.

        Args:
            text: What to say.
            at: Clock time to begin at, if it is still to come; None is now.
            speaker: Somebody else than the usual speaker.

        Returns:
            Clock time at which the last sample of the speech sounds [s].
        """
        samples = (speaker or self._speaker).say(text)
        return self.sound(samples, at)

    def sound(self, samples: Samples, at: float | None = None) -> float:
        """As `say`, with any sound (16 kHz mono)."""
        begin = max([self._clock.now(), at or 0.0, *(start + len(s) / SAMPLE_RATE for start, s in self._spoken)])
        self._spoken.append((begin, samples))
        return begin + len(samples) / SAMPLE_RATE

    async def frames(self, clock: Clock) -> AsyncIterator[Frame]:
        """What the microphone hears; it never ends."""
        began = clock.now()
        index = 0
        while True:
            frame = Frame(noise(FRAME_SAMPLES, self._floor, self._rng), began + index * FRAME_SAMPLES / SAMPLE_RATE)
            await clock.sleep(frame.end - clock.now())
            for start, samples in tuple(self._spoken):
                offset = round((frame.time - start) * SAMPLE_RATE)
                if offset >= len(samples):
                    self._spoken.remove((start, samples))
                elif offset > -FRAME_SAMPLES:
                    piece = samples[max(offset, 0) : offset + FRAME_SAMPLES]
                    frame.samples[max(-offset, 0) : max(-offset, 0) + len(piece)] += piece
            yield frame
            index += 1


def _trimmed(samples: Samples) -> Samples:
    """Without the silence before and after, so that the last sample is the end of the speech."""
    sounding = np.flatnonzero(np.abs(samples) > 0.003)
    return samples[sounding[0] : sounding[-1] + 1] if len(sounding) else samples


def _flite(text: str, voice: str) -> Samples:
    program = shutil.which("flite")
    if program is None:
        raise MissingDependencyError("flite", f"the voice {voice!r}", "Install it with `sudo apt install flite`")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "speech.wav"
        subprocess.run([program, "-voice", voice, "-t", text, "-o", str(path)], check=True, capture_output=True)
        return read_recording(path)
