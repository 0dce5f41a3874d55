"""What an interrupted training leaves behind, to be taken up where it was."""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch

from attune.training.settings import TrainingError

STATE_FILE = "state.pt"


@dataclass(slots=True)
class TrainingProgress:
    """How far a training is; it changes in place."""

    epoch: int = 0
    step_in_epoch: int = 0
    step: int = 0
    loss_sum: float = 0.0
    best_loss: float = math.inf
    best_epoch: int = 0
    history: list[dict[str, Any]] = field(default_factory=list)


def write_state(folder: Path, data: dict[str, Any]) -> None:
    """Save a state; a crash while it is written leaves the one before.

    Args:
        folder: Of the run.
        data: Tensors and plain values, with the hash of the run's plan under `plan`.
    """
    unfinished = folder / f"{STATE_FILE}.part"
    torch.save(data, unfinished)
    unfinished.replace(folder / STATE_FILE)


def read_state(folder: Path, plan: str) -> dict[str, Any] | None:
    """The saved state of a run, or None if there is none.

    Raises:
        TrainingError: It is of another plan.
    """
    path = folder / STATE_FILE
    if not path.exists():
        return None
    data: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
    if data["plan"] != plan:
        raise TrainingError(
            f"{path} is of a run with other clips, options or settings", "Give them as before, or use --restart"
        )
    return data
