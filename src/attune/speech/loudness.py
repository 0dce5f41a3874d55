"""How loud it is around the microphone: the level of a sound, and that of the background."""

from collections import deque

import numpy as np

from attune.speech.audio import Samples

SILENCE = -90.0
"""Level of digital silence [dB full scale]."""
_MEMORY = 8.0
_SHARE = 0.15
"""The background is as loud as the quietest 15 % of the last 8 s: even somebody who talks on leaves that to it."""
_KNOWN_AFTER = 1.0
"""Before so much was heard [s], the background is taken for silent: somebody may speak from the first moment on."""


def level(samples: Samples) -> float:
    """Root mean square [dB full scale]."""
    return 10 * float(np.log10(max(float(np.mean(np.square(samples))), 1e-9)))


class Background:
    """Follows the level of what sounds between and behind speech.

    Args:
        step: Length of a piece of sound [s].
    """

    def __init__(self, step: float) -> None:
        self._levels: deque[float] = deque(maxlen=round(_MEMORY / step))
        self._needed = round(_KNOWN_AFTER / step)
        self._step = step

    def accept(self, loudness: float) -> None:
        """Take the level of the next piece of sound."""
        self._levels.append(loudness)

    @property
    def level(self) -> float:
        """Of the background [dB full scale]; takes some 30 µs."""
        return SILENCE if len(self._levels) < self._needed else float(np.quantile(self._levels, _SHARE))

    def loudest(self, seconds: float) -> float:
        """Level of the loudest piece of the last seconds [dB full scale]."""
        return max(list(self._levels)[-round(seconds / self._step) :], default=SILENCE)
