"""The robot's symbolic state, published whenever it changes, before the movement that it announces begins."""

from dataclasses import replace
from typing import Any

from attune.core.bus import OBJECTS_IN_USE, ROBOT_STATE, Bus
from attune.core.clock import Clock
from attune.core.messages import ObjectsInUse, ObjectSpec, QueuedTask, RobotState, Step
from attune.planner.agenda import Agenda, Delivery, Goal
from attune.planner.belief import Belief
from attune.planner.forewarning import Forewarning


class StateBoard:
    """Holds the state and publishes each change of it."""

    def __init__(self, bus: Bus, clock: Clock) -> None:
        self._bus = bus
        self._clock = clock
        self._forewarning = Forewarning(bus, clock)
        self._state = RobotState(time=clock.now())
        self._halted_step: Step | None = None
        self._published: RobotState | None = None
        self._in_use: tuple[ObjectSpec, ...] | None = None

    @property
    def state(self) -> RobotState:
        """The state as it is without a halt."""
        return self._state

    def update(self, **changes: Any) -> None:
        """Change fields of the state."""
        self.note(**changes)
        self._publish()

    def note(self, **changes: Any) -> None:
        """Change fields of the state, to be published together with the next change that follows at once."""
        self._state = replace(self._state, **changes)

    async def before_moving(self, **changes: Any) -> None:
        """Change fields of the state, and wait until the person has been warned, if they want that."""
        self.update(**changes)
        await self._forewarning.given()

    def halted(self, step: Step | None) -> None:
        """The robot stands still as `paused` or `stopped`, or (None) does not any more."""
        self._halted_step = step
        self._publish()

    def refresh(self, agenda: Agenda, belief: Belief, goal: Goal | None) -> None:
        """Take queue, progress, held objects and objects in use from agenda and belief."""

        def described(delivery: Delivery) -> ObjectSpec:
            item = belief.get(delivery.individual)
            return belief.describe(item) if item else delivery.spec

        task = [item for item in agenda.task if item.status in {"waiting", "returning", "delivered"}]
        queue = tuple(
            QueuedTask(
                object=described(item),
                destination=belief.home_of(item.individual) if item.status == "returning" else item.destination,
                status="active" if goal and goal.delivery == item.id and item.status == "waiting" else item.status,  # type: ignore[arg-type]
                command=item.command,
            )
            for item in task
        )
        done = sum(item.status == "delivered" for item in queue)
        self.update(
            queue=queue,
            progress=done / len(queue) if queue else 0.0,
            holding=tuple(belief.describe(item) for item in belief.held().values()),
        )
        in_use = tuple(described(item) for item in agenda.open)
        if in_use != self._in_use:
            self._in_use = in_use
            self._bus.publish(OBJECTS_IN_USE, ObjectsInUse(time=self._clock.now(), objects=in_use))

    def _publish(self) -> None:
        state = self._state
        if self._halted_step:
            state = replace(state, step=self._halted_step, interruptible=True, move_arm=False, move_base=False)
        if self._published and replace(state, time=self._published.time, id=self._published.id) == self._published:
            return
        # A message of its own each time: new id, new time.
        self._published = RobotState(
            **{name: getattr(state, name) for name in RobotState.__dataclass_fields__ if name not in {"id", "time"}},
            time=self._clock.now(),
        )
        self._bus.publish(ROBOT_STATE, self._published)
