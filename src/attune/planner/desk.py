"""The planner's desk: what is wanted, what is believed, and the plan that runs now, in one consistent place."""

from attune.core.bus import OUTCOME, PLAN, WORLD, Bus
from attune.core.clock import Clock
from attune.core.errors import AttuneError
from attune.core.messages import (
    CommandOutcome,
    ObjectSpec,
    OutcomeReason,
    OutcomeStatus,
    PlanNode,
    PlanTree,
    WorldState,
)
from attune.core.scene import Scene
from attune.planner.agenda import Agenda, Delivery, Goal
from attune.planner.belief import Belief, Individual
from attune.planner.designators import alternative
from attune.planner.plan import Plan
from attune.planner.recovery import NotFound, reason_of
from attune.planner.state import StateBoard


class Desk:
    """Holds agenda, belief, state and the running plan, and tells what becomes of commands."""

    def __init__(self, bus: Bus, clock: Clock, scene: Scene) -> None:
        self._bus = bus
        self._clock = clock
        self.scene = scene
        self.board = StateBoard(bus, clock)
        self.belief = Belief(scene, clock, self._world_changed)
        self.agenda = Agenda()
        self.goal: Goal | None = None
        self.plan: Plan | None = None
        self.given_up: set[str] = set()
        """Held objects that could not be put down anywhere."""
        self.aside: dict[str, str] = {}
        """Objects that are being moved out of the way, and the deliveries that they are in the way of."""

    # --- the plan ----------------------------------------------------------------------------------------------

    def begin(self, goal: Goal | None) -> Plan:
        """Make the plan for a goal the running one."""
        self.goal = goal
        self.plan = Plan(self._clock, self._plan_changed, lambda atomic: self.board.update(interruptible=not atomic))
        self.refresh()
        return self.plan

    def end(self) -> None:
        """No plan runs any more."""
        self.plan = self.goal = None
        self.board.update(interruptible=True)
        self.refresh()

    def adopt(self) -> None:
        """See that all that is held is in the agenda: what nobody wants is brought to where it was taken from."""
        for item in self.belief.held().values():
            if self.agenda.of(item.name) is None and item.name not in self.given_up and not self._is_moved(item):
                # What was delivered and stood there when nobody wanted it elsewhere any more goes back there.
                delivered = item.displaced and item.taken_from
                tidy = Delivery(
                    spec=self.belief.describe(item),
                    destination=self.scene.surface(item.taken_from).place if delivered else "",
                    command="",
                    kind="put_back",
                    status="waiting" if delivered else "returning",
                    individual=item.name,
                )
                self.agenda = self.agenda.add(tidy)

    def _is_moved(self, item: Individual) -> bool:
        """Whether an object is held only to be put out of the way of something that is still wanted."""
        return self.aside.get(item.name) in {delivery.id for delivery in self.agenda.open}

    def moved_aside(self, name: str, *, back: bool) -> None:
        """An object has been put out of the way; `back`: it is to be brought home when nothing else is to be done."""
        self.aside.pop(name, None)
        item = self.belief.get(name)
        if back and item and item.displaced and self.agenda.of(name) is None:
            spec = self.belief.describe(item)
            home = Delivery(spec=spec, destination="", command="", kind="put_back", status="returning", individual=name)
            self.agenda = self.agenda.add(home)

    def next_goal(self) -> Goal | None:
        """What to work on."""
        self.adopt()
        return self.agenda.goal(item.name for item in self.belief.held().values())

    def edit(self, agenda: Agenda) -> bool:
        """Replace the agenda; interrupt the plan if it is not the right one any more.

        Returns:
            Whether the interruption has to wait for the end of an atomic part.
        """
        self.agenda = agenda
        deferred = False
        if self.plan:
            if self.next_goal() != self.goal:
                deferred = self.plan.interrupt()
            else:
                self.plan.spare()
        self.refresh()
        return deferred

    def reserve(self, goal: Goal, individual: str) -> None:
        """The object of a goal has been found."""
        self.agenda = self.agenda.change(goal.delivery, individual=individual)
        self.refresh()

    def close(self, goal: Goal, item: Individual, reason: OutcomeReason = "") -> None:
        """The object of a goal is where it belongs."""
        delivery = self.agenda.get(goal.delivery)
        place = self.belief.place_of(self.belief.get(item.name) or item)
        returned = delivery.status == "returning"
        self.agenda = self.agenda.change(goal.delivery, status="returned" if returned else "delivered")
        if not returned or delivery.kind in {"put_back", "cancel_object"}:
            self._tell_delivery(delivery, "done", reason, place=place)
        self._tell_end(delivery)
        self.refresh()

    def fail(self, goal: Goal, failure: AttuneError) -> None:
        """A goal cannot be reached."""
        delivery = self.agenda.get(goal.delivery)
        reason = reason_of(failure)
        item = self.belief.get(delivery.individual)
        nearest = None
        if reason in {"not_found", "unreachable", "grasp_failed"} and not (item and item.held_by):
            others = self.agenda.reserved | {delivery.individual}
            wanted = self.belief.describe(item) if item and not delivery.spec.type else delivery.spec
            nearest = alternative(self.belief, wanted, others)
        if delivery.status == "returning" and delivery.individual:
            self.given_up.add(delivery.individual)
        self.agenda = self.agenda.change(goal.delivery, status="failed")
        self.board.update(step="failed")
        behind = failure.behind if isinstance(failure, NotFound) else None
        self._tell_delivery(delivery, "failed", reason, nearest=nearest, behind=behind, detail=str(failure))
        self._tell_end(delivery)
        self.refresh()

    def interrupted(self) -> None:
        """A stop: tell so for each command that has something open."""
        for command, kind in dict.fromkeys((item.command, item.kind) for item in self.agenda.open):
            self.tell(command, kind, "interrupted", "stopped")

    # --- telling -----------------------------------------------------------------------------------------------

    def tell(
        self,
        command: str,
        kind: str,
        status: OutcomeStatus,
        reason: OutcomeReason = "",
        object_: ObjectSpec = ObjectSpec(),
        place: str = "",
        nearest: ObjectSpec | None = None,
        behind: ObjectSpec | None = None,
        detail: str = "",
    ) -> None:
        """Publish what became of a command; nobody asked for what has no command."""
        if not command and status != "failed":
            return
        outcome = CommandOutcome(
            time=self._clock.now(),
            cause=command,
            command=command,
            kind=kind,
            status=status,
            reason=reason,
            object=object_,
            place=place,
            alternative=nearest,
            behind=behind,
            detail=detail,
        )
        self._bus.publish(OUTCOME, outcome)

    def refresh(self) -> None:
        """Publish the state that follows from agenda and belief."""
        self.board.refresh(self.agenda, self.belief, self.goal)

    def _tell_delivery(
        self,
        delivery: Delivery,
        status: OutcomeStatus,
        reason: OutcomeReason = "",
        *,
        place: str = "",
        nearest: ObjectSpec | None = None,
        behind: ObjectSpec | None = None,
        detail: str = "",
    ) -> None:
        item = self.belief.get(delivery.individual)
        spec = self.belief.describe(item) if item else delivery.spec
        place = place or delivery.destination
        self.tell(delivery.command, delivery.kind, status, reason, spec, place, nearest, behind, detail)

    def _tell_end(self, delivery: Delivery) -> None:
        """A command about several objects ends with an outcome of its own, without object."""
        same = [item for item in self.agenda.deliveries if item.command == delivery.command]
        wanted = [item for item in same if item.status in {"delivered", "failed"}]
        if delivery.command and len(wanted) > 1 and not any(item.open for item in same):
            arrived = sum(item.status == "delivered" for item in wanted)
            self.tell(
                delivery.command,
                delivery.kind,
                "done" if arrived == len(wanted) else "failed",
                place=wanted[-1].destination,
                detail=f"{arrived} of {len(wanted)} arrived",
            )

    def _world_changed(self, world: WorldState) -> None:
        self._bus.publish(WORLD, world)
        self.refresh()

    def _plan_changed(self, root: PlanNode) -> None:
        self._bus.publish(PLAN, PlanTree(time=self._clock.now(), root=root))
