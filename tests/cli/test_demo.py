"""The main job on real input: spoken audio in, physics, an interruption by speech, the right thing done."""

import json
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.parametrize("scenario", ["bring_me", "breakfast"])
def test_the_spoken_demo_passes_in_the_physics_simulation(scenario: str, tmp_path: Path) -> None:
    result = subprocess.run(
        [sys.executable, "-m", "attune", "demo", scenario, "--fast", "--json"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        timeout=300,
        check=False,
    )
    assert result.stdout, result.stderr
    verdict = json.loads(result.stdout)[scenario]
    assert verdict["passed"], verdict["checks"]
    assert result.returncode == 0
    assert verdict["repetitions"] == 0
