"""Where the PR2 should stand for what it is to do."""

import math
from collections import Counter
from collections.abc import Collection, Iterator, Sequence

import numpy as np

from attune.core.clock import Clock
from attune.core.furniture import Container, Surface
from attune.core.scene import Scene
from attune.robots.interface import (
    Arm,
    BasePose,
    LookTarget,
    OpenTarget,
    Percept,
    PickTarget,
    PlaceTarget,
    Point,
    Target,
    UnknownTarget,
)
from attune.robots.mujoco.beliefs import Beliefs
from attune.robots.mujoco.carry import fold
from attune.robots.mujoco.containers import Containers
from attune.robots.mujoco.costmap import Costmap, footprint
from attune.robots.mujoco.driving import Driving, find_way
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.look_poses import look_poses
from attune.robots.mujoco.motions import Motions
from attune.robots.mujoco.reach import handle_poses, pick_poses, place_poses
from attune.robots.mujoco.stepwise import results
from attune.robots.mujoco.whole_motions import Pick

_VIEWS = 2
"""Base poses to look from that a search gives; of others one: after a failure, the next search knows more."""
_ALONE = 0.3
"""What stands so far from an object is hardly in the way of it [m]."""
_QUICK = 2
"""Searches in vain for what stands near other things before one is thorough: these may be moved aside first."""
_THOROUGH = 3
"""Thorough searches for the same object before it counts as out of reach."""
_SAME = 0.02
"""Base poses nearer to each other are the same [m or rad]."""
_CUT_OFF = 6
"""Base poses without a way to them after which a search is given up."""


class Searching:
    """Searches base poses.

    Args:
        scene: The kitchen.
        motions: Know where the base is.
        beliefs: The imagined worlds, and which arms are free.
        driving: Knows the floor, and ways over it.
        containers: Know how far doors and drawers are open.
        clock: For searching off the event loop.
        rng: Seeds each search.
    """

    def __init__(
        self,
        scene: Scene,
        motions: Motions,
        beliefs: Beliefs,
        driving: Driving,
        containers: Containers,
        clock: Clock,
        rng: np.random.Generator,
    ) -> None:
        self._scene = scene
        self._motions = motions
        self._beliefs = beliefs
        self._driving = driving
        self._containers = containers
        self._clock = clock
        self._rng = rng
        self._sought = ""
        """The object that was last searched for to be taken."""
        self._proofs: dict[BasePose, Pick] = {}
        """How it can be taken from base poses that only a thorough search has found."""
        self._in_vain: Counter[str] = Counter()
        """Searches for ways to take an object, with any arm, that have found nothing since the last that did."""

    async def base_poses(self, target: Target) -> Sequence[BasePose]:
        """See `Robot.base_poses`."""
        self._beliefs.feel_hands()
        costmap, body = await self._driving.floor()
        search = self._search(target, costmap)
        if search is None:
            return ()
        wanted = _VIEWS if isinstance(target, LookTarget) else 1
        world, now = self._beliefs.imagine(), self._motions.base
        found: list[BasePose] = []
        cut_off = 0
        async for pose in results(self._clock, search):
            way = await self._clock.run_in_thread(
                lambda: find_way(world, costmap, body, now, pose)  # noqa: B023
            )
            if way is not None:
                found.append(pose)
            else:
                cut_off += 1
            if len(found) == wanted or cut_off == _CUT_OFF:
                break
        match target:
            case PickTarget(percept, _, None, ()):
                self._in_vain[percept.name] = 0 if found else self._in_vain[percept.name] + 1
        return tuple(found)

    def _search(self, target: Target, costmap: Costmap) -> Iterator[BasePose | None] | None:
        """The search for a target's base poses; None when no arm is free for it, or the arm is empty."""
        rng = np.random.default_rng(int(self._rng.integers(2**31)))
        match target:
            case PickTarget(percept, goal, wanted, without):
                worlds = {
                    arm: (self._folded(without=without), self._folded(grasping=(arm, percept.name), without=without))
                    for arm in self._beliefs.free_arms
                    if wanted in (arm, None)
                }
                body = footprint(self._folded().body_solids())
                if not worlds:
                    return None
                # What would be possible without other objects is asked of many sets of them: that must be quick.
                thorough = wanted is None and not without and self._should_be_thorough(percept)
                self._sought = percept.name
                self._proofs.clear()
                return pick_poses(
                    worlds, costmap, body, percept, rng, self.pitch_for(goal), thorough=thorough, proofs=self._proofs
                )
            case PlaceTarget(arm, position):
                held = self._beliefs.held.get(arm)
                if held is None:
                    return None
                pair = (self._beliefs.imagine(empty=arm), self._beliefs.imagine())
                body = footprint(pair[1].body_solids())
                return place_poses(pair, costmap, body, arm, held, position, rng)
            case LookTarget(point, hidden):
                world = self._beliefs.imagine()
                return look_poses(world, costmap, footprint(world.body_solids()), point, rng, hidden)
            case OpenTarget(name):
                return self._search_handle(self.container(name), costmap, rng)

    def _should_be_thorough(self, percept: Percept) -> bool:
        """Whether to search for long: soon for what stands alone; of other things something may be in the way."""
        in_vain = self._in_vain[percept.name]
        x, y, z = percept.pose.position
        alone = all(
            name == percept.name or math.dist(other.pose.position, (x, y, z)) > _ALONE
            for name, other in self._beliefs.seen.items()
        )
        return in_vain < _THOROUGH if alone else _QUICK <= in_vain < _QUICK + _THOROUGH

    def proof(self, percept: Percept) -> Pick | None:
        """How an object can be taken from where the robot stands, if only a thorough search has found that."""
        now = self._motions.base
        if percept.name != self._sought:
            return None
        for pose, motion in self._proofs.items():
            turn = math.remainder(pose.yaw - now.yaw, math.tau)
            if math.hypot(pose.x - now.x, pose.y - now.y) < _SAME and abs(turn) < _SAME:
                return motion
        return None

    def _search_handle(
        self, box: Container, costmap: Costmap, rng: np.random.Generator
    ) -> Iterator[BasePose | None] | None:
        goal = 0.0 if self._containers.is_open(box) else box.opened
        span = (self._containers.position(box), goal)
        body = footprint(self._folded().body_solids())
        worlds = {arm: self._folded(without_content=box.name) for arm in self._beliefs.free_arms}
        return handle_poses(worlds, costmap, body, box.name, span, rng) if worlds else None

    def pitch_for(self, goal: Point | None) -> float | None:
        """How steeply the hand should hold what goes there: level under a board, fingers down between walls [rad]."""
        if goal is None:
            return None
        near = min(self._scene.surfaces, key=lambda surface: _distance(surface, goal))
        if np.isfinite(near.clearance):
            return 0.0
        return np.pi / 2 if np.isfinite(near.headroom) else None

    def _folded(
        self,
        *,
        grasping: tuple[Arm, str] | None = None,
        without_content: str = "",
        without: Collection[str] = (),
    ) -> Imagination:
        """The kitchen as believed, with the free arms folded, as they are before an arm action."""
        world = self._beliefs.imagine(without_content=without_content, without=without)
        for arm in self._beliefs.free_arms:
            fold(world, arm)
        if grasping is None:
            return world
        grasped = self._beliefs.imagine(grasping=grasping, without=without)
        for arm in self._beliefs.free_arms:
            grasped.set_arm(arm, world.arm(arm))
        return grasped

    def container(self, name: str) -> Container:
        """The container of this name.

        Raises:
            UnknownTarget: There is none.
        """
        for container in self._scene.containers:
            if container.name == name:
                return container
        raise UnknownTarget("container", name, [box.name for box in self._scene.containers])


def _distance(surface: Surface, point: Point) -> float:
    """From the middle of a surface as it is used to a point [m]."""
    return float(np.linalg.norm(np.array(surface.center) + surface.shift - point))
