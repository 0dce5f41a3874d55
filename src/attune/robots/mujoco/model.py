"""The kitchen, its objects and the robot as one MuJoCo model."""

import mujoco

from attune.core.scene import Scene, SceneError
from attune.robots.interface import ARMS
from attune.robots.mujoco.grip import Grip
from attune.robots.mujoco.kitchen import WALLS, add_kitchen, leaf_name
from attune.robots.mujoco.pr2_body import add_pr2
from attune.robots.mujoco.things import add_things
from attune.robots.mujoco.touch import FLOOR

_STEP = 0.004
_FRICTION_STEP = 0.002


def world_spec(scene: Scene, *, friction_only: bool = False) -> mujoco.MjSpec:
    """Kitchen, objects and robot as one model, the robot's joints at zero.

    Raises:
        SceneError: An object or a piece of furniture is named like a part of the robot or of the room.
    """
    _check_names(scene)
    spec = mujoco.MjSpec()
    spec.option.timestep = _FRICTION_STEP if friction_only else _STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # What rests costs nothing until something touches it.
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    add_kitchen(spec, scene)
    add_things(spec, scene)
    add_pr2(spec)
    for arm in ARMS:
        Grip.add_constraints(spec, scene, arm)
    return spec


def _check_names(scene: Scene) -> None:
    robot = mujoco.MjSpec()
    add_pr2(robot)
    reserved = {body.name for body in robot.bodies} | {leaf_name(box.name) for box in scene.containers} | {FLOOR, WALLS}
    names = [piece.name for piece in scene.furniture] + [thing.name for thing in scene.objects]
    taken = sorted(reserved.intersection(names))
    if taken:
        raise SceneError("of the simulation", [f"the name {name!r} is needed for something else" for name in taken])
