"""How much room a whole motion of an arm leaves around it, and what it carries around the robot."""

import math

from attune.robots.mujoco import pr2
from attune.robots.mujoco.carry import COMPACT, is_carrying
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.reaching import finer
from attune.robots.mujoco.whole_motions import Pick, Place

_ROOM = 0.01
"""An arm should keep so much more distance than it must [m]: motors follow a path to within some millimetres."""
_BETWEEN = 0.025
"""Between the points that are looked at for that [rad]."""
TOUCHING = 100
"""Weight of a point at which something is not even as far away as it must be."""
_WIDE = 1000
"""Weight of carrying something far from the body."""
_NEAR = 3
"""Points of the straight part at the object, at which that does not count."""


def is_compact(carrying: Imagination, motion: Pick) -> bool:
    """Whether what was picked up is then held close enough to the body for driving through narrow ways."""
    arm = motion.plan.arm
    carrying.set_in_hand(arm, motion.plan.in_hand)
    carrying.set_arm(arm, motion.carry[-1])
    return is_carrying(carrying, arm, COMPACT)


def crowding(
    world: Imagination, carrying: Imagination, name: str, motion: Pick | Place, enough: float = math.inf
) -> int:
    """How near to things a motion comes, also between the points that the search has looked at; 0 if it keeps away.

    The neighbourhood of the grasp does not count; what is carried far from the body does, for driving.

    Args:
        world: In which the motion was found, just now; the object is where it is grasped or put down.
        carrying: The same with the object in the gripper.
        name: The object.
        motion: What was found.
        enough: From here on it need not be known more exactly.
    """
    arm = motion.plan.arm
    if isinstance(motion, Pick):
        empty = (motion.reach, motion.plan.approach[:-_NEAR])
        full = (motion.plan.lift[_NEAR:], motion.carry)
    else:
        empty = (motion.plan.retreat[_NEAR:], motion.fold)
        full = (motion.reach, motion.plan.lower[:-_NEAR])
    world.set_gripper(arm, pr2.GRIPPER_OPEN)
    world.aim_at(name)
    count = 0
    for imagined, paths in ((world, empty), (carrying, full)):
        for path in paths:
            if len(path) > 1 and count < enough:
                near, touching = imagined.crowded(arm, finer(path, _BETWEEN), _ROOM)
                count += near + TOUCHING * touching
    world.keep_clear(name)
    if count < enough and isinstance(motion, Pick) and not is_compact(carrying, motion):
        count += _WIDE
    return count
