"""The embedded age estimate measures pitch right and claims little; the band it leads to does not flip."""

import numpy as np
import pytest

from attune.core.messages import AGE_GROUPS, AgeEstimate
from attune.evaluation.speakers import noise, people
from attune.speech.age.norms import NormsEstimator
from attune.speech.age.pitch import fundamental_frequencies
from attune.speech.age.tracker import AgeTracker
from attune.speech.recogniser import RecognisedWord


def estimate(older: float) -> AgeEstimate:
    """Of the given probability of the older groups (sixties to nineties)."""
    return AgeEstimate(probabilities=((1 - older) / 5,) * 5 + (older / 4,) * 4)


@pytest.mark.parametrize("pitch", [80, 107, 146, 210, 300])
def test_the_pitch_of_a_buzz_is_measured_within_two_percent(pitch: int) -> None:
    time = np.arange(16000) / 16000
    buzz = sum(np.sin(2 * np.pi * pitch * k * time) / k for k in range(1, 12))
    noisy = np.asarray(buzz + noise(16000, -25, np.random.default_rng(0)), dtype=np.float32)
    assert np.median(fundamental_frequencies(noisy)) == pytest.approx(pitch, rel=0.02)


def test_noise_silence_and_scraps_have_no_pitch_and_no_age() -> None:
    for samples in (noise(16000, -20, np.random.default_rng(0), "white"), np.zeros(16000), np.zeros(10)):
        sound = samples.astype(np.float32)
        assert len(fundamental_frequencies(sound)) <= 3
        assert NormsEstimator().estimate(sound, ()) == AgeEstimate()


def test_the_estimate_is_a_distribution_that_is_never_sure() -> None:
    for speaker in people()[:8]:
        found = NormsEstimator().estimate(speaker.say("please bring me the red cup from the table"), ())
        assert len(found.probabilities) == len(AGE_GROUPS)
        assert sum(found.probabilities) == pytest.approx(1)
        assert found.confidence < 0.9
        assert max(found.probabilities) < 0.4


def test_slow_speech_makes_older_likelier() -> None:
    sound = people()[0].say("please bring me the red cup")
    slow, fast = ((RecognisedWord("cup" * 4, 0.0, duration, 1.0),) for duration in (1.4, 0.8))
    older = [sum(NormsEstimator().estimate(sound, words).probabilities[5:]) for words in (slow, fast)]
    assert older[0] > older[1] + 0.1


def test_the_band_needs_evidence_and_then_withstands_single_estimates() -> None:
    tracker = AgeTracker()
    assert tracker.current.band == "unknown"
    assert tracker.update(estimate(0.55)).band == "unknown"
    assert [tracker.update(estimate(0.9)).band for _ in range(4)][-1] == "older"
    assert tracker.update(estimate(0.1)).band == "older"
    assert [tracker.update(estimate(0.1)).band for _ in range(4)][-1] == "younger"


def test_only_the_last_five_interactions_count() -> None:
    tracker = AgeTracker()
    for share in (0.9,) * 10 + (0.2, 0.2, 0.2, 0.2, 0.2):
        tracker.update(estimate(share))
    assert sum(tracker.current.probabilities[5:]) == pytest.approx(0.2)


def test_an_empty_estimate_changes_nothing() -> None:
    tracker = AgeTracker()
    before = tracker.update(estimate(0.9))
    assert tracker.update(AgeEstimate()) == before


def test_what_the_person_states_wins_until_it_is_taken_back() -> None:
    tracker = AgeTracker()
    tracker.update(estimate(0.9))
    tracker.state("younger")
    for _ in range(6):
        stated = tracker.update(estimate(0.9))
    assert (stated.band, stated.source, stated.confidence) == ("younger", "stated", 1.0)
    tracker.state("unknown")
    assert tracker.current.band == "older"
