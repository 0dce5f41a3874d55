"""Bringing the arms to their postures for driving, out of wherever an action was broken off."""

import numpy as np
from numpy.typing import NDArray

from attune.core.clock import Clock
from attune.robots.interface import ARMS, Arm, Collision, Unreachable
from attune.robots.mujoco.arcs import HANDLE_GAP
from attune.robots.mujoco.beliefs import Beliefs
from attune.robots.mujoco.carry import carrying_path, folding_path, is_carrying, is_folded, is_out_of_the_way
from attune.robots.mujoco.escape import escape_path, steps_away
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.motions import BASE_LIMITS, Motions
from attune.robots.mujoco.trajectory import plan_trajectory
from attune.robots.mujoco.whole_motions import radius
from attune.robots.mujoco.world import World

Array = NDArray[np.float64]

_TRIES = 3
"""Searches for a path from one posture."""
_BACK_STEPS = 6
"""Postures on the way back from which a path is searched."""
_SLOW = 0.5
"""Share of the usual speed near what was touched."""

_ROOM = 0.01
"""Kept in addition from everything by an empty arm, if possible [m]."""


class Folding:
    """Folds empty arms and brings carried objects close to the body.

    It works from any posture, also while the robot touches what it should not: straight out, back along the way that
    the arm came, or with the base drawing back first.

    Args:
        world: Measures what is held and touched.
        motions: Moves arms and base.
        beliefs: The imagined worlds.
        clock: For planning off the event loop.
        rng: For the searches.
    """

    def __init__(
        self, world: World, motions: Motions, beliefs: Beliefs, clock: Clock, rng: np.random.Generator
    ) -> None:
        self._world = world
        self._motions = motions
        self._beliefs = beliefs
        self._clock = clock
        self._rng = rng
        self._graspable = (*world.object_names, *(box.name for box in world.scene.containers))

    async def fold_all(self) -> None:
        """Fold both arms, and let the base leave what it touches."""
        for arm in ARMS:
            await self.fold(arm)
        if self._world.forbidden_contacts():
            await self._step_away()

    async def fold(self, arm: Arm) -> None:
        """Bring an arm to the posture for driving: folded, or carrying upright.

        Raises:
            Unreachable: No free path was found.
            Collision: The arm touched something new on each way that was found.
        """
        if self._world.gripped_handle(arm) is not None:
            with self._motions.leaving_contacts():
                await self._motions.fingers(arm, HANDLE_GAP)
        if self._is_done(arm):
            return
        touching = bool(self._world.forbidden_contacts())
        # What the arm touches was in its way, so the way back is the surest; else the shortest way out is.
        ways = (self._back, self._straight_out) if touching else (self._straight_out, self._back)
        failure: Unreachable | Collision | None = None
        for step_first in (False, True):
            if step_first and not await self._step_away():
                break
            for way in ways:
                try:
                    if await way(arm):
                        self._motions.forget_way(arm)
                        return
                except Collision as met:
                    failure = met
        raise failure or Unreachable(f"the posture for driving of the {arm} arm", "no free path was found")

    def _is_done(self, arm: Arm) -> bool:
        world = self._beliefs.imagine()
        return is_carrying(world, arm) if arm in self._beliefs.held else is_out_of_the_way(world, arm)

    async def _straight_out(self, arm: Arm) -> bool:
        """A short straight move of the hand into the open, and a path from there; whether there is one."""
        world = self._beliefs.imagine()

        def search() -> tuple[Array, Array] | None:
            out = escape_path(world, arm)
            path = None if out is None else self._path(world, arm, out[-1])
            return None if out is None or path is None else (out, path)

        return await self._go(arm, await self._clock.run_in_thread(search))

    async def _back(self, arm: Arm) -> bool:
        """Back along the way that the arm came, until a path leads on from there; whether there is one."""
        world, way = self._beliefs.imagine(), self._motions.way_back(arm)

        def search() -> tuple[Array, Array] | None:
            free = [index for index in range(1, len(way)) if world.all_free(arm, way[index : index + 1])]
            for index in free[:: max(1, len(free) // _BACK_STEPS)]:
                path = self._path(world, arm, way[index])
                if path is not None:
                    return way[: index + 1], path
            return (way, way[-1:]) if arm not in self._beliefs.held and is_folded(world, arm, way[-1]) else None

        return await self._go(arm, await self._clock.run_in_thread(search))

    async def _go(self, arm: Arm, paths: tuple[Array, Array] | None) -> bool:
        if paths is None:
            return False
        if arm not in self._beliefs.held:
            self._world.permit(arm, self._graspable)
        try:
            with self._motions.leaving_contacts():
                await self._motions.bend(arm, paths[0], _SLOW)
        finally:
            self._world.permit(arm, ())
        await self._motions.bend(arm, paths[1])
        return True

    def _path(self, world: Imagination, arm: Arm, start: Array) -> Array | None:
        held = self._beliefs.held.get(arm)
        if held is None:
            with world.roomier(arm, _ROOM):  # Beside a door that was just let go there may be more room, or none.
                world.set_arm(arm, start)
                path = folding_path(world, arm, self._rng, start) if world.free() else None
            if path is not None:
                return path
        for _ in range(_TRIES):
            path = (
                folding_path(world, arm, self._rng, start)
                if held is None
                else carrying_path(world, arm, start, radius(held.percept), self._rng)
            )
            if path is not None:
                return path
        return None

    async def _step_away(self) -> bool:
        """Drive a little aside so that the robot touches nothing; whether there is a way."""
        world = self._beliefs.imagine()
        now = self._motions.base
        path = await self._clock.run_in_thread(lambda: steps_away(world, now))
        if path is None:
            return False
        with self._motions.leaving_contacts():
            await self._motions.drive(plan_trajectory(path, BASE_LIMITS.scaled(_SLOW)))
        return True
