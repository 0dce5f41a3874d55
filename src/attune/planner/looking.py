"""Looking for things, and seeing them again, as parts of a plan."""

import math
from collections.abc import Callable

from attune.core.clock import Clock
from attune.core.scene import Scene, Surface
from attune.planner.belief import Belief, Individual
from attune.planner.designators import look_points, middle
from attune.planner.hidden import Hidden
from attune.planner.moving import Moving
from attune.planner.plan import Node, Part
from attune.planner.state import StateBoard
from attune.robots.interface import LookTarget, ObjectNotThere, PathBlocked, Percept, Point, Robot, Unreachable

NEAR = 0.8
"""From the robot to the floor that it looks at after a collision [m]."""
AROUND = (-1.75, -0.9, 0.0, 0.9, 1.75)
"""Directions in which it looks there [rad]."""
VIEWS = 5
"""Sides from which a surface is looked over before a thing counts as missing there."""


class Looking(Moving):
    """Makes parts that look at things and keep the belief up to date."""

    def __init__(self, robot: Robot, scene: Scene, clock: Clock, belief: Belief, board: StateBoard) -> None:
        super().__init__(robot, scene, clock, belief, board)
        self._hidden: dict[str, Hidden] = {}

    def look_over(
        self, surface: Surface, found: Callable[[Individual], bool], *, again: bool = False
    ) -> Part[Individual | None]:
        """Look over a whole surface until something fits `found`; what is missing there is noted.

        Where something is expected that is not seen, what is hidden from one side is looked at from another.

        Args:
            surface: Where to look.
            found: Whether this is what is looked for.
            again: It was looked over before: only what could not be seen then is looked at.

        Returns:
            A part whose value is what was found, or None.
        """
        seen: dict[str, Individual] = {}
        gone: set[str] = set()
        if not again or surface.name not in self._hidden:
            self._hidden[surface.name] = Hidden(self.robot, surface)
        hidden = self._hidden[surface.name]

        def all_seen() -> bool:
            return not again and all(item.name in seen for item in self.belief.on(surface.name))

        def look(points: tuple[Point, ...]) -> Part[Individual | None]:
            async def body(_: Node) -> Individual | None:
                self.board.update()
                for point in points:
                    for _attempt in range(2):  # A camera may miss what is there.
                        await self.robot.look_at(point)
                        now = self.belief.observe(await self.robot.perceive())
                        hidden.looked(self.belief.on(surface.name))
                        seen.update((item.name, item) for item in now)
                        gone.update(item.name for item in self.belief.on(surface.name) if self._is_seen_empty(item))
                        fitting = [item for item in now if found(item)]
                        if fitting:
                            return fitting[0]
                        if all_seen():
                            break
                return None

            return Part("look", body)

        def view(target: LookTarget, points: tuple[Point, ...]) -> Part[Individual | None]:
            there, container = look(points), surface.container
            return self.at_base_pose("look there", target, there, surface.place, what=surface.name, keep_open=container)

        async def body(node: Node) -> Individual | None:
            if surface.container:
                await node.do(self.open_for(surface))
            fitting = None if again else await node.do(view(LookTarget(middle(surface)), look_points(surface)))
            points: tuple[Point, ...] = ()
            for _ in range(VIEWS - 1):
                before, points = points, hidden.points(self.belief.on(surface.name))
                if fitting or all_seen() or not points or points == before:
                    break
                try:
                    fitting = await node.do(view(LookTarget(points[0], points), points[:1]))
                except (Unreachable, PathBlocked):
                    break  # It cannot be seen from anywhere.
            if not fitting and not all_seen():
                kept = (item for item in self.belief.on(surface.name) if item.name not in gone)
                self.belief.missing(surface.name, (*seen.values(), *(item for item in kept if again or item.position)))
            return fitting

        return Part(f"look over {surface.name}", body)

    def hiders(self) -> dict[str, Individual]:
        """Surfaces that were looked over on which something may be hidden behind an object, and that object."""
        behind = {name: hidden.behind(self.belief.on(name)) for name, hidden in self._hidden.items()}
        return {name: item for name, item in behind.items() if item}

    def glance(self, surface: Surface) -> Part[None]:
        """Look over a surface from where the robot stands."""

        async def body(_: Node) -> None:
            for point in look_points(surface):
                await self.robot.look_at(point)
                self.belief.observe(await self.robot.perceive())

        return Part(f"glance at {surface.name}", body)

    def look_around(self) -> Part[None]:
        """Look at the floor around the robot, and take in what lies there."""

        async def body(_: Node) -> None:
            base = self.robot.status().base
            for turn in AROUND:
                x, y = base.x + NEAR * math.cos(base.yaw + turn), base.y + NEAR * math.sin(base.yaw + turn)
                await self.robot.look_at((x, y, 0.0))
                self.belief.observe(await self.robot.perceive())

        return Part("look around", body)

    def look_again(self, item: Individual, percept: Percept) -> Part[Percept]:
        """See an object again from where the robot stands now; if it is hidden from there, it is where it was."""

        async def body(_: Node) -> Percept:
            self.board.update()
            for _attempt in range(2):
                await self.robot.look_at(percept.pose.position)
                seen = await self.robot.perceive()
                self.belief.observe(seen)
                for again in seen:
                    if again.name == item.name:
                        return again
            if self._is_seen_empty(item):
                raise ObjectNotThere(item.name)
            return percept

        return Part("look again", body)

    def _is_seen_empty(self, item: Individual) -> bool:
        """Whether the place where an object was is seen now; if the object is not, it has gone."""
        if item.position is None:
            return False
        x, y, z = item.position
        return self.robot.sees([(x, y, z + item.extent[2] / 2)])[0]
