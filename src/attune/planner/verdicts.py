"""What is decided about a command, and what is told about it."""

from dataclasses import dataclass

from attune.core.messages import ObjectSpec, OutcomeReason, OutcomeStatus
from attune.planner.agenda import Agenda


@dataclass(frozen=True, slots=True)
class Verdict:
    """Something to tell about the command, or (`command`) about an earlier one that it changes."""

    status: OutcomeStatus
    reason: OutcomeReason = ""
    object: ObjectSpec = ObjectSpec()
    place: str = ""
    alternative: ObjectSpec | None = None
    command: str = ""
    kind: str = ""


@dataclass(frozen=True, slots=True)
class Decision:
    """What a command makes of the agenda, and what to tell. It was refused if no verdict says otherwise."""

    agenda: Agenda
    verdicts: tuple[Verdict, ...]

    @property
    def accepted(self) -> bool:
        """Whether any of it is carried out."""
        return any(verdict.status == "accepted" for verdict in self.verdicts)


def refused(agenda: Agenda, reason: OutcomeReason, object: ObjectSpec = ObjectSpec(), place: str = "") -> Decision:
    """Nothing of it is done."""
    return Decision(agenda, (Verdict("refused", reason, object, place),))


def told(agenda: Agenda, verdicts: list[Verdict]) -> Decision:
    """One acceptance for the command, and each refused object."""
    accepted = [verdict for verdict in verdicts if verdict.status == "accepted"]
    others = tuple(verdict for verdict in verdicts if verdict.status != "accepted")
    if len(accepted) > 1:
        accepted = [Verdict("accepted", place=accepted[0].place)]
    return Decision(agenda, (*accepted, *others))
