"""The age band that the voice tells: it does not flip with every utterance. What a person states is the dialogue's."""

from collections import deque

import numpy as np

from attune.core.messages import AgeEstimate, AgeGroup, Band
from attune.speech.age.groups import OLDER_FROM, probability_older

_INTERACTIONS = 5
_BECOMES, _STAYS = 0.65, 0.5
"""Probability at which a band is taken, and down to which it is kept."""
_BECOMES_BY_NORMS = 0.75
"""The embedded norms know so little that they must be surer, and have heard all of the last five."""


class AgeTracker:
    """The mean of the last five estimates, with hysteresis.

    Args:
        older_from: The first group that counts as older.
    """

    def __init__(self, older_from: AgeGroup = OLDER_FROM) -> None:
        self._older_from = older_from
        self._estimates: deque[AgeEstimate] = deque(maxlen=_INTERACTIONS)
        self._band: Band = "unknown"

    def update(self, estimate: AgeEstimate) -> AgeEstimate:
        """Take the estimate of one utterance and give the one to act on. An empty estimate changes nothing."""
        if estimate.probabilities:
            self._estimates.append(estimate)
        return self.current

    @property
    def current(self) -> AgeEstimate:
        """The estimate to act on."""
        mean = self._mean()
        if not mean:
            return AgeEstimate()
        older = probability_older(mean, self._older_from)
        shares: dict[Band, float] = {"older": older, "younger": 1 - older}
        if shares.get(self._band, 0.0) < _STAYS:
            needed = self._needed()
            self._band = next((band for band, share in shares.items() if share >= needed), "unknown")
        confidence = shares.get(self._band, max(shares.values()))
        return AgeEstimate(
            probabilities=mean, band=self._band, confidence=confidence, source=self._estimates[-1].source
        )

    def _needed(self) -> float:
        if any(estimate.source != "norms" for estimate in self._estimates):
            return _BECOMES
        return _BECOMES_BY_NORMS if len(self._estimates) == _INTERACTIONS else np.inf

    def _mean(self) -> tuple[float, ...]:
        if not self._estimates:
            return ()
        return tuple(np.mean([estimate.probabilities for estimate in self._estimates], axis=0).tolist())
