from math import pi
from pathlib import Path

import numpy as np
import pytest

from attune.core.scene import Scene, load_scene
from attune.robots.interface import BasePose
from attune.robots.mujoco import pr2
from attune.robots.mujoco.world import TICK, World

BEFORE_TABLE = BasePose(3.2, 1.6, 0.0)
HAND_OVER_TABLE = 0.2
"""Height of the torso at which the parked hands are over the table, in the middle of a cup [m]."""
BEFORE_DRAWER = BasePose(1.164, 3.0, pi / 2)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene()


def make(scene: Scene, base: BasePose, *, friction_only: bool = False) -> World:
    there = scene.model_copy(update={"robot_start": (base.x, base.y, base.yaw)})
    return World(there, friction_only=friction_only)


def wait(world: World, seconds: float) -> None:
    for _ in range(round(seconds / TICK)):
        world.tick()


def move(world: World, joint: str, goal: float, speed: float) -> None:
    """Move one joint at constant speed, and wait until it has come to rest."""
    position = world.joint_position(joint)
    while position != goal:
        step = np.clip(goal - position, -speed * TICK, speed * TICK)
        position += step
        world.command(joint, position, step / TICK)
        world.tick()
    world.command(joint, goal)
    wait(world, 0.3)


def tool(world: World, arm: str = "right") -> np.ndarray:
    return np.array(world.data.site(f"{arm[0]}_gripper_tool_frame").xpos)


def at_table(scene: Scene, *, friction_only: bool = False) -> World:
    """The right hand open, level, 5 cm over the table."""
    world = make(scene, BEFORE_TABLE, friction_only=friction_only)
    move(world, "torso_lift_joint", HAND_OVER_TABLE, 0.2)
    world.command_gripper("right", pr2.GRIPPER_OPEN)
    wait(world, 1.2)
    move(world, "base_x", 3.4, 0.2)
    return world


def put_between_pads(world: World, name: str) -> None:
    x, y, _ = tool(world)
    world.move_object(name, (x, y, 0.741), yaw=0.16)
    wait(world, 0.3)


def close(world: World) -> None:
    world.command_gripper("right", pr2.GRIPPER_CLOSED)
    wait(world, 1.2)


@pytest.mark.parametrize("friction_only", [False, True])
@pytest.mark.parametrize("name", ["red_cup", "red_milk", "green_cereal", "blue_glass", "yellow_bread"])
def test_what_both_pads_press_is_held_and_lifted(scene: Scene, name: str, *, friction_only: bool) -> None:
    world = at_table(scene, friction_only=friction_only)
    put_between_pads(world, name)
    close(world)
    assert world.held("right") == name
    assert min(world.pad_forces("right")[name]) > 2.0
    assert world.forbidden_contacts() == ()
    assert world.place_of(name) == ""
    hand, thing = tool(world), np.array(world.object_pose(name).position)
    move(world, "torso_lift_joint", 0.28, 0.1)
    lifted = np.array(world.object_pose(name).position) - thing
    assert lifted == pytest.approx(tool(world) - hand, abs=0.015 if friction_only else 0.003)
    assert world.is_upright(name)


def test_an_open_gripper_lets_go_and_the_object_stands_on_the_table(scene: Scene) -> None:
    world = at_table(scene)
    put_between_pads(world, "red_cup")
    close(world)
    move(world, "torso_lift_joint", 0.23, 0.1)
    assert world.object_pose("red_cup").position[2] > 0.76
    world.command_gripper("right", pr2.GRIPPER_OPEN)
    assert world.held("right") is None
    wait(world, 1.0)
    assert world.place_of("red_cup") == "table"
    assert world.true_objects()["red_cup"].spec.location == "table"


def test_closing_on_nothing_holds_nothing(scene: Scene) -> None:
    world = at_table(scene)
    close(world)
    assert world.held("right") is None
    assert world.pad_forces("right") == {}
    assert world.gripper_gap("right") < 0.002


def test_an_object_that_only_one_finger_touches_is_not_held(scene: Scene) -> None:
    world = at_table(scene)
    x, y, _ = tool(world)
    world.move_object("red_cup", (x + 0.052, y + 0.01, 0.741))
    close(world)
    assert world.held("right") is None


def test_a_person_can_take_an_object_out_of_the_gripper(scene: Scene) -> None:
    world = at_table(scene)
    put_between_pads(world, "red_cup")
    close(world)
    world.move_object("red_cup", (1.9, 3.95, 0.95))
    wait(world, 0.5)
    assert world.held("right") is None
    assert world.place_of("red_cup") == "counter"


def test_driving_into_the_table_is_a_forbidden_contact(scene: Scene) -> None:
    world = make(scene, BEFORE_TABLE)
    move(world, "torso_lift_joint", 0.15, 0.2)
    assert world.forbidden_contacts() == ()
    move(world, "base_x", 3.6, 0.3)
    assert {thing for _, thing in world.forbidden_contacts()} == {"table"}


@pytest.mark.parametrize(("permitted", "reported"), [([], {"red_milk"}), (["red_milk"], set())])
def test_the_hand_may_touch_only_what_it_is_permitted_to(
    scene: Scene, permitted: list[str], reported: set[str]
) -> None:
    world = at_table(scene)
    put_between_pads(world, "red_milk")
    world.permit("right", permitted)
    touched: set[str] = set()
    for step in range(30):
        world.command("base_y", BEFORE_TABLE.y + 0.001 * step, 0.05)
        world.tick()
        touched |= {thing for _, thing in world.forbidden_contacts()}
    assert touched == reported
    assert world.object_pose("red_milk").position[1] > tool(world)[1] - 0.06


def bumps_on_the_way(world: World, joint: str, goal: float) -> set[tuple[str, str]]:
    met: set[tuple[str, str]] = set()
    while abs(world.joint_position(joint) - goal) > 0.002:
        step = float(np.clip(goal - world.joint_position(joint), -0.002, 0.002))
        world.command(joint, world.joint_position(joint) + step, step / TICK)
        world.tick()
        met.update(world.bumps())
    return met


@pytest.mark.parametrize("put_down", [False, True])
def test_what_is_carried_may_touch_a_table_only_where_it_is_lifted_and_put_down(
    scene: Scene, *, put_down: bool
) -> None:
    world = at_table(scene)
    put_between_pads(world, "red_cup")
    close(world)
    height = world.joint_position("torso_lift_joint")
    assert bumps_on_the_way(world, "torso_lift_joint", height + 0.04) == set()
    world.lower("right" if put_down else None)
    expected = set() if put_down else {("red_cup", "table")}
    assert bumps_on_the_way(world, "torso_lift_joint", height - 0.002) == expected


def test_what_is_carried_must_not_shove_other_things(scene: Scene) -> None:
    world = at_table(scene)
    put_between_pads(world, "red_cup")
    close(world)
    move(world, "torso_lift_joint", HAND_OVER_TABLE + 0.02, 0.1)
    x, y, _ = world.object_pose("red_cup").position
    world.move_object("red_milk", (x + 0.12, y, 0.741))
    wait(world, 0.3)
    assert world.bumps() == ()
    world.lower("right")
    assert ("red_cup", "red_milk") in bumps_on_the_way(world, "base_x", world.base().x + 0.06)


def test_the_gripper_pulls_a_drawer_open_by_its_handle_and_lets_go(scene: Scene) -> None:
    world = make(scene, BEFORE_DRAWER)
    world.command_gripper("right", pr2.GRIPPER_OPEN)
    move(world, "r_wrist_roll_joint", pr2.PARKED["right"][6] + pi / 2, 2.0)
    move(world, "torso_lift_joint", HAND_OVER_TABLE - 0.035, 0.2)
    world.permit("right", ["drawer"])
    handle = world.data.site("drawer_handle").xpos
    move(world, "base_y", world.joint_position("base_y") + float(handle[1] - tool(world)[1]), 0.2)
    close(world)
    assert world.gripped_handle("right") == "drawer"
    assert world.held("right") is None
    move(world, "base_y", world.joint_position("base_y") - 0.35, 0.15)
    assert world.container_position("drawer") == pytest.approx(0.35, abs=0.02)
    world.command_gripper("right", pr2.GRIPPER_OPEN)
    wait(world, 1.0)
    move(world, "base_y", world.joint_position("base_y") - 0.2, 0.2)
    assert world.gripped_handle("right") is None
    assert world.container_position("drawer") == pytest.approx(0.35, abs=0.02)


@pytest.mark.parametrize(("hinge", "way"), [("left", -1.0), ("right", 1.0)])
def test_the_gripper_swings_a_door_open_by_its_handle_although_the_hand_turns_only_half_as_far(
    tmp_path: Path, hinge: str, way: float
) -> None:
    file = tmp_path / "door.toml"
    file.write_text(
        f"""
        robot_start = [3.0, 2.3, {pi / 2}]
        [[furniture]]
        kind = "cupboard"
        name = "cabinet"
        place = "cabinet"
        position = [3.0, 4.0]
        size = [0.5, 0.4, 0.4]
        above_floor = 0.6
        hinge = "{hinge}"
        """,
        encoding="utf-8",
    )
    world = World(load_scene(file))
    world.command_gripper("right", pr2.GRIPPER_OPEN)
    move(world, "torso_lift_joint", 0.27, 0.2)
    world.permit("right", ["cabinet"])
    for joint, axis in (("base_x", 0), ("base_y", 1)):
        handle = world.data.site("cabinet_handle").xpos
        move(world, joint, world.joint_position(joint) + float(handle[axis] - tool(world)[axis]), 0.2)
    close(world)
    assert world.gripped_handle("right") == "cabinet"

    pivot, hand, base = np.array([3.0 + way * 0.25, 3.8]), tool(world)[:2], world.base()
    touched: set[tuple[str, str]] = set()
    for angle in np.linspace(0.0, 1.3 * way, 250):
        x, y = pivot + turned(hand - pivot, angle) + turned(np.array([base.x, base.y]) - hand, angle / 2)
        for joint, target in zip(pr2.BASE_JOINTS, (x, y, base.yaw + angle / 2), strict=True):
            world.command(joint, float(target))
        world.tick()
        touched |= set(world.forbidden_contacts())
    wait(world, 0.5)
    assert world.container_position("cabinet") == pytest.approx(1.3, abs=0.03)
    assert touched == set()


def turned(vector: np.ndarray, angle: float) -> np.ndarray:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])


def test_an_object_on_the_floor_is_at_no_place(scene: Scene) -> None:
    world = World(scene)
    world.move_object("red_cup", (3.0, 3.0, 0.0))
    wait(world, 0.5)
    assert world.place_of("red_cup") == ""
    assert world.true_objects()["red_cup"].place == ""


def test_an_object_put_into_the_air_falls_onto_what_is_below(scene: Scene) -> None:
    world = World(scene)
    world.move_object("blue_milk", (1.75, 2.2, 1.1))
    wait(world, 1.0)
    assert world.place_of("blue_milk") == "island"
    assert world.object_pose("blue_milk").position[2] == pytest.approx(0.88, abs=0.01)


def test_a_removed_object_is_gone_and_can_come_back(scene: Scene) -> None:
    world = World(scene)
    world.remove_object("red_cup")
    wait(world, 0.2)
    assert "red_cup" not in world.object_names
    assert "red_cup" not in world.true_objects()
    world.move_object("red_cup", (2.4, 3.94, 0.88))
    wait(world, 0.2)
    assert world.true_objects()["red_cup"].place == "counter"


def test_a_fallen_object_is_not_upright(scene: Scene) -> None:
    world = World(scene)
    start = world.model.joint("red_glass_free").qposadr[0]
    world.data.qpos[start + 2] += 0.1
    world.data.qpos[start + 3 : start + 7] = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
    wait(world, 1.0)
    assert not world.is_upright("red_glass")
    assert world.place_of("red_glass") == "table"


def test_the_robot_at_rest_has_no_speed_and_one_in_motion_has(scene: Scene) -> None:
    world = World(scene)
    assert world.speed() < 1e-3
    for step in range(10):
        world.command("head_pan_joint", step * 0.02, 1.0)
        world.tick()
    assert world.speed() > 0.5


def test_two_worlds_moved_alike_stay_alike(scene: Scene) -> None:
    worlds = [at_table(scene) for _ in range(2)]
    for world in worlds:
        put_between_pads(world, "red_cup")
        close(world)
    assert np.array_equal(worlds[0].snapshot(), worlds[1].snapshot())


def test_a_snapshot_is_a_copy(scene: Scene) -> None:
    world = World(scene)
    world.snapshot()[:] = 0.0
    assert world.base() == BasePose(*(pytest.approx(value, abs=1e-4) for value in scene.robot_start))
