"""Training from end to end on synthetic voices: it learns what can be heard, and survives interruption."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from attune.core.errors import AttuneError
from attune.core.messages import AGE_GROUPS
from attune.evaluation.age import choose_clips, evaluate_age
from attune.speech.age.checkpoints import load_classifier
from attune.speech.age.models import load_age_model
from attune.speech.age.options import AgeModelOptions
from attune.training.common_voice import read_common_voice
from attune.training.losses import age_loss, class_weights
from attune.training.pipeline import train_age_model
from attune.training.settings import TrainingError

from .conftest import SETTINGS, Trained


class Interrupted(BaseException):
    """What Ctrl-C or a crash is to the training."""


def weights(folder: Path) -> dict[str, torch.Tensor]:
    return dict(load_classifier(str(folder)).state_dict())


def same(first: Path, second: Path) -> bool:
    other = weights(second)
    return all(torch.equal(value, other[key]) for key, value in weights(first).items())


def test_it_hears_the_difference_in_voices_it_never_heard(trained: Trained, corpus: Path) -> None:
    """High and fast against low and slow, in held-out synthetic speakers: nothing about human ages."""
    test = choose_clips(corpus, "held-out", trained.model)
    learnt = read_common_voice(corpus).clips
    assert {clip.speaker for clip in test}.isdisjoint({clip.speaker for clip in set(learnt) - set(test)})
    found = evaluate_age(load_age_model(str(trained.model)), test, name="trained", part="held-out").measures
    assert len({clip.speaker for clip in test}) == 12
    assert found.binary_accuracy > 0.85
    assert found.binary_baseline < 0.55
    report = json.loads((trained.model / "training_report.json").read_text())
    assert found.binary_accuracy == pytest.approx(report["test"]["binary_accuracy"], abs=0.02)


def test_without_training_it_hears_nothing(request_for) -> None:  # type: ignore[no-untyped-def]
    settings = replace(SETTINGS, epochs=1, learning_rate=1e-9)
    outcome = train_age_model(request_for(settings=settings))
    assert outcome.kept.after.binary_balanced < 0.65


def test_the_folder_has_weights_labels_report_and_card(trained: Trained) -> None:
    assert json.loads((trained.model / "labels.json").read_text()) == list(AGE_GROUPS)
    assert json.loads((trained.model / "config.json").read_text())["id2label"]["3"] == "fourties"
    report = json.loads((trained.model / "training_report.json").read_text())
    assert report["corpus"]["damaged"]["count"] == 2
    assert report["corpus"]["dropped"] == {"without age": 6, "of speakers with too few clips": 3}
    assert report["corpus"]["training"]["speakers"] + report["corpus"]["validation"]["speakers"] == 28
    assert len(report["history"]) == 12
    card = (trained.model / "README.md").read_text()
    assert "| fourties | 33 | 5 | 17 |" in card
    assert "97.8%" in card
    assert "twenties-0" not in card + json.dumps(report), "speakers must not be named"
    assert list((trained.model.parent / "runs" / "model" / "logs").glob("events*"))


def test_an_interrupted_run_ends_as_if_it_had_not_been(trained: Trained, request_for) -> None:  # type: ignore[no-untyped-def]
    request = request_for(settings=replace(SETTINGS, save_every=10), with_features=False)

    def stop_at(step: int, what: str):  # type: ignore[no-untyped-def]
        def watch(name: str, done: int, total: int) -> None:
            if name == what and done >= step:
                raise Interrupted

        return watch

    for step, what in ((1, "encoding"), (25, "training model"), (47, "training model")):
        with pytest.raises(Interrupted):
            train_age_model(request, stop_at(step, what))
        assert not (request.out / "model").exists()
    steps: list[int] = []
    outcome = train_age_model(request, lambda what, done, total: steps.append(done) if "training" in what else None)
    assert outcome.kept.result.resumed_at == 40
    assert steps[0] == 41
    assert same(outcome.model, trained.model)


def test_a_run_of_another_plan_is_not_taken_up(request_for) -> None:  # type: ignore[no-untyped-def]
    request = request_for(settings=replace(SETTINGS, epochs=2))

    def stop(what: str, done: int, total: int) -> None:
        if what == "training model" and done > 20:
            raise Interrupted

    with pytest.raises(Interrupted):
        train_age_model(request, stop)
    other = replace(request, settings=replace(SETTINGS, epochs=2, learning_rate=1e-4))
    with pytest.raises(TrainingError, match="--restart"):
        train_age_model(other)
    assert train_age_model(replace(other, restart=True)).kept.result.resumed_at == 0


def test_a_finished_model_is_not_overwritten(trained: Trained, request_for) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(AttuneError, match="already holds"):
        train_age_model(request_for(out=trained.model.parent))


def test_it_stops_when_the_held_out_loss_no_longer_falls(request_for) -> None:  # type: ignore[no-untyped-def]
    settings = replace(SETTINGS, epochs=40, learning_rate=0.5, patience=2)
    result = train_age_model(request_for(settings=settings)).kept.result
    assert result.stopped_early
    assert len(result.history) == result.best_epoch + 2
    best = min(result.history, key=lambda epoch: epoch.validation_loss)
    assert best.number == result.best_epoch


def test_cached_features_and_sound_train_alike(request_for) -> None:  # type: ignore[no-untyped-def]
    settings = replace(SETTINGS, epochs=2, batch_size=32)
    cached, sound = (
        train_age_model(request_for(settings=settings, cached=cached, minimum=6)) for cached in (True, False)
    )
    assert len(sound.damaged) == len(cached.damaged) == 1
    assert sound.kept.after.count == cached.kept.after.count
    # The order of the clips differs, and the cache rounds to 16 bits.
    assert sound.kept.after.log_loss == pytest.approx(cached.kept.after.log_loss, abs=0.2)


def test_unfreezing_changes_the_encoder_and_resumes_too(request_for, whisper_folder: Path) -> None:  # type: ignore[no-untyped-def]
    settings = replace(SETTINGS, epochs=3, batch_size=16, unfreeze_after=2, encoder_learning_rate=1e-3, save_every=1)
    whole = train_age_model(request_for(settings=settings, minimum=6))
    from transformers import WhisperModel

    before = WhisperModel.from_pretrained(whisper_folder).encoder.state_dict()
    learnt = whole.kept.result.best_epoch == 3
    after = load_classifier(str(whole.model)).encoder.state_dict()
    assert torch.equal(before["layers.0.fc1.weight"], after["layers.0.fc1.weight"]) is not learnt
    assert learnt

    interrupted = request_for(settings=settings, minimum=6)

    def stop(what: str, done: int, total: int) -> None:
        # Two epochs of 5 steps are with the encoder frozen.
        if what == "training model" and done == 12:
            raise Interrupted

    with pytest.raises(Interrupted):
        train_age_model(interrupted, stop)
    outcome = train_age_model(interrupted)
    assert outcome.kept.result.resumed_at == 12
    assert same(outcome.model, whole.model)


def test_comparing_measures_the_paper_and_each_option_in_one_report(request_for) -> None:  # type: ignore[no-untyped-def]
    outcome = train_age_model(request_for(compare=True, settings=replace(SETTINGS, epochs=2, batch_size=16)))
    names = ["paper", "ordinal targets", "attention pooling", "layer sum", "all options"]
    assert [variant.name for variant in outcome.variants] == names
    assert outcome.kept.validation_loss == min(variant.validation_loss for variant in outcome.variants)
    report = json.loads((outcome.model / "training_report.json").read_text())
    assert list(report["variants"]) == names
    card = (outcome.model / "README.md").read_text()
    assert all(f"\n| {name}" in card for name in names)
    assert card.count("(this model)") == 1
    assert load_classifier(str(outcome.model)).options == outcome.kept.options
    assert outcome.kept.options.temperature == pytest.approx(outcome.kept.result.temperature)


def test_mixed_precision_trains_too(request_for) -> None:  # type: ignore[no-untyped-def]
    from accelerate.state import AcceleratorState, GradientState, PartialState

    for state in (AcceleratorState, GradientState, PartialState):
        state._reset_state()
    settings = replace(SETTINGS, epochs=2, precision="bf16")
    history = train_age_model(request_for(settings=settings, cached=False, minimum=6)).kept.result.history
    for state in (AcceleratorState, GradientState, PartialState):
        state._reset_state()
    assert history[1].training_loss < history[0].training_loss


def test_the_ordinal_loss_forgives_neighbours_more_than_strangers() -> None:
    ones = torch.ones(9)
    sure = 8 * torch.eye(9)[torch.tensor([3, 4, 8])]
    losses = [float(age_loss(row[None], torch.tensor([3]), ones, ordinal=True)) for row in sure]
    assert losses[0] < losses[1] < losses[2]
    plain = [float(age_loss(row[None], torch.tensor([3]), ones, ordinal=False)) for row in sure]
    assert plain[1] == pytest.approx(plain[2])


def test_the_ordinal_loss_is_least_for_the_true_probabilities() -> None:
    truth = torch.tensor([0.05, 0.1, 0.3, 0.2, 0.1, 0.1, 0.05, 0.05, 0.05])
    logits = truth.log().clone().requires_grad_()
    groups = torch.arange(9)
    loss = sum(
        share * age_loss(logits[None], group[None], torch.ones(9), ordinal=True)
        for share, group in zip(truth, groups, strict=True)
    )
    loss.backward()
    assert logits.grad is not None
    assert logits.grad.abs().max() < 1e-6


def test_class_weights_make_groups_count_alike_up_to_a_limit() -> None:
    groups = np.array([0] * 90 + [1] * 9 + [8])
    found = class_weights(groups)
    assert found[groups].mean() == pytest.approx(1)
    assert found[1] / found[0] == pytest.approx(10, rel=0.01)
    assert found[8] / found[0] == pytest.approx(27, rel=0.01), "limited to ten times the mean"


@pytest.mark.parametrize("options", [{"pooling": "max"}, {"frame_stride": 0}, {"temperature": 0.0}, {"dropout": 1.0}])
def test_options_that_make_no_sense_are_refused(options: dict[str, object]) -> None:
    with pytest.raises(AttuneError, match="not allowed"):
        AgeModelOptions(**options)  # type: ignore[arg-type]
