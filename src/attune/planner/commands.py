"""The commands as edits of the agenda.

Each rule is a pure function of the command, the agenda and what is believed: it gives a new agenda and what to tell
about it, or a refusal with its reason. It works the same whatever the robot does at that moment, so each command is
also an interruption of each other.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from attune.core.config import PlannerConfig
from attune.core.messages import (
    Band,
    BringMe,
    CancelObject,
    ChangeLocation,
    ObjectSpec,
    OutcomeReason,
    OutcomeStatus,
    PutBack,
    ReplaceObject,
    SettingBreakfast,
)
from attune.core.scene import Scene
from attune.planner.agenda import Agenda, Delivery
from attune.planner.belief import Belief, Home, Individual
from attune.planner.designators import alternative, candidates, delivery_surfaces, is_delivered

Edit = BringMe | SettingBreakfast | ReplaceObject | ChangeLocation | CancelObject | PutBack
"""The commands that edit the agenda; stop and carry on do not."""


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


@dataclass(frozen=True, slots=True)
class Rules:
    """What the rules look at."""

    scene: Scene
    belief: Belief
    config: PlannerConfig

    def decide(self, command: Edit, agenda: Agenda) -> Decision:
        """Edit the agenda by a command."""
        match command:
            case BringMe():
                decision = self._bring(command, agenda, command.objects, command.destination)
            case SettingBreakfast():
                decision = self._breakfast(command, agenda)
            case ReplaceObject():
                decision = self._replace(command, agenda)
            case ChangeLocation():
                decision = self._change_location(command, agenda)
            case CancelObject():
                decision = self._cancel(command, agenda)
            case PutBack():
                decision = self._put_back(command, agenda)
        if not decision.accepted:
            return Decision(agenda, decision.verdicts)
        return Decision(decision.agenda, (*decision.verdicts, *self._overruled(command, agenda, decision.agenda)))

    def _overruled(self, command: Edit, before: Agenda, after: Agenda) -> Iterator[Verdict]:
        """Earlier commands that have lost an object to this one."""
        reason: OutcomeReason = "" if isinstance(command, CancelObject | PutBack) else "replaced"
        left = {delivery.id: delivery.command for delivery in after.open}
        for delivery in before.open:
            if delivery.command and left.get(delivery.id) != delivery.command:
                yield Verdict(
                    "cancelled", reason, self._described(delivery), command=delivery.command, kind=delivery.kind
                )

    # --- bring me ----------------------------------------------------------------------------------------------

    def _bring(self, command: Edit, agenda: Agenda, objects: Iterable[ObjectSpec], destination: str) -> Decision:
        place = destination or self._default_destination(command.band)
        if not self.scene.surfaces_at(place):
            return _refused(agenda, "unknown_place", place=place)
        agenda = agenda.begin_task()
        verdicts: list[Verdict] = []
        for spec in objects:
            agenda, verdict = self._want(command, agenda, spec, place, named_place=bool(destination))
            verdicts.append(verdict)
        return _told(agenda, verdicts) if verdicts else _refused(agenda, "nothing_to_do")

    def _want(
        self,
        command: Edit,
        agenda: Agenda,
        spec: ObjectSpec,
        place: str,
        *,
        named_place: bool,
        excluded: frozenset[str] = frozenset(),
    ) -> tuple[Agenda, Verdict]:
        """One object that is wanted at a place."""
        if problem := self._nonsense(spec):
            return agenda, problem
        for delivery in agenda.open:
            returning = delivery.status == "returning" and delivery.individual not in excluded
            if returning and self._is_about(delivery, spec):
                changes = {"status": "waiting", "destination": place, "command": command.id, "kind": command.kind}
                return agenda.change(delivery.id, **changes), Verdict("accepted", object=spec, place=place)
        reserved = agenda.reserved | excluded
        fitting = candidates(self.belief, spec, reserved)
        # What is only expected to stand there already is looked at first, and comes last.
        there = [item for item in fitting if is_delivered(self.scene, item, place)]
        fetchable = [item for item in fitting if item not in there] + [item for item in there if item.seen is None]
        fitting_there = [item for item in fetchable if delivery_surfaces(self.scene, place, item)]
        if fetchable and not fitting_there:
            return agenda, Verdict("refused", "no_space", self.belief.describe(fetchable[0]), place)
        fetchable = fitting_there
        if fetchable or self._may_be_there(spec):
            individual = fetchable[0].name if fetchable else ""
            wanted = _delivery(command, spec, place, individual)
            return agenda.add(wanted), Verdict("accepted", object=spec, place=place)
        for delivery in agenda.waiting:
            if self._is_about(delivery, spec) and named_place and delivery.destination != place:
                return agenda.change(delivery.id, destination=place), Verdict("accepted", object=spec, place=place)
        return agenda, self._why_not(agenda, spec, place, excluded)

    def _nonsense(self, spec: ObjectSpec) -> Verdict | None:
        if not (spec.type or spec.color or spec.size or spec.name):
            return Verdict("refused", "unknown_object", spec)
        if spec.location and not self.scene.surfaces_at(spec.location):
            return Verdict("refused", "unknown_place", spec, spec.location)
        return None

    def _why_not(self, agenda: Agenda, spec: ObjectSpec, place: str, excluded: frozenset[str]) -> Verdict:
        """The refusal of an object that cannot be brought."""
        coming = next((delivery for delivery in agenda.waiting if self._is_about(delivery, spec)), None)
        if coming:
            return Verdict("refused", "nothing_to_do", spec, coming.destination)
        reserved = agenda.reserved | excluded
        standing = candidates(self.belief, spec, reserved)
        if standing:
            return Verdict("refused", "already_there", self.belief.describe(standing[0]), place)
        known = spec.type in self.scene.vocabulary.types or any(item.type == spec.type for item in self.belief.objects)
        reason: OutcomeReason = "not_found" if known else "unknown_object"
        return Verdict("refused", reason, spec, spec.location, alternative(self.belief, spec, reserved))

    def _may_be_there(self, spec: ObjectSpec) -> bool:
        """Whether a person who names a place may know of an object that the robot has not met."""
        fitting = candidates(self.belief, replace(spec, location=""))
        known = spec.type in self.scene.vocabulary.types
        return (
            bool(spec.location) and known and not any(self.belief.place_of(item) == spec.location for item in fitting)
        )

    # --- breakfast ---------------------------------------------------------------------------------------------

    def _breakfast(self, command: SettingBreakfast, agenda: Agenda) -> Decision:
        place = self._default_destination(command.band)
        missing: list[ObjectSpec] = []
        for type_ in self.config.breakfast:
            spec = ObjectSpec(type=type_)
            # What is about to be taken away or elsewhere does not count.
            free = candidates(self.belief, spec, agenda.reserved)
            standing = any(is_delivered(self.scene, item, place) for item in free)
            coming = any(self._is_about(item, spec) and item.destination == place for item in agenda.waiting)
            if not standing and not coming:
                missing.append(spec)
        if not missing:
            return _refused(agenda, "already_there" if not agenda.waiting else "nothing_to_do", place=place)
        decision = self._bring(command, agenda, missing, "")
        refused = tuple(verdict for verdict in decision.verdicts if verdict.status == "refused")
        told = (Verdict("accepted", place=place), *refused) if decision.accepted else refused
        return Decision(decision.agenda, told)

    # --- replace -----------------------------------------------------------------------------------------------

    def _replace(self, command: ReplaceObject, agenda: Agenda) -> Decision:
        old = self._meant(agenda, command.remove)
        place = command.destination or (old.destination if old else "") or self._default_destination(command.band)
        if not self.scene.surfaces_at(place):
            return _refused(agenda, "unknown_place", place=place)
        if old is None:
            changed, verdict = self._want(command, agenda.begin_task(), command.add, place, named_place=True)
            return Decision(changed, (verdict,))
        without = self._withdraw(agenda, old, command) if old.open else self._fetch_back(command, agenda, old)
        # The old one must not be chosen as the new one.
        changed, verdict = self._want(
            command, without, command.add, place, named_place=True, excluded=frozenset({old.individual})
        )
        if verdict.reason == "already_there":
            # What is wanted instead stands there: all there is to do is to take the old one away.
            for delivery in without.open:
                if delivery.command == command.id:
                    changed = changed.change(delivery.id, kind="put_back")
            return Decision(changed, (Verdict("accepted", object=self._described(old)), verdict))
        return Decision(changed, (verdict,))

    # --- change location ---------------------------------------------------------------------------------------

    def _change_location(self, command: ChangeLocation, agenda: Agenda) -> Decision:
        place = command.destination
        if not self.scene.surfaces_at(place):
            return _refused(agenda, "unknown_place", place=place)
        if command.objects:
            verdicts: list[Verdict] = []
            for spec in command.objects:
                meant = self._meant(agenda, spec)
                if meant is None:
                    agenda, verdict = self._want(command, agenda.begin_task(), spec, place, named_place=True)
                else:
                    agenda, verdict = self._redirect(command, agenda, meant, place)
                verdicts.append(verdict)
            return _told(agenda, verdicts)
        meant_all = agenda.waiting or self._carried(agenda) or self._last_delivered(agenda)
        if not meant_all:
            return _refused(agenda, "nothing_to_do", place=place)
        verdicts = []
        for delivery in meant_all:
            agenda, verdict = self._redirect(command, agenda, delivery, place)
            verdicts.append(verdict)
        return _told(agenda, verdicts)

    def _redirect(
        self, command: ChangeLocation, agenda: Agenda, delivery: Delivery, place: str
    ) -> tuple[Agenda, Verdict]:
        spec = self._described(delivery)
        if delivery.status != "returning" and delivery.destination == place:
            return agenda, Verdict("refused", "already_there", spec, place)
        item = self.belief.get(delivery.individual)
        if item and not delivery_surfaces(self.scene, place, item):
            return agenda, Verdict("refused", "no_space", spec, place)
        accepted = Verdict("accepted", object=spec, place=place)
        if delivery.status == "waiting":
            return agenda.change(delivery.id, destination=place), accepted
        if delivery.open:
            changes = {"status": "waiting", "destination": place, "command": command.id, "kind": command.kind}
            return agenda.change(delivery.id, **changes), accepted
        moved = _delivery(command, replace(spec, location=""), place, delivery.individual)
        return agenda.begin_task().change(delivery.id, status="dropped").add(moved), accepted

    # --- cancel and put back -----------------------------------------------------------------------------------

    def _cancel(self, command: CancelObject, agenda: Agenda) -> Decision:
        tidied = tuple(item for item in self._carried(agenda) if not item.command)
        meant = self._meant(Agenda((*tidied, *agenda.waiting)), command.object)
        if meant is None:
            return _refused(agenda, "nothing_to_do", object=command.object)
        changed = self._withdraw(agenda, meant, command)
        return Decision(changed, (Verdict("accepted", object=self._described(meant)),))

    def _put_back(self, command: PutBack, agenda: Agenda) -> Decision:
        meant = self._to_put_back(agenda, command.object)
        if meant is None:
            return self._put_back_displaced(command, agenda)
        told = Verdict("accepted", object=self._described(meant))
        if meant.status == "returning":
            return Decision(agenda.change(meant.id, command=command.id, kind=command.kind), (told,))
        if meant.open:
            return Decision(self._withdraw(agenda, meant, command), (told,))
        return Decision(self._fetch_back(command, agenda, meant), (told,))

    def _to_put_back(self, agenda: Agenda, spec: ObjectSpec) -> Delivery | None:
        carried = self._carried(agenda)
        if spec == ObjectSpec():
            options = carried or self._brought_but_open(agenda)[-1:] or self._last_delivered(agenda)[-1:]
        else:
            delivered = tuple(item for item in agenda.deliveries if item.status == "delivered")[::-1]
            options = (*carried, *delivered, *agenda.waiting)
        return next((item for item in options if self._is_about(item, spec)), None)

    def _put_back_displaced(self, command: PutBack, agenda: Agenda) -> Decision:
        """Put back something that no delivery is about, if it is not at home."""
        spec = command.object
        if spec == ObjectSpec():
            return _refused(agenda, "nothing_to_do")
        fitting = candidates(self.belief, spec, agenda.reserved)
        for item in fitting:
            if item.displaced:
                known = self.belief.describe(item)
                home = replace(_delivery(command, known, "", item.name), status="returning")
                return Decision(agenda.begin_task().add(home), (Verdict("accepted", object=known),))
        return _refused(agenda, "already_there" if fitting else "not_found", object=spec)

    def _fetch_back(self, command: Edit, agenda: Agenda, delivered: Delivery) -> Agenda:
        """Bring a delivered object home again."""
        home = replace(_delivery(command, delivered.spec, "", delivered.individual), status="returning")
        return agenda.begin_task().change(delivered.id, status="dropped").add(home)

    def _withdraw(self, agenda: Agenda, delivery: Delivery, command: Edit) -> Agenda:
        """End an open delivery: what is carried goes home, what was not fetched yet is dropped.

        What was delivered, and should have been brought elsewhere, stays if it is cancelled, goes home otherwise.
        """
        item = self.belief.get(delivery.individual)
        stays = isinstance(command, CancelObject) and not (
            item and is_delivered(self.scene, item, delivery.destination)
        )
        if item and (item.held_by or (item.displaced and item.surface and not stays)):
            return agenda.change(delivery.id, status="returning", command=command.id, kind=command.kind)
        return agenda.change(delivery.id, status="dropped")

    # --- what is meant -----------------------------------------------------------------------------------------

    def _meant(self, agenda: Agenda, spec: ObjectSpec) -> Delivery | None:
        """The delivery that a description is about: carried, else waiting, else delivered last."""
        delivered = [item for item in agenda.deliveries if item.status == "delivered"][::-1]
        return next(
            (item for item in (*self._carried(agenda), *agenda.waiting, *delivered) if self._is_about(item, spec)), None
        )

    def _carried(self, agenda: Agenda) -> tuple[Delivery, ...]:
        held = {item.name for item in self.belief.held().values()}
        return tuple(item for item in agenda.open if item.individual in held)

    def _last_delivered(self, agenda: Agenda) -> tuple[Delivery, ...]:
        """What the last task has delivered."""
        delivered = [item for item in agenda.deliveries if item.status == "delivered"]
        return tuple(item for item in delivered if item.command == delivered[-1].command)

    def _brought_but_open(self, agenda: Agenda) -> tuple[Delivery, ...]:
        """What was put down at this moment, or was delivered before and waits to be brought elsewhere."""
        items = ((delivery, self.belief.get(delivery.individual)) for delivery in agenda.waiting)
        return tuple(delivery for delivery, item in items if item and item.displaced)

    def _is_about(self, delivery: Delivery, spec: ObjectSpec) -> bool:
        """Whether a delivery fits a description, by the object chosen for it or else by what was asked for."""
        spec = replace(spec, location="")
        item = self.belief.get(delivery.individual)
        if item:
            return item.is_a(spec)
        asked = delivery.spec
        likeness = Individual(
            name=asked.name, type=asked.type, color=asked.color, size=asked.size or "normal", surface="", home=Home("")
        )
        return likeness.is_a(spec)

    def _described(self, delivery: Delivery) -> ObjectSpec:
        item = self.belief.get(delivery.individual)
        return self.belief.describe(item) if item else delivery.spec

    def _default_destination(self, band: Band) -> str:
        return {
            "younger": self.config.destination_younger,
            "older": self.config.destination_older,
            "unknown": self.config.destination_unknown,
        }[band]


def _delivery(command: Edit, spec: ObjectSpec, place: str, individual: str) -> Delivery:
    return Delivery(spec=spec, destination=place, command=command.id, kind=command.kind, individual=individual)


def _refused(agenda: Agenda, reason: OutcomeReason, object: ObjectSpec = ObjectSpec(), place: str = "") -> Decision:
    return Decision(agenda, (Verdict("refused", reason, object, place),))


def _told(agenda: Agenda, verdicts: list[Verdict]) -> Decision:
    """One acceptance for the command, and each refused object."""
    accepted = [verdict for verdict in verdicts if verdict.status == "accepted"]
    refused = tuple(verdict for verdict in verdicts if verdict.status != "accepted")
    if len(accepted) > 1:
        accepted = [Verdict("accepted", place=accepted[0].place)]
    return Decision(agenda, (*accepted, *refused))
