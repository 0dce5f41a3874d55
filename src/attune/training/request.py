"""What to train, and one trained variant: values that the pipeline takes and gives."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from attune.core.messages import AgeGroup
from attune.speech.age.groups import OLDER_FROM
from attune.speech.age.hub import WHISPER_SMALL
from attune.speech.age.options import AgeModelOptions
from attune.training.common_voice import PAPER_FILES, PAPER_MINIMUM, PAPER_TRAINING_SHARE
from attune.training.metrics import Measures
from attune.training.settings import TrainingResult, TrainingSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingRequest:
    """What to train, from what, and where to.

    Attributes:
        corpus: Common Voice of one language.
        out: Gets `model`, `runs` (logs and, until training is done, the state to go on from) and `cache`.
        encoder: Folder or hub name of the pre-trained Whisper model.
        files: TSV files that are merged.
        minimum: Clips that a speaker must have.
        split_by: `speaker`, or `sample` as in the paper.
        cached: Compute encoder features once. Needs disk, see `attune.training.feature_cache`.
        compare: Train the paper's variant and each option beside it, and keep the best.
        restart: Forget a run that was interrupted.
        workers: Threads that decode sound.
    """

    corpus: Path
    out: Path
    encoder: str = WHISPER_SMALL
    files: tuple[str, ...] = PAPER_FILES
    minimum: int = PAPER_MINIMUM
    split_by: Literal["speaker", "sample"] = "speaker"
    training_share: float = PAPER_TRAINING_SHARE
    validation_share: float = 0.1
    older_from: AgeGroup = OLDER_FROM
    options: AgeModelOptions = field(default_factory=AgeModelOptions)
    settings: TrainingSettings = field(default_factory=TrainingSettings)
    cached: bool = True
    compare: bool = False
    restart: bool = False
    workers: int = 4


@dataclass(frozen=True, slots=True)
class Variant:
    """One trained variant, measured on the test clips.

    Attributes:
        before: Without temperature.
        after: With it.
        validation_loss: Log loss on the validation clips with temperature; the least is best.
    """

    name: str
    options: AgeModelOptions
    result: TrainingResult
    before: Measures
    after: Measures
    validation_loss: float
