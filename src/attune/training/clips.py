"""Reading recordings, any rate and format that soundfile knows (mp3, wav, flac, ogg)."""

from pathlib import Path

import numpy as np
import soundfile
import soxr
from numpy.typing import NDArray

from attune.core.errors import AttuneError
from attune.speech.age.features import LONGEST, SAMPLE_RATE

SHORTEST = 0.2
"""A clip with less sound teaches nothing [s]."""


class ClipError(AttuneError):
    """A clip cannot be used."""


def read_clip(path: Path) -> NDArray[np.float32]:
    """One clip as 16 kHz mono, shape (n,), at most 30 s.

    Raises:
        ClipError: The file is missing, damaged, too short or silent.
    """
    try:
        with soundfile.SoundFile(path) as file:
            samples = file.read(int(LONGEST * file.samplerate), dtype="float32", always_2d=True).mean(axis=1)
            rate = file.samplerate
    except (soundfile.LibsndfileError, RuntimeError, OSError) as error:
        raise ClipError(f"{path.name} cannot be read: {error}") from None
    if rate != SAMPLE_RATE:
        samples = soxr.resample(samples, rate, SAMPLE_RATE)
    sound: NDArray[np.float32] = np.asarray(samples, np.float32)
    if len(sound) < SHORTEST * SAMPLE_RATE:
        raise ClipError(f"{path.name} holds only {len(sound) / SAMPLE_RATE:.2f} s of sound")
    if not np.isfinite(sound).all() or not sound.any():
        raise ClipError(f"{path.name} holds no sound")
    return sound
