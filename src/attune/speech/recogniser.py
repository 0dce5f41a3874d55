"""What every speech recogniser offers: sound in, partial and final text out."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from attune.speech.audio import Samples


@dataclass(frozen=True, slots=True)
class RecognisedWord:
    """A word and when it was said.

    Attributes:
        start: From the first sample that the recogniser got [s].
        end: Likewise [s].
        confidence: 0 to 1.
    """

    text: str
    start: float
    end: float
    confidence: float


@dataclass(frozen=True, slots=True)
class Recognition:
    """What was said.

    Attributes:
        text: Lower case, no punctuation; "" when nothing was recognised.
        alternatives: Other readings, best first, without `text`.
        confidence: 0 to 1 that this is what was said.
        in_domain: False when the sound fits the domain badly: noise, talk about something else.
        words: In order.
        log_mel: Of the whole utterance, shape (bands, frames of 10 ms), from recognisers that compute it as
            `attune.speech.age.features.log_mel` does; None from others, and for more than 30 s.
    """

    text: str = ""
    alternatives: tuple[str, ...] = ()
    confidence: float = 0.0
    in_domain: bool = False
    words: tuple[RecognisedWord, ...] = ()
    log_mel: NDArray[np.float32] | None = field(default=None, compare=False, repr=False)


class Recogniser(Protocol):
    """Recognises one utterance at a time: start, accept (many times), finish; after more sound, finish again.

    An utterance that is not finished is dropped by the next start. The calls may block (some milliseconds for each
    frame, more for `finish`), so they are made in worker threads; one thread at a time.
    """

    @property
    def name(self) -> str:
        """What it is and what it knows, for people."""
        ...

    def start(self) -> None:
        """Begin an utterance."""
        ...

    def accept(self, samples: Samples) -> None:
        """Take the next samples, 16 kHz mono."""
        ...

    def partial(self) -> str:
        """What has been understood so far; may change with the next samples."""
        ...

    def at_pause(self) -> str:
        """The same, now that the person pauses and may have ended: worth more time than `partial`."""
        ...

    def finish(self) -> Recognition:
        """End the utterance."""
        ...
