"""How well and how fast the simulated robot fetches: random tasks of `attune eval robot`, a few of them.

`attune eval robot --trials 300` is the whole evaluation.
"""

import json
from typing import Any

from attune.evaluation.robot import evaluate_robot
from attune.evaluation.robot_report import to_data

TRIALS = 20


def main() -> dict[str, Any]:
    """The figures, without the lists of single trials."""
    data = to_data(evaluate_robot(TRIALS, seed=1))
    return {name: value for name, value in data.items() if name not in {"failures", "setbacks", "not_possible"}}


if __name__ == "__main__":
    print(json.dumps(main(), indent=2))
