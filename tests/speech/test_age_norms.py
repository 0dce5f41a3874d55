"""The embedded age estimate measures pitch right and claims little; the band it leads to does not flip."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from attune.core.messages import AGE_GROUPS, AgeEstimate
from attune.evaluation.speakers import noise, people
from attune.speech.age.norms import (
    HARMONICS_TO_NOISE,
    HARMONICS_TO_NOISE_SPREAD,
    JITTER,
    JITTER_SPREAD,
    PITCH,
    PITCH_SPREAD,
    RATE,
    RATE_SPREAD,
    SHIMMER,
    SHIMMER_SPREAD,
    NormsEstimator,
    age_probabilities,
)
from attune.speech.age.pitch import pitch_track
from attune.speech.age.tracker import AgeTracker
from attune.speech.age.voice_quality import VoiceQuality, voice_quality
from attune.speech.audio import Samples
from attune.speech.recogniser import RecognisedWord, Recognition

SENTENCE = "please bring me the red cup from the table"


def estimate(older: float) -> AgeEstimate:
    """Of the given probability of the older groups (sixties to nineties)."""
    return AgeEstimate(probabilities=((1 - older) / 5,) * 5 + (older / 4,) * 4)


@pytest.mark.parametrize("pitch", [80, 107, 146, 210, 300])
def test_the_pitch_of_a_buzz_is_measured_within_two_percent(pitch: int) -> None:
    time = np.arange(16000) / 16000
    buzz = sum(np.sin(2 * np.pi * pitch * k * time) / k for k in range(1, 12))
    noisy = np.asarray(buzz + noise(16000, -25, np.random.default_rng(0)), dtype=np.float32)
    assert np.median(pitch_track(noisy).frequencies) == pytest.approx(pitch, rel=0.02)


def test_noise_silence_and_scraps_have_no_pitch_and_no_age() -> None:
    for samples in (noise(16000, -20, np.random.default_rng(0), "white"), np.zeros(16000), np.zeros(10)):
        sound = samples.astype(np.float32)
        assert len(pitch_track(sound).starts) <= 3
        assert NormsEstimator().estimate(sound, Recognition()) == AgeEstimate()


def test_the_estimate_is_a_distribution_that_is_never_sure() -> None:
    for speaker in people()[:8]:
        found = NormsEstimator().estimate(speaker.say(SENTENCE), Recognition())
        assert len(found.probabilities) == len(AGE_GROUPS)
        assert sum(found.probabilities) == pytest.approx(1)
        assert found.confidence < 0.9
        assert max(found.probabilities) < 0.4


def test_slow_speech_makes_older_likelier() -> None:
    sound = people()[0].say("please bring me the red cup")
    slow, fast = (Recognition(words=(RecognisedWord("cup" * 4, 0.0, duration, 1.0),)) for duration in (1.4, 0.8))
    older = [sum(NormsEstimator().estimate(sound, heard).probabilities[5:]) for heard in (slow, fast)]
    assert older[0] > older[1] + 0.1


def test_norms_alone_name_a_band_only_after_five_utterances() -> None:
    tracker = AgeTracker()
    bands = [tracker.update(estimate(0.9)).band for _ in range(5)]
    assert bands == ["unknown"] * 4 + ["older"]
    unsure = AgeTracker()
    assert {unsure.update(estimate(0.7)).band for _ in range(10)} == {"unknown"}


def test_a_model_may_name_a_band_at_once() -> None:
    assert AgeTracker().update(replace(estimate(0.9), source="model")).band == "older"


def test_no_synthetic_person_is_put_in_a_band_by_one_utterance() -> None:
    for speaker in people()[:8]:
        found = NormsEstimator().estimate(speaker.say(SENTENCE), Recognition())
        assert AgeTracker().update(found).band == "unknown", speaker.name


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


def vowel(pitch: float, *, jitter: float = 0.0, shimmer: float = 0.0, noise_level: float = -60.0) -> Samples:
    """Two seconds of glottal pulses through three formants, between two half seconds of silence.

    The irregularities are standard deviations as shares of the period and the amplitude; the noise is in dB relative
    to the voice.
    """
    rng = np.random.default_rng(0)
    pulses = np.zeros(36_000)
    at = 20.0
    while at < 32_000:
        near = np.arange(int(at) - 16, int(at) + 17)
        pulses[near] += (1 + shimmer * rng.standard_normal()) * np.sinc(0.6 * (near - at)) * np.hanning(33)
        at += 16_000 / pitch * (1 + jitter * rng.standard_normal())
    voice = pulses[:32_000]
    for formant, width in ((600, 80), (1200, 100), (2500, 150)):
        decay = np.exp(-np.pi * width / 16_000)
        voice = lfilter([1], [1, -2 * decay * np.cos(2 * np.pi * formant / 16_000), decay**2], voice)
    voice *= 0.1 / np.sqrt(np.mean(voice**2))
    voice = voice + 0.1 * 10 ** (noise_level / 20) * rng.standard_normal(len(voice))
    silence = np.zeros(8000)
    return np.asarray(np.concatenate([silence, voice, silence]) + 1e-5 * rng.standard_normal(48_000), np.float32)


def quality_of(sound: Samples) -> VoiceQuality:
    found = voice_quality(sound, pitch_track(sound))
    assert found is not None
    return found


@pytest.mark.parametrize("pitch", [110, 210])
def test_each_irregularity_of_a_voice_raises_its_own_measure(pitch: float) -> None:
    plain = quality_of(vowel(pitch))
    jitters = [quality_of(vowel(pitch, jitter=share)).jitter for share in (0.005, 0.01, 0.02)]
    shimmers = [quality_of(vowel(pitch, shimmer=share)).shimmer for share in (0.03, 0.06, 0.12)]
    assert plain.jitter < 0.001 < jitters[0] < jitters[1] < jitters[2] < 0.02
    assert plain.shimmer < shimmers[0] < shimmers[1] < shimmers[2]


@pytest.mark.parametrize("pitch", [110, 210])
@pytest.mark.parametrize("ratio", [10, 20])
def test_the_harmonics_to_noise_ratio_is_measured_within_a_decibel(pitch: float, ratio: float) -> None:
    assert quality_of(vowel(pitch, noise_level=-ratio)).harmonics_to_noise == pytest.approx(ratio, abs=1)


def test_a_rising_melody_does_not_count_as_jitter() -> None:
    time = np.arange(24_000) / 16_000
    phase = 2 * np.pi * (120 * time + 30 * time**2)
    sound = np.concatenate([np.zeros(8000), sum(np.sin(phase * k) / k for k in range(1, 12)), np.zeros(8000)]) * 0.1
    found = quality_of(np.asarray(sound + 1e-5 * np.random.default_rng(0).standard_normal(40_000), np.float32))
    assert found.jitter < 0.002


def test_in_a_noisy_room_the_noise_is_not_taken_for_the_voice() -> None:
    sound = vowel(120)
    noisy = np.asarray(sound + 0.03 * np.random.default_rng(0).standard_normal(len(sound)), np.float32)
    assert voice_quality(noisy, pitch_track(noisy)) is None


def test_voice_quality_moves_the_odds_by_no_more_than_a_factor_of_two() -> None:
    worst, best = VoiceQuality(0.2, 0.9, -10.0), VoiceQuality(1e-5, 1e-4, 40.0)
    for pitch in (90, 120, 150, 180, 210, 250):
        odds = [
            share / (1 - share)
            for share in (float(age_probabilities(pitch, each, None)[5:].sum()) for each in (None, worst, best))
        ]
        assert odds[2] < odds[0] < odds[1]
        assert max(odds[1] / odds[0], odds[0] / odds[2]) < 2


def test_it_is_calibrated_for_people_as_the_norms_describe_them() -> None:
    """Says nothing of real people; says that wide norms make wide answers, and that a named band is mostly right."""
    rng = np.random.default_rng(0)
    said, older = [], []
    for _ in range(4000):
        group, sex = int(rng.integers(9)), int(rng.integers(2))
        pitch = PITCH[sex, group] * (1 + PITCH_SPREAD * rng.standard_normal())
        quality = VoiceQuality(
            float(np.exp(rng.normal(JITTER[sex, group], JITTER_SPREAD))),
            float(np.exp(rng.normal(SHIMMER[sex, group], SHIMMER_SPREAD))),
            float(rng.normal(HARMONICS_TO_NOISE[sex, group], HARMONICS_TO_NOISE_SPREAD)),
        )
        probabilities = age_probabilities(pitch, quality, float(rng.normal(RATE[group], RATE_SPREAD)))
        said.append(float(probabilities[5:].sum()))
        older.append(group >= 5)
    shares, truth = np.array(said), np.array(older)
    for low in (0.1, 0.3, 0.5, 0.7):
        within = (shares >= low) & (shares < low + 0.2)
        assert truth[within].mean() == pytest.approx(shares[within].mean(), abs=0.05)
    named = np.maximum(shares, 1 - shares) >= 0.75
    assert 0.1 < named.mean() < 0.25
    assert ((shares >= 0.5) == truth)[named].mean() > 0.75
