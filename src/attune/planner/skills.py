"""What the robot can do with its hands, as parts of a plan that publish the state before anything moves."""

from typing import TypeVar

from attune.core.clock import Clock
from attune.core.scene import Scene
from attune.planner.belief import Belief, Individual
from attune.planner.combinators import atomic_while
from attune.planner.designators import Spot, is_clear, is_crowded, look_points
from attune.planner.looking import Looking
from attune.planner.plan import Node, Part
from attune.planner.state import StateBoard
from attune.robots.interface import Arm, ObjectNotThere, PickTarget, PlaceTarget, Point, Robot, Unreachable

T = TypeVar("T")


class Skills(Looking):
    """Makes parts that move the robot and keep belief and state up to date."""

    def __init__(self, robot: Robot, scene: Scene, clock: Clock, belief: Belief, board: StateBoard) -> None:
        super().__init__(robot, scene, clock, belief, board)
        self.placing: Spot | None = None
        """Where something is being put down at this moment."""

    def reconcile(self) -> None:
        """After an interruption: believe of the grippers what the robot says."""
        where = self.placing
        self.belief.reconcile(
            self.robot.status().holding, where.surface.name if where else "", where.position if where else None
        )

    def pick(self, item: Individual, arm: Arm | None, goal: Point | None) -> Part[None]:
        """Open what it is in, drive there, look again, and take it so that it can be put at `goal`.

        Args:
            item: What.
            arm: With which arm if possible; None for any.
            goal: Where it will be put, map frame [m].
        """
        percept = item.percept
        if percept is None:
            raise ObjectNotThere(item.name)
        surface = self.scene.surface(item.surface) if item.surface else None
        place = surface.place if surface else ""
        container = surface.container if surface else ""

        def take(wanted: Arm | None) -> Part[None]:
            async def grasp(node: Node) -> None:
                now = await node.do(self.look_again(item, percept))
                async with self.moving(arm=True):
                    used = await self.robot.pick(now, wanted, goal)
                self.belief.taken(item.name, used)

            target, act = PickTarget(percept, goal, wanted), self._with_fingers(Part("grasp", grasp))
            name = f"take it with the {wanted} hand" if wanted else "take it"
            return self.at_base_pose(name, target, act, place, what=item.name, keep_open=container)

        async def body(node: Node) -> None:
            if surface and surface.container:
                await node.do(self.open_for(surface))
            try:
                await node.do(take(arm))
            except Unreachable:
                if arm is None:
                    raise
                await node.do(take(None))

        return Part(f"pick up {item.name}", body)

    def place(self, item: Individual, arm: Arm, spot: Spot) -> Part[None]:
        """Open what it goes into, drive there, look whether the spot is free, and put it down."""
        surface = spot.surface

        async def put(_: Node) -> None:
            self.board.update()
            await self.robot.look_at(spot.position)
            self.belief.observe(await self.robot.perceive())
            close = spot.tight or spot.position == item.home.position
            if not is_clear(self.belief, spot, item) or (not close and is_crowded(self.belief, spot, item)):
                raise Unreachable("the spot", "something stands there")
            self.placing = spot
            try:
                async with self.moving(arm=True):
                    await self.robot.place(arm, spot.position)
            except Unreachable:
                await self._look_around(spot)  # What is in the way must be known when the next spot is chosen.
                raise
            self.belief.put(item.name, surface.name, spot.position)

        async def body(node: Node) -> None:
            if surface.container:
                await node.do(self.open_for(surface))
            self.placing = None
            target = PlaceTarget(arm, spot.position)
            act, container = self._with_fingers(Part("put down", put)), surface.container
            what = f"a spot for {item.name} on {surface.name}"
            await node.do(self.at_base_pose("put it down", target, act, surface.place, what=what, keep_open=container))

        return Part(f"put {item.name} on {surface.name}", body)

    async def _look_around(self, spot: Spot) -> None:
        for point in (spot.position, *look_points(spot.surface)):
            await self.robot.look_at(point)
            self.belief.observe(await self.robot.perceive())

    def _with_fingers(self, part: Part[T]) -> Part[T]:
        """While the fingers close or open, a minor interruption waits for the end of that."""
        return atomic_while(part, lambda: self.robot.status().atomic, self.clock)
