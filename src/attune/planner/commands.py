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
    PutBack,
    ReplaceObject,
    SettingBreakfast,
)
from attune.core.scene import Scene
from attune.planner.agenda import Agenda, Delivery
from attune.planner.belief import Belief
from attune.planner.designators import alternative, candidates, delivery_surfaces, is_delivered
from attune.planner.meant import brought_but_open, carried, described, is_about, last_delivered, meant
from attune.planner.verdicts import Decision, Verdict, refused, told

Edit = BringMe | SettingBreakfast | ReplaceObject | ChangeLocation | CancelObject | PutBack
"""The commands that edit the agenda; stop and carry on do not."""


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
                    "cancelled", reason, described(self.belief, delivery), command=delivery.command, kind=delivery.kind
                )

    # --- bring me ----------------------------------------------------------------------------------------------

    def _bring(self, command: Edit, agenda: Agenda, objects: Iterable[ObjectSpec], destination: str) -> Decision:
        place = destination or self._default_destination(command.band)
        if not self.scene.surfaces_at(place):
            return refused(agenda, "unknown_place", place=place)
        agenda = agenda.begin_task()
        verdicts: list[Verdict] = []
        for spec in objects:
            agenda, verdict = self._want(command, agenda, spec, place, named_place=bool(destination))
            verdicts.append(verdict)
        return told(agenda, verdicts) if verdicts else refused(agenda, "nothing_to_do")

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
            if returning and is_about(self.belief, delivery, spec):
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
            if is_about(self.belief, delivery, spec) and named_place and delivery.destination != place:
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
        coming = next((delivery for delivery in agenda.waiting if is_about(self.belief, delivery, spec)), None)
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
            coming = any(is_about(self.belief, item, spec) and item.destination == place for item in agenda.waiting)
            if not standing and not coming:
                missing.append(spec)
        if not missing:
            return refused(agenda, "already_there" if not agenda.waiting else "nothing_to_do", place=place)
        decision = self._bring(command, agenda, missing, "")
        others = tuple(verdict for verdict in decision.verdicts if verdict.status == "refused")
        verdicts = (Verdict("accepted", place=place), *others) if decision.accepted else others
        return Decision(decision.agenda, verdicts)

    # --- replace -----------------------------------------------------------------------------------------------

    def _replace(self, command: ReplaceObject, agenda: Agenda) -> Decision:
        old = meant(self.belief, agenda, command.remove)
        place = command.destination or (old.destination if old else "") or self._default_destination(command.band)
        if not self.scene.surfaces_at(place):
            return refused(agenda, "unknown_place", place=place)
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
            return Decision(changed, (Verdict("accepted", object=described(self.belief, old)), verdict))
        return Decision(changed, (verdict,))

    # --- change location ---------------------------------------------------------------------------------------

    def _change_location(self, command: ChangeLocation, agenda: Agenda) -> Decision:
        place = command.destination
        if not self.scene.surfaces_at(place):
            return refused(agenda, "unknown_place", place=place)
        if command.objects:
            verdicts: list[Verdict] = []
            for spec in command.objects:
                old = meant(self.belief, agenda, spec)
                if old is None:
                    agenda, verdict = self._want(command, agenda.begin_task(), spec, place, named_place=True)
                else:
                    agenda, verdict = self._redirect(command, agenda, old, place)
                verdicts.append(verdict)
            return told(agenda, verdicts)
        meant_all = agenda.waiting or carried(self.belief, agenda) or last_delivered(agenda)
        if not meant_all:
            return refused(agenda, "nothing_to_do", place=place)
        verdicts = []
        for delivery in meant_all:
            agenda, verdict = self._redirect(command, agenda, delivery, place)
            verdicts.append(verdict)
        return told(agenda, verdicts)

    def _redirect(
        self, command: ChangeLocation, agenda: Agenda, delivery: Delivery, place: str
    ) -> tuple[Agenda, Verdict]:
        spec = described(self.belief, delivery)
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
        tidied = tuple(item for item in carried(self.belief, agenda) if not item.command)
        old = meant(self.belief, Agenda((*tidied, *agenda.waiting)), command.object)
        if old is None:
            return refused(agenda, "nothing_to_do", object=command.object)
        changed = self._withdraw(agenda, old, command)
        return Decision(changed, (Verdict("accepted", object=described(self.belief, old)),))

    def _put_back(self, command: PutBack, agenda: Agenda) -> Decision:
        old = self._to_put_back(agenda, command.object)
        if old is None:
            return self._put_back_displaced(command, agenda)
        verdict = Verdict("accepted", object=described(self.belief, old))
        if old.status == "returning":
            return Decision(agenda.change(old.id, command=command.id, kind=command.kind), (verdict,))
        if old.open:
            return Decision(self._withdraw(agenda, old, command), (verdict,))
        return Decision(self._fetch_back(command, agenda, old), (verdict,))

    def _to_put_back(self, agenda: Agenda, spec: ObjectSpec) -> Delivery | None:
        held = carried(self.belief, agenda)
        if spec == ObjectSpec():
            options = held or brought_but_open(self.belief, agenda)[-1:] or last_delivered(agenda)[-1:]
        else:
            delivered = tuple(item for item in agenda.deliveries if item.status == "delivered")[::-1]
            options = (*held, *delivered, *agenda.waiting)
        return next((item for item in options if is_about(self.belief, item, spec)), None)

    def _put_back_displaced(self, command: PutBack, agenda: Agenda) -> Decision:
        """Put back something that no delivery is about, if it is not at home."""
        spec = command.object
        if spec == ObjectSpec():
            return refused(agenda, "nothing_to_do")
        fitting = candidates(self.belief, spec, agenda.reserved)
        for item in fitting:
            if item.displaced:
                known = self.belief.describe(item)
                home = replace(_delivery(command, known, "", item.name), status="returning")
                return Decision(agenda.begin_task().add(home), (Verdict("accepted", object=known),))
        return refused(agenda, "already_there" if fitting else "not_found", object=spec)

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

    def _default_destination(self, band: Band) -> str:
        return {
            "younger": self.config.destination_younger,
            "older": self.config.destination_older,
            "unknown": self.config.destination_unknown,
        }[band]


def _delivery(command: Edit, spec: ObjectSpec, place: str, individual: str) -> Delivery:
    return Delivery(spec=spec, destination=place, command=command.id, kind=command.kind, individual=individual)
