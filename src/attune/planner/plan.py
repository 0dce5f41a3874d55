"""The running plan: a live tree of parts that can be interrupted anywhere.

A `Part` is a name and an async function of the `Node` it runs as; the function hangs further parts below its node with
`node.do`. `attune.planner.combinators` makes parts of parts. A part ends in one of three ways: it succeeds with
a value, it fails (raises one of `FAILURES`), or it is interrupted (its scope is cancelled); nothing here swallows a
cancellation.
"""

from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, Literal, TypeVar

import anyio
import anyio.lowlevel

from attune.core.clock import Clock
from attune.core.errors import AttuneError
from attune.core.messages import NodeStatus, PlanNode
from attune.robots.interface import RobotFailure

T = TypeVar("T")


class PlanFailure(AttuneError):
    """A plan cannot reach its goal for a reason that is not the robot's."""


FAILURES: tuple[type[AttuneError], ...] = (RobotFailure, PlanFailure)
"""What counts as failing; any other exception is a fault of the program and ends the planner."""


@dataclass(frozen=True, slots=True)
class Part(Generic[T]):
    """Something to do.

    Attributes:
        atomic: A minor interruption waits for its end.
    """

    name: str
    body: Callable[["Node"], Awaitable[T]]
    atomic: bool = False


@dataclass(frozen=True, slots=True)
class Result:
    """How a plan ended.

    Attributes:
        failure: Why it failed, when it did.
    """

    status: Literal["succeeded", "failed", "interrupted"]
    failure: AttuneError | None = None


class Node:
    """A part in the running tree."""

    def __init__(self, plan: "Plan", name: str, *, atomic: bool = False, parent: "Node | None" = None) -> None:
        self._plan = plan
        self._parent = parent
        self._frozen: PlanNode | None = None
        self.name = name
        self.atomic = atomic
        self.status: NodeStatus = "pending"
        self.started: float | None = None
        self.ended: float | None = None
        self.reason = ""
        self.children: list[Node] = []

    def frozen(self) -> PlanNode:
        """This node and those below it as a message."""
        if self._frozen is None:
            self._frozen = PlanNode(
                name=self.name,
                status=self.status,
                started=self.started,
                ended=self.ended,
                reason=self.reason,
                atomic=self.atomic,
                children=tuple(child.frozen() for child in self.children),
            )
        return self._frozen

    def touched(self) -> None:
        """Something of this node has changed: those above it must be frozen anew."""
        node: Node | None = self
        while node and node._frozen:
            node._frozen = None
            node = node._parent

    def expect(self, parts: Sequence[Part[Any]]) -> list["Node"]:
        """Hang parts below this node that will run later, so that the tree shows what is to come."""
        nodes = [Node(self._plan, part.name, atomic=part.atomic, parent=self) for part in parts]
        self.children.extend(nodes)
        self.touched()
        return nodes

    async def do(self, part: Part[T], node: "Node | None" = None) -> T:
        """Run a part below this node and return its value.

        Args:
            part: What to do.
            node: Its node, if `expect` has hung it already.

        Raises:
            One of `FAILURES` when it fails.
        """
        return await (node or self.expect([part])[0]).run(part)

    async def run(self, part: Part[T]) -> T:
        """Run a part as this node."""
        self._plan.enter(self)
        try:
            value = await part.body(self)
        except anyio.get_cancelled_exc_class():
            self._plan.leave(self, "interrupted", self._how_far())
            raise
        except FAILURES as failure:
            self._plan.leave(self, "failed", str(failure))
            raise
        except BaseException as error:
            self._plan.leave(self, "failed", repr(error))
            raise
        self._plan.leave(self, "succeeded")
        if self.atomic:
            await anyio.lowlevel.checkpoint()  # Here a deferred interruption takes effect.
        return value

    @contextmanager
    def atomic_while(self, holds: Callable[[], bool]) -> Iterator[Callable[[], None]]:
        """A minor interruption waits as long as `holds()`. Call what this gives whenever that may have changed."""
        self._plan.hold(holds)
        try:
            yield self._plan.notice
        finally:
            self._plan.release(holds)

    def _how_far(self) -> str:
        done = sum(child.status == "succeeded" for child in self.children)
        at = next((child.name for child in self.children if child.status in {"running", "interrupted"}), "")
        return f"after {done} of {len(self.children)} parts{', during ' + at if at else ''}" if at or done else ""


class Plan:
    """One running tree, and the way to interrupt it. Use once.

    Args:
        clock: Time.
        changed: Told the whole tree at every change.
        atomic_changed: Told whether a minor interruption must wait, when that changes.
        atomic_limit: Longest that a minor interruption waits for an atomic part [s].
    """

    def __init__(
        self,
        clock: Clock,
        changed: Callable[[PlanNode], None],
        atomic_changed: Callable[[bool], None] = lambda atomic: None,
        atomic_limit: float = 60.0,
    ) -> None:
        self._clock = clock
        self._changed = changed
        self._atomic_changed = atomic_changed
        self._atomic_limit = atomic_limit
        self._scope = anyio.CancelScope()
        self._holds: list[Callable[[], bool]] = []
        self._deferred = False
        self._told_atomic = False
        self._root: Node | None = None

    @property
    def atomic(self) -> bool:
        """Whether something runs that a minor interruption waits for."""
        return any(holds() for holds in self._holds)

    async def run(self, part: Part[Any]) -> Result:
        """Run a part as the root of the tree, to its end or its interruption."""
        self._root = Node(self, part.name, atomic=part.atomic)
        with self._scope:
            try:
                await self._root.run(part)
            except FAILURES as failure:
                return Result("failed", failure)
            return Result("succeeded")
        return Result("interrupted")

    def interrupt(self) -> bool:
        """Minor interruption: end the plan now, or at the end of the atomic part. Returns whether it has to wait."""
        if not self.atomic:
            self._scope.cancel()
            return False
        if not self._deferred:
            self._deferred = True
            self._scope.deadline = anyio.current_time() + self._atomic_limit
        return True

    def spare(self) -> None:
        """Take a deferred interruption back: the plan is the right one again."""
        self._deferred = False
        self._scope.deadline = float("inf")

    def stop(self) -> None:
        """Major interruption: end the plan now, whatever runs."""
        self._scope.cancel()

    def enter(self, node: Node) -> None:
        """A node begins."""
        node.status, node.started = "running", self._clock.now()
        node.touched()
        if node.atomic:
            self.hold(_always)
        self._publish()

    def leave(self, node: Node, status: NodeStatus, reason: str = "") -> None:
        """A node has ended."""
        node.status, node.ended, node.reason = status, self._clock.now(), reason
        node.touched()
        if node.atomic:
            self.release(_always)
        self._publish()

    def hold(self, holds: Callable[[], bool]) -> None:
        """From now on a minor interruption waits as long as `holds()`."""
        self._holds.append(holds)
        self.notice()

    def release(self, holds: Callable[[], bool]) -> None:
        """Not any more."""
        self._holds.remove(holds)
        self.notice()

    def notice(self) -> None:
        """Tell it when something cannot be cut short, or can again; then an interruption that waited takes effect."""
        atomic = self.atomic
        if atomic != self._told_atomic:
            self._told_atomic = atomic
            self._atomic_changed(atomic)
        if self._deferred and not atomic:
            self._scope.cancel()

    def _publish(self) -> None:
        if self._root:
            self._changed(self._root.frozen())


def _always() -> bool:
    return True
