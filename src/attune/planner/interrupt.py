"""The interrupt client: commands become edits of the agenda at any moment; a stop halts the robot at once.

A command ends the running plan only if that is not the right one any more; during an atomic part it waits for its end
and the user is told. A stop has its own path: an inline handler that waits for nobody.
"""

from collections.abc import Callable

import anyio
from anyio.abc import TaskStatus

from attune.core.bus import COMMAND, ROBOT_STOP, Bus
from attune.core.messages import CarryOn, Command, Stop, StopSignal
from attune.planner.agenda import Agenda
from attune.planner.commands import Edit, Rules
from attune.planner.desk import Desk
from attune.planner.skills import Skills


class InterruptClient:
    """Listens to commands and stops, and edits the desk.

    Args:
        bus: Where they come from.
        desk: What they change.
        skills: The robot.
        rules: What commands mean.
    """

    def __init__(self, bus: Bus, desk: Desk, skills: Skills, rules: Rules) -> None:
        self._bus = bus
        self._desk = desk
        self._skills = skills
        self._robot = skills.robot
        self._rules = rules
        self._news = anyio.Event()
        self.stopped = False
        """A stop was confirmed and nothing was asked for since."""
        self.paused = False
        """A stop was only spotted."""

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Listen until cancelled; started once nothing can be missed any more."""
        unsubscribe: Callable[[], None] = self._bus.on(ROBOT_STOP, self._on_stop)
        try:
            with self._bus.subscribe(COMMAND) as commands:
                task_status.started()
                async for command in commands:
                    self._on_command(command)
        finally:
            unsubscribe()

    async def news(self) -> None:
        """Wait until something was asked for."""
        await self._news.wait()
        self._news = anyio.Event()

    # --- stop --------------------------------------------------------------------------------------------------

    def _on_stop(self, signal: StopSignal) -> None:
        if signal.state == "withdrawn":
            if self.paused:
                self._go_on()
            return
        self._robot.halt()
        if signal.state == "confirmed":
            self._stop()
        elif not self.stopped:
            self.paused = True
            self._desk.board.halted("paused")

    def _stop(self) -> None:
        self._robot.halt()
        self.paused = False
        if self._desk.plan:
            self._desk.plan.stop()
        if not self.stopped:
            self.stopped = True
            self._desk.board.halted("stopped")
            self._desk.interrupted()

    def _go_on(self) -> None:
        self.paused = self.stopped = False
        self._robot.resume()
        self._desk.board.halted(None)
        self._news.set()

    # --- commands ----------------------------------------------------------------------------------------------

    def _on_command(self, command: Command) -> None:
        self._skills.reconcile()
        match command:
            case Stop():
                self._desk.tell(command.id, command.kind, "accepted")
                self._stop()
                self._desk.tell(command.id, command.kind, "done", "stopped")
            case CarryOn():
                self._carry_on(command)
            case _:
                if self.paused:
                    self._go_on()
                self._edit(command)

    def _carry_on(self, command: CarryOn) -> None:
        was_halted = self.stopped or self.paused
        if was_halted:
            self._go_on()
        if was_halted and self._desk.next_goal():
            self._desk.tell(command.id, command.kind, "accepted")
            self._desk.tell(command.id, command.kind, "done")
        else:
            self._desk.tell(command.id, command.kind, "refused", "nothing_to_do")

    def _edit(self, command: Edit) -> None:
        self._desk.given_up.clear()
        self._desk.adopt()
        agenda = self._afresh() if self.stopped else self._desk.agenda
        decision = self._rules.decide(command, agenda)
        deferred = False
        if decision.accepted:
            if self.stopped:
                self._go_on()
            deferred = self._desk.edit(decision.agenda)
            self._news.set()
        for verdict in decision.verdicts:
            status, reason = verdict.status, verdict.reason
            if status == "accepted" and deferred:
                status, reason = "deferred", "atomic_step"
            earlier = verdict.status == "cancelled"
            self._desk.tell(
                verdict.command if earlier else command.id,
                verdict.kind if earlier else command.kind,
                status,
                reason,
                verdict.object,
                verdict.place,
                verdict.alternative,
            )
        if decision.accepted and command.id not in {item.command for item in decision.agenda.open}:
            # Nothing is left to do for it: it only changed what earlier commands do.
            self._desk.tell(command.id, command.kind, "done", place=decision.verdicts[0].place)
        resting = self._desk.plan is None and not self.stopped
        if resting and {verdict.reason for verdict in decision.verdicts} == {"already_there"}:
            self._desk.board.update(step="already_done")

    def _afresh(self) -> Agenda:
        """The agenda without what was stopped, but for what is in the gripper: that goes home unless it is used."""
        held = {item.name for item in self._desk.belief.held().values()}
        agenda = self._desk.agenda
        for delivery in agenda.open:
            kept = delivery.individual in held
            agenda = agenda.change(delivery.id, status="returning" if kept else "dropped", command="", kind="put_back")
        return agenda
