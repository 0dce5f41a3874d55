"""How to train, and what training came to."""

from dataclasses import dataclass
from typing import Literal

from attune.core.errors import AttuneError


class TrainingError(AttuneError):
    """Training cannot begin or go on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingSettings:
    """How to train. The defaults are the paper's where it says (10 epochs, 1e-3, linear warm-up).

    Attributes:
        batch_size: Clips per step and process.
        learning_rate: Of the classifier, at the end of the warm-up; it falls linearly to 0 from there.
        encoder_learning_rate: Of the encoder, once it is unfrozen.
        warmup: Share of all steps over which the rate rises from 0.
        unfreeze_after: Epochs after which the encoder learns too; None keeps it frozen.
        class_weights: Count every group alike, or every clip.
        precision: Mixed precision: `no`, `fp16` or `bf16`.
        patience: Epochs without a lower validation loss after which training stops, also before the encoder learns.
        save_every: Steps between two saved states.
        seed: Of order, dropout and first weights.
    """

    epochs: int = 10
    batch_size: int = 32
    learning_rate: float = 1e-3
    encoder_learning_rate: float = 1e-5
    warmup: float = 0.1
    weight_decay: float = 0.01
    unfreeze_after: int | None = None
    class_weights: Literal["balanced", "none"] = "balanced"
    precision: Literal["no", "fp16", "bf16"] = "no"
    patience: int = 3
    save_every: int = 500
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("epochs", "batch_size", "patience", "save_every"):
            if getattr(self, name) < 1:
                raise TrainingError(f"{name} = {getattr(self, name)} is not allowed", "Take a number from 1 on")
        if not 0 <= self.warmup < 1:
            raise TrainingError(f"warmup = {self.warmup} is not allowed", "Take a share from 0 to under 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class Epoch:
    """What one epoch came to; losses as trained, per clip."""

    number: int
    training_loss: float
    validation_loss: float
    validation_accuracy: float
    learning_rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingResult:
    """What training came to. The model holds the weights of the best epoch.

    Attributes:
        temperature: By which the logits should be divided, found on the validation clips.
        resumed_at: Step from which a former run was taken up, 0 when it began anew.
    """

    history: tuple[Epoch, ...]
    best_epoch: int
    temperature: float
    steps: int
    resumed_at: int
    stopped_early: bool
