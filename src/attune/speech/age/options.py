"""What can be chosen about the classifier. Free of torch, so that the command line and onnxruntime can use it."""

from dataclasses import asdict, dataclass, fields
from typing import Any, Literal

from attune.core.errors import AttuneError


class OptionError(AttuneError):
    """An option of the age model has a value that is not allowed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AgeModelOptions:
    """The classifier on top of the Whisper encoder. The defaults are the paper's.

    Attributes:
        pooling: How the frames become one vector: their `mean`, or a learnt weighted mean (`attention`).
        layers: Which encoder layers are heard: the `last`, or a learnt weighted sum of all (`weighted`).
        targets: What is trained: the nine `groups` as unrelated classes, or their order too (`ordinal`).
        length: Whether the encoder hears only the `true` length of an utterance, or the 30 s that Whisper was made
            for (`padded`). The mean of a model trained on padded sound runs over the silence too, so it must go on
            hearing padded sound.
        frame_stride: Encoder frames (20 ms each) that are averaged into one before the classifier. More is smaller in
            the cache and faster.
        heads: Attention heads of the classifier.
        projection: Width of the classifier's projection.
        dropout: Share of values dropped in training.
        temperature: Divides the logits; over 1 makes the model less sure. Found on held-out speakers.
    """

    pooling: Literal["mean", "attention"] = "mean"
    layers: Literal["last", "weighted"] = "last"
    targets: Literal["groups", "ordinal"] = "groups"
    length: Literal["true", "padded"] = "true"
    frame_stride: int = 1
    heads: int = 4
    projection: int = 256
    dropout: float = 0.0
    temperature: float = 1.0

    def __post_init__(self) -> None:
        for name, allowed in _ALLOWED.items():
            if getattr(self, name) not in allowed:
                raise OptionError(f"{name} = {getattr(self, name)!r} is not allowed", f"Take one of {allowed}")
        for name in ("frame_stride", "heads", "projection"):
            if getattr(self, name) < 1:
                raise OptionError(f"{name} = {getattr(self, name)!r} is not allowed", "Take a number from 1 on")
        if not self.temperature > 0:
            raise OptionError(f"temperature = {self.temperature!r} is not allowed", "Take a number over 0")
        if not 0 <= self.dropout < 1:
            raise OptionError(f"dropout = {self.dropout!r} is not allowed", "Take a number from 0 to under 1")

    def to_data(self) -> dict[str, Any]:
        """As plain data, for JSON."""
        return asdict(self)

    @classmethod
    def from_data(cls, data: dict[str, Any]) -> "AgeModelOptions":
        """From plain data.

        Raises:
            OptionError: An option is unknown or has a value that is not allowed.
        """
        known = [field.name for field in fields(cls)]
        unknown = sorted(set(data) - set(known))
        if unknown:
            raise OptionError(f"unknown option {unknown[0]!r} of an age model", f"Known: {', '.join(known)}")
        return cls(**data)


_ALLOWED = {
    "pooling": ("mean", "attention"),
    "layers": ("last", "weighted"),
    "targets": ("groups", "ordinal"),
    "length": ("true", "padded"),
}
