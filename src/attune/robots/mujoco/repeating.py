"""A picking motion that was found for a place to stand, made to fit where robot and object really are now.

Both differ by millimetres from what was imagined. Where a motion was hard to find, that is surer than to search anew.
"""

import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import Percept
from attune.robots.mujoco.frames import frame_of
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import ArmKinematics
from attune.robots.mujoco.pick_place import PickPlan, Start, finish_pick, moved
from attune.robots.mujoco.reaching import finer, reach_all
from attune.robots.mujoco.whole_motions import Pick, turned

Array = NDArray[np.float64]

_PANS = np.array([0.0, 0.02, -0.02, 0.05, -0.05])
"""Changes of the shoulder's pan that are tried [rad]."""
_STEP = 0.05
"""Between two points of a path that are tried [rad]."""


def repeated(world: Imagination, carrying: Imagination, percept: Percept, found: Pick) -> Pick | None:
    """The same motion from the arm's posture now; None if it is not free any more.

    Args:
        world: The object stands where it is seen now; the robot stands where it really stands.
        carrying: Made with the object in this arm's gripper.
        percept: The object.
        found: The motion from about here, for an object about there.
    """
    arm, old = found.plan.arm, found.plan
    kinematics, torso, posture = world.kinematics[arm], world.torso_frame(), world.arm(arm)
    places, _ = kinematics.forward(np.stack((old.approach[-1], old.approach[0], old.lift[-1])))
    grasp = frame_of(percept.pose) @ old.in_hand.inverse()
    frames = (grasp, *(moved(grasp, torso.rotation @ (place - places[0])) for place in places[1:]))
    keys, _ = reach_all(kinematics, torso, (frames,), old.approach[-1][0] + _PANS)
    changes = np.abs(kinematics.unwrap(keys[:, 0], old.approach[-1]) - old.approach[-1]).max(axis=1)
    for index in np.argsort(changes, kind="stable"):
        world.put(percept.name, frame_of(percept.pose))
        world.aim_at(percept.name)
        plan = finish_pick(world, carrying, percept, Start(arm, keys[index], frames, 0.0), set())
        world.keep_clear(percept.name)
        if plan is None:
            continue
        reach = _fitted(kinematics, found.reach, posture, plan.approach[0])
        approach = turned(plan.approach, reach[-1])
        lift = turned(plan.lift, approach[-1])
        carry = _fitted(kinematics, turned(found.carry, lift[-1]), lift[-1], found.carry[-1])
        if world.all_free(arm, reach[:0:-1]) and carrying.all_free(arm, carry[1:]):
            return Pick(reach, PickPlan(arm, approach, lift, plan.in_hand), carry)
    return None


def _fitted(kinematics: ArmKinematics, path: Array, start: Array, end: Array) -> Array:
    """A path that is shifted, less and less along it, to begin and to end elsewhere."""
    share = np.linspace(0.0, 1.0, len(path))[:, None]
    first = kinematics.unwrap(start, path[0]) - path[0]
    last = kinematics.unwrap(end, path[-1]) - path[-1]
    turns = start - kinematics.unwrap(start, path[0])
    return finer(path + (1.0 - share) * first + share * last + turns, _STEP)
