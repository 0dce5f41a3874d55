"""How well a network does on streams, word by word."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np
from streams import ORDER, ORDERS, RELATIVE, SECONDS_PER_STEP, STOP

Judged = tuple[Sequence[tuple[str, str, str, float, float, float, float]], Any]
"""What was said (voice, kind, text, start, end, pauses before and after [s]), and outputs of shape (steps, 3)."""


def report(streams: Sequence[Judged]) -> str:
    """Shares of the phrases of each kind in which each output reaches a threshold."""
    highest: dict[str, list[Any]] = defaultdict(list)
    orders: dict[str, list[float]] = defaultdict(list)
    delays = []
    for said, output in streams:
        for _, kind, _, start, end, before, after in said:
            first = int(start / SECONDS_PER_STEP)
            heard = output[first : int((end + 0.3) / SECONDS_PER_STEP)]
            highest[kind].append(heard.max(axis=0))
            fired = np.flatnonzero(heard[:, STOP] >= 0.5)
            if kind == "stop" and len(fired):
                delays.append((first + fired[0] + 1) * SECONDS_PER_STEP - end)
            if before >= 0.7 and after >= 0.85:
                after_it = output[int((end + 0.2) / SECONDS_PER_STEP) : int((end + 0.7) / SECONDS_PER_STEP), ORDER]
                orders[kind].append(float(after_it.max()))
    lines = [f"delay of stop {1000 * np.median(delays):.0f} ms, 95 % {1000 * np.quantile(delays, 0.95):.0f} ms"]
    for kind in sorted(highest, key=lambda kind: (kind not in ORDERS, kind)):
        each = np.array(highest[kind])
        parts = [f"{kind:12}{len(each):5}"]
        for name, values in (
            ("stop", each[:, STOP]),
            ("relative", each[:, RELATIVE]),
            ("order", np.array(orders[kind])),
        ):
            shares = " ".join(f"{100 * np.mean(values >= threshold):5.1f}" for threshold in (0.1, 0.3, 0.5, 0.7, 0.9))
            parts.append(f"{name} {shares}")
        lines.append("  ".join(parts))
    return "\n".join(lines)
