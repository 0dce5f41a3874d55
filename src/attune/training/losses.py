"""What training minimises, and how groups with few clips are weighted."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from attune.core.messages import AGE_GROUPS

HEAVIEST = 10.0
"""A rare group counts at most so much more than the mean."""


def class_weights(groups: NDArray[np.int64]) -> NDArray[np.float32]:
    """Weights by which every group counts alike, shape (9,), mean 1 over the clips, at most `HEAVIEST`.

    Groups that do not occur weigh 1.
    """
    counts = np.bincount(groups, minlength=len(AGE_GROUPS))
    present = counts > 0
    weights = np.ones(len(AGE_GROUPS))
    weights[present] = np.minimum(len(groups) / (present.sum() * counts[present]), HEAVIEST)
    return np.asarray(weights / weights[groups].mean(), np.float32)


def age_loss(logits: Tensor, groups: Tensor, weights: Tensor, *, ordinal: bool) -> Tensor:
    """Mean loss of a batch.

    With `ordinal`, it is the log loss of all eight questions "at least this group?", answered by the sums of the
    nine probabilities: being wrong by a decade costs less than by five, the threshold between younger and older is
    trained itself, and, like the plain log loss, it is least for the true probabilities.

    Args:
        logits: Shape (batch, 9).
        groups: Shape (batch,).
        weights: By group, shape (9,).
        ordinal: Use the order of the groups.
    """
    logits = logits.float()
    if not ordinal:
        each = functional.cross_entropy(logits, groups, reduction="none")
    else:
        shares = functional.log_softmax(logits, dim=-1)
        # log P(at least k) and log P(less than k), for k from 1 on.
        at_least = torch.logcumsumexp(shares.flip(-1), dim=-1).flip(-1)[:, 1:]
        less = torch.logcumsumexp(shares, dim=-1)[:, :-1]
        is_at_least = groups[:, None] >= torch.arange(1, shares.shape[-1], device=groups.device)
        each = -torch.where(is_at_least, at_least, less).sum(dim=-1)
    weight = weights[groups]
    return (each * weight).sum() / weight.sum()
