"""A pause ends a whole command sooner than a fragment."""

import pytest

from attune.core.scene import load_scene
from attune.dialogue.completeness import completeness

IS_COMPLETE = completeness(load_scene())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("bring me the red cup", True),
        ("stop", True),
        ("bring me the", False),
        ("could you", False),
        ("put it on the", False),
        ("lovely weather today", None),
    ],
)
def test_a_text_is_whole_or_a_fragment_or_neither(text: str, expected: bool | None) -> None:
    assert IS_COMPLETE(text) is expected
