"""Options that the two commands on age recognition share."""

from attune.core.errors import AttuneError
from attune.core.messages import AGE_GROUPS, AgeGroup


def age_group(text: str) -> AgeGroup:
    """The group that a person typed.

    Raises:
        AttuneError: There is no such group; the message lists all.
    """
    spelling = {"forties": "fourties"}.get(text.lower(), text.lower())
    for group in AGE_GROUPS:
        if group == spelling:
            return group
    raise AttuneError(f"there is no age group {text!r}", f"Take one of {', '.join(AGE_GROUPS)}")
