"""Which age estimator the configuration asks for."""

from attune.core.messages import AgeGroup
from attune.speech.age.estimator import AgeEstimator
from attune.speech.age.groups import OLDER_FROM

NORMS, OFF = "norms", "off"


def make_age_estimator(age: str, older_from: AgeGroup = OLDER_FROM) -> AgeEstimator | None:
    """The estimator.

    Args:
        age: `norms`: the embedded one. `off`: none. Anything else: folder or hub name of a model; loading one takes
            a second with onnxruntime and some ten with torch.
        older_from: The first group that counts as older.

    Raises:
        AttuneError: The model cannot be had or used; see `attune.speech.age.models.load_age_model`.
    """
    if age == OFF:
        return None
    if age == NORMS:
        from attune.speech.age.norms import NormsEstimator

        return NormsEstimator(older_from)
    from attune.speech.age.model_estimator import load_estimator

    return load_estimator(age, older_from)
