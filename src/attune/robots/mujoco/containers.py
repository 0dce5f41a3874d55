"""Opening and closing doors and drawers by their handles."""

from contextlib import suppress
from itertools import product

import anyio
import numpy as np

from attune.core.clock import Clock
from attune.core.furniture import Container
from attune.robots.interface import Arm, Collision, ContainerStuck, Unreachable
from attune.robots.mujoco import pr2
from attune.robots.mujoco.arcs import HANDLE_GAP, ROOMS, Arc, find_arcs, handle_ways
from attune.robots.mujoco.beliefs import Beliefs
from attune.robots.mujoco.folding import Folding
from attune.robots.mujoco.motions import Motions, together
from attune.robots.mujoco.stepwise import results
from attune.robots.mujoco.world import World

_SLOW = 0.5
_SWING = 0.35
"""Share of the usual speed at which a door is moved."""
_OPEN_SHARE = 0.9
"""Of the way that must have been made."""
_CLOSED = 0.05
"""A container nearer than this to closed is closed [m or rad]."""
_GRIPPING = 0.5
"""Longest wait for both pads to press the handle [s]."""
_CLOSING = 2.5
"""Longest time for which the closing of the fingers is shielded from cancellation [s]."""


class Containers:
    """Moves doors and drawers.

    Args:
        world: Measures the container's position and what the fingers grip.
        motions: Moves the arms.
        folding: Folds them.
        beliefs: The imagined worlds, and which arms are free.
        clock: For planning off the event loop.
        rng: For the searches.
    """

    def __init__(
        self,
        world: World,
        motions: Motions,
        folding: Folding,
        beliefs: Beliefs,
        clock: Clock,
        rng: np.random.Generator,
    ) -> None:
        self._world = world
        self._motions = motions
        self._folding = folding
        self._beliefs = beliefs
        self._clock = clock
        self._rng = rng

    def position(self, container: Container) -> float:
        """How far it is open [m or rad]."""
        return self._world.container_position(container.name)

    def is_open(self, container: Container) -> bool:
        """Whether it is as far open as is needed to use it."""
        return self.position(container) > _OPEN_SHARE * container.opened

    def is_closed(self, container: Container) -> bool:
        """Whether it is closed."""
        return self.position(container) < _CLOSED

    async def move(self, container: Container, position: float) -> None:
        """Bring a container to a position [m or rad] with a free arm. See `Robot.open`.

        Cancelled on the way, the door stays where it is, the hand on its handle; folding the arm lets go of it.
        """
        arc = await self._plan(container, position)
        arm = arc.arm
        start = self.position(container)
        self._world.permit(arm, (container.name,))
        met: Collision | None = None
        try:
            await together(self._motions.fingers(arm, HANDLE_GAP), self._motions.bend(arm, arc.reach))
            await self._motions.bend(arm, arc.approach, _SLOW)
            await self._grip(arm, container)
            self._motions.forget_way(arm)
            await self._motions.bend(arm, arc.swing, _SWING)
            self._motions.forget_way(arm)
            await self._motions.fingers(arm, HANDLE_GAP)
            await self._motions.bend(arm, arc.retreat, _SLOW)
        except Collision as failure:
            met = failure
            await self._take_back(arm, arc)
        finally:
            self._world.permit(arm, ())
        # A door may go on by itself when it is let go, so the way back is planned now.
        await self._folding.fold(arm)
        if met is not None:
            raise ContainerStuck(container.name, str(met))
        moved = abs(self.position(container) - start)
        if moved < _OPEN_SHARE * abs(position - start):
            raise ContainerStuck(container.name, f"it moved {moved:.2f} of {abs(position - start):.2f}")

    async def _take_back(self, arm: Arm, arc: Arc) -> None:
        """After a collision on the handle's way: back to where it began, the hand on the handle, and let go there."""
        if self._world.gripped_handle(arm) is None:
            return
        with suppress(Collision):
            with self._motions.leaving_contacts():
                await self._motions.bend(arm, self._motions.way_back(arm), _SWING)
            await self._motions.fingers(arm, HANDLE_GAP)
            await self._motions.bend(arm, arc.approach[::-1], _SLOW)

    async def _grip(self, arm: Arm, container: Container) -> None:
        """Close the fingers on the handle; shielded from cancellation for `_CLOSING` + `_GRIPPING` seconds at most."""
        with anyio.CancelScope(shield=True):
            with anyio.move_on_after(_CLOSING):
                await self._motions.fingers(arm, pr2.GRIPPER_CLOSED)
            await self._motions.wait_until(lambda: self._world.gripped_handle(arm) is not None, _GRIPPING)
        if self._world.gripped_handle(arm) != container.name:
            await self._motions.fingers(arm, HANDLE_GAP)
            await self._folding.fold(arm)
            raise ContainerStuck(container.name, "the handle was missed")

    async def _plan(self, container: Container, position: float) -> Arc:
        for arm in self._beliefs.free_arms:
            await self._folding.fold(arm)
        span = (self.position(container), position)
        for room, arm in product(ROOMS, self._beliefs.free_arms):
            world = self._beliefs.imagine(without_content=container.name)
            ways = handle_ways(world, container.name, *span)
            search = find_arcs(world, arm, container.name, ways, span, world.arm(arm), self._rng, room)
            async for arc in results(self._clock, search):
                return arc
        raise Unreachable(f"the handle of {container.name}", "no way of moving it was found")
