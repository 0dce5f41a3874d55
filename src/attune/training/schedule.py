"""How the learning rate goes over a run."""


def linear_rate(steps: int, warmup: float, step: int) -> float:
    """Share of the full rate at a step: linear up for the share `warmup` of all steps, then linear down to 0."""
    rising = max(1, round(steps * warmup))
    if step < rising:
        return (step + 1) / rising
    return max(0.0, (steps - step) / max(1, steps - rising))
