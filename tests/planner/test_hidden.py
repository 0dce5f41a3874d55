"""The planner and the camera: what stands behind something else, and what is said of where the robot cannot see."""

import pytest

from attune.core.config import RobotConfig
from attune.core.messages import BringMe, ObjectSpec
from attune.core.scene import Scene, load_scene
from attune.evaluation.kitchen import Kitchen
from attune.robots.mujoco.perception import Perception
from attune.robots.mujoco.robot import MujocoRobot
from attune.robots.mujoco.world import World

CUP = {"name": "cup", "type": "cup", "size": "normal", "color": "red", "at": "cabinet", "position": (-0.2, 0.08)}


def milk(name: str, x: float, y: float) -> dict[str, object]:
    return {"name": name, "type": "milk", "size": "big", "color": "blue", "at": "cabinet", "position": (x, y)}


def kitchen_with(*objects: dict[str, object]) -> Kitchen:
    scene = Scene.model_validate(load_scene().model_dump(exclude_unset=True) | {"objects": objects})
    return Kitchen(scene, lambda scene, clock: MujocoRobot(scene, clock, RobotConfig()))


def test_a_cup_that_is_hidden_behind_a_milk_is_found_from_another_side() -> None:
    kitchen = kitchen_with(CUP, milk("milk", -0.193, -0.079), milk("another", -0.002, -0.086))

    async def script() -> None:
        kitchen.say(BringMe(time=0.0, objects=(ObjectSpec(type="cup"),)))
        await kitchen.until(lambda state: state.step == "transporting_fetch")

    kitchen.play(script)
    world = kitchen.believed()
    assert world is not None
    (cup,) = (item for item in world.objects if item.spec.type == "cup")
    assert cup.position == pytest.approx(kitchen.before["cup"].position, abs=0.01)


def test_what_may_hide_the_thing_that_is_not_found_is_told() -> None:
    kitchen = kitchen_with(CUP, *(milk(f"milk_{index}", 0.09 * index - 0.18, -0.04) for index in range(5)))

    async def script() -> None:
        kitchen.robot.world.remove_object("cup")  # type: ignore[attr-defined]
        kitchen.say(BringMe(time=0.0, objects=(ObjectSpec(type="cup", location="cabinet"),)))
        await kitchen.settle()

    kitchen.play(script)
    told = kitchen.outcomes[-1]
    assert (told.status, told.reason) == ("failed", "not_found")
    assert told.behind is not None
    assert (told.behind.type, told.behind.location) == ("milk", "cabinet")


def test_the_camera_sees_neither_through_things_nor_into_them() -> None:
    scene = Scene.model_validate(
        load_scene().model_dump(exclude_unset=True)
        | {"objects": [milk("milk", 0.3, 0.0) | {"at": "island"}], "robot_start": (3.2, 1.95, 3.14)}
    )
    world = World(scene)
    world.command("head_tilt_joint", 0.6)
    for _ in range(50):
        world.tick()
    x, y, z = world.object_pose("milk").position
    beside, inside, behind = (x, y + 0.2, z + 0.05), (x, y, z + 0.1), (x - 0.08, y, z + 0.05)
    assert Perception(world).sees([beside, inside, behind]) == (True, False, False)
