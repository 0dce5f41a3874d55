"""Picking up and putting down, as sequences of planned motions."""

import math
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TypeVar

import anyio
import numpy as np
from numpy.typing import NDArray

from attune.core.clock import Clock
from attune.robots.interface import (
    Arm,
    GraspMissed,
    ObjectLost,
    Percept,
    PlacementFailed,
    Point,
    Unreachable,
)
from attune.robots.mujoco import pr2
from attune.robots.mujoco.beliefs import Beliefs, Held
from attune.robots.mujoco.crowding import TOUCHING, crowding
from attune.robots.mujoco.folding import Folding
from attune.robots.mujoco.frames import Frame, frame_of, pose_of
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.motions import Motions, together
from attune.robots.mujoco.repeating import repeated
from attune.robots.mujoco.stepwise import results
from attune.robots.mujoco.straighten import ASKEW, straightening_path, tilt
from attune.robots.mujoco.whole_motions import (
    PLACING,
    Pick,
    Place,
    find_picks,
    find_places,
    manners,
)
from attune.robots.mujoco.world import World

Array = NDArray[np.float64]
M = TypeVar("M", Pick, Place)

_SLOW = 0.5
"""Share of the usual speed near objects."""
_CLOSING = 2.5
"""Longest time for which the closing of the fingers is shielded from cancellation [s]."""
_PRESSING = 0.4
"""Longest wait for both pads to press [s]."""
_MISPLACED = 0.04
"""Farther than this from where it should stand, a placement has failed [m]."""
_ASIDE = (0.3, -0.3, 0.0)
"""Where the robot looks before it puts something down, to the left of the place [m]."""
_SHIFTED = 0.01
"""Farther than this from where it was thought to be in the hand, an object is seen to have moved [m]."""
_COMPARED = 5
"""Motions that are compared, if things are near."""
_TILTED = np.cos(np.radians(20.0))


class Manipulation:
    """Moves objects with the arms.

    Args:
        world: Measures what the fingers hold.
        motions: Moves the arms.
        folding: Folds them before.
        beliefs: What is where; changed when something is grasped or released.
        clock: For planning off the event loop.
        look: Looks at a point and gives what is seen there.
        rng: For the searches.
    """

    def __init__(
        self,
        world: World,
        motions: Motions,
        folding: Folding,
        beliefs: Beliefs,
        clock: Clock,
        look: Callable[[Point], Awaitable[tuple[Percept, ...]]],
        rng: np.random.Generator,
    ) -> None:
        self._world = world
        self._motions = motions
        self._folding = folding
        self._beliefs = beliefs
        self._clock = clock
        self._look = look
        self._rng = rng
        self.closing = False
        """Whether fingers close on something, shielded from cancellation."""

    async def pick(
        self, percept: Percept, arms: tuple[Arm, ...], pitch: float | None = None, known: Pick | None = None
    ) -> Arm:
        """Grasp, lift and take to a posture for driving. See `Robot.pick`.

        Args:
            percept: The object.
            arms: With which it may be taken.
            pitch: How steeply the hand should come down, if that matters [rad].
            known: A motion that was found for about here, if it was hard to find.
        """
        for arm in self._beliefs.free_arms:  # Plans start from a known, free posture, and leave room for the other.
            await self._folding.fold(arm)
        chosen = await self._repeat(percept, arms, known) or await self._plan_pick(percept, arms, pitch)
        plan, arm = chosen.plan, chosen.plan.arm
        self._motions.forget_way(arm)
        self._world.permit(arm, (percept.name,))
        try:
            await together(self._motions.fingers(arm, pr2.GRIPPER_OPEN), self._motions.bend(arm, chosen.reach))
            await self._motions.bend(arm, plan.approach, _SLOW)
            await self._grasp(arm, percept, plan.in_hand)
            if self._world.held(arm) is None:
                await self._motions.fingers(arm, pr2.GRIPPER_OPEN)
                await self._motions.bend(arm, np.concatenate((plan.approach[::-1], chosen.reach[::-1])), _SLOW)
                raise GraspMissed(percept.name, arm)
        finally:
            self._world.permit(arm, ())
        await self._motions.bend(arm, plan.lift, _SLOW)
        if await self._see_in_hand(arm):
            await self._motions.bend(arm, chosen.carry)
        else:
            await self._folding.fold(arm)
        return arm

    async def _survey(self, position: Point) -> None:
        """Look around a point, so that what stands near it is known."""
        base = self._motions.base
        for aside in _ASIDE:
            x, y = position[0] - aside * np.sin(base.yaw), position[1] + aside * np.cos(base.yaw)
            await self._look((float(x), float(y), position[2]))

    async def _see_in_hand(self, arm: Arm) -> bool:
        """Look how the object lies in the hand, and turn the hand till it is upright; whether all is as thought.

        It need not be visible: close to the head nothing is.
        """
        held, world = self._beliefs.held[arm], self._beliefs.imagine()
        x, y, z = (float(v) for v in world.carried_frame(arm).position)
        for seen in await self._look((x, y, z + held.percept.extent[2] / 2)):
            if seen.name == held.percept.name:
                in_hand = self._beliefs.imagine().tool(arm).inverse() @ frame_of(seen.pose)
                if not _alike(in_hand, held.in_hand):
                    self._beliefs.grasped(arm, held.percept, in_hand)
                    await self._straighten(arm)
                    return False
        return True

    async def _straighten(self, arm: Arm) -> None:
        held, world = self._beliefs.held[arm], self._beliefs.imagine()
        if tilt(world, arm, held)[0] > ASKEW:
            path = await self._clock.run_in_thread(lambda: straightening_path(world, arm, held, self._rng))
            if path is not None:
                await self._motions.bend(arm, path, _SLOW)

    async def place(self, arm: Arm, position: Point) -> None:
        """Put down, let go, draw back, verify. See `Robot.place`."""
        held = self._beliefs.held.get(arm)
        if held is None or self._world.held(arm) is None:
            self._beliefs.released(arm)
            raise ObjectLost(held.percept.name if held else "the object", arm)
        name = held.percept.name
        await self._survey(position)
        chosen = await self._plan_place(arm, held, position)
        await self._motions.bend(arm, chosen.reach)
        if not await self._see_in_hand(arm):  # It has moved in the hand on the way.
            chosen = await self._plan_place(arm, self._beliefs.held[arm], position)
            await self._motions.bend(arm, chosen.reach)
        plan = chosen.plan
        self._world.lower(arm)
        try:
            await self._motions.bend(arm, plan.lower, _SLOW)
            if self._world.held(arm) is None:
                self._beliefs.released(arm)
                raise ObjectLost(name, arm)
            self._world.permit(arm, (name,))
            await self._release(arm, plan.placed)
            await self._motions.bend(arm, plan.retreat, _SLOW)
        finally:
            self._world.lower(None)
            self._world.permit(arm, ())
        await self._motions.bend(arm, chosen.fold)
        await self._verify(name, position)

    async def _repeat(self, percept: Percept, arms: tuple[Arm, ...], known: Pick | None) -> Pick | None:
        if known is None or known.plan.arm not in arms:
            return None
        world = self._beliefs.imagine()
        carrying = self._beliefs.imagine(grasping=(known.plan.arm, percept.name))
        return await self._clock.run_in_thread(lambda: repeated(world, carrying, percept, known))

    async def _plan_pick(self, percept: Percept, arms: tuple[Arm, ...], pitch: float | None) -> Pick:
        for manner in manners(pitch):
            for arm in arms:
                world, carrying = self._beliefs.imagine(), self._beliefs.imagine(grasping=(arm, percept.name))
                posture = world.arm(arm)
                search = find_picks(world, carrying, percept, arm, posture, self._rng, pitch=pitch, manner=manner)
                if chosen := await self._roomiest(search, world, carrying, percept.name):
                    return chosen
        raise Unreachable(percept.name, "no grasp was found that is free of collisions")

    async def _plan_place(self, arm: Arm, held: Held, position: Point) -> Place:
        world, carrying = self._beliefs.imagine(empty=arm), self._beliefs.imagine()
        posture = carrying.arm(arm)
        for manner in PLACING:
            search = find_places(world, carrying, held, arm, position, posture, self._rng, manner=manner)
            if chosen := await self._roomiest(search, world, carrying, held.percept.name):
                return chosen
        raise Unreachable(f"the place for {held.percept.name}", "no way of putting it down was found")

    async def _roomiest(
        self, search: Iterator[M | None], world: Imagination, carrying: Imagination, name: str
    ) -> M | None:
        """Of the first motions that a search finds, the one that keeps away from things at the most of its points."""
        best: M | None = None
        least, compared = math.inf, 0
        async for motion in results(self._clock, search):
            compare = partial(crowding, world, carrying, name, motion, least)
            crowded = await self._clock.run_in_thread(compare)
            if crowded < least:
                best, least = motion, crowded
            compared += 1
            if not least or (compared >= _COMPARED and least < TOUCHING):
                break
        return best

    async def _grasp(self, arm: Arm, percept: Percept, in_hand: Frame) -> None:
        """Close the fingers; shielded from cancellation for `_CLOSING` + `_PRESSING` seconds at most."""
        with anyio.CancelScope(shield=True):
            self.closing = True
            with anyio.move_on_after(_CLOSING):
                await self._motions.fingers(arm, pr2.GRIPPER_CLOSED)
            await self._motions.wait_until(lambda: self._world.held(arm) is not None, _PRESSING)
            self.closing = False
            if self._world.held(arm) is not None:
                self._beliefs.grasped(arm, percept, in_hand)
                self._motions.forget_way(arm)

    async def _release(self, arm: Arm, placed: Frame) -> None:
        """Open the fingers; from the first moment of this on the object is free, cancelled or not."""
        held = self._beliefs.held[arm]
        self._beliefs.released(arm)
        self._beliefs.notice([_at(held.percept, placed)])
        self._motions.forget_way(arm)
        await self._motions.fingers(arm, pr2.GRIPPER_OPEN)

    async def _verify(self, name: str, position: Point) -> None:
        middle = (position[0], position[1], position[2] + self._beliefs.seen[name].extent[2] / 2)
        for _ in range(2):
            seen = next((percept for percept in await self._look(middle) if percept.name == name), None)
            if seen is not None:
                break
        else:
            raise PlacementFailed(name, "it is not to be seen where it should stand")
        away = float(np.linalg.norm(np.array(seen.pose.position) - position))
        if away > _MISPLACED:
            raise PlacementFailed(name, f"it stands {away:.2f} m from where it should")
        if frame_of(seen.pose).rotation[2, 2] < _TILTED:
            raise PlacementFailed(name, "it has fallen over")


def _alike(first: Frame, second: Frame) -> bool:
    """Whether two poses differ by no more than a look may err."""
    turn = (np.trace(first.rotation.T @ second.rotation) - 1) / 2
    return bool(np.linalg.norm(first.position - second.position) < _SHIFTED and turn > np.cos(ASKEW))


def _at(percept: Percept, frame: Frame) -> Percept:
    """The percept, standing somewhere else."""
    return replace(percept, pose=pose_of(frame), place="")
