"""The error base class: every error says what was wrong and what to do about it."""


class AttuneError(Exception):
    """Base of all errors a person can meet.

    Subclasses take facts and write the sentence, so that every message of one kind reads the same.

    Args:
        problem: What is wrong, naming the thing that is wrong. One clause, no full stop.
        remedy: What the person can do about it. One clause, no full stop.
    """

    retryable: bool = False
    """Whether doing the same again may succeed."""

    def __init__(self, problem: str, remedy: str = "") -> None:
        self.problem = problem
        self.remedy = remedy
        super().__init__(f"{problem}. {remedy}." if remedy else f"{problem}.")


class MissingDependencyError(AttuneError):
    """A library or device that the request needs is not installed.

    Args:
        what: The missing thing.
        needed_for: What it is needed for.
        how_to_get: The command or step that provides it.
    """

    def __init__(self, what: str, needed_for: str, how_to_get: str) -> None:
        super().__init__(f"{what} is missing, which {needed_for} needs", how_to_get)
