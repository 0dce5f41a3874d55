from math import pi

import numpy as np
import pytest

from attune.core.messages import ObjectSpec
from attune.core.scene import Scene, load_scene
from attune.robots.interface import BasePose
from attune.robots.mujoco import pr2
from attune.robots.mujoco.perception import CameraSettings, Perception
from attune.robots.mujoco.world import World

AT_COUNTER = BasePose(1.9, 3.1, pi / 2)
AT_CABINET = BasePose(4.9, 3.3, pi / 2)
AT_DRAWER = BasePose(1.4, 2.85, pi / 2)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene()


def standing(scene: Scene, base: BasePose, tilt: float) -> World:
    """A world with the robot there, its head bent down by `tilt`."""
    world = World(scene.model_copy(update={"robot_start": (base.x, base.y, base.yaw)}))
    world.command("head_tilt_joint", tilt)
    for _ in range(50):
        world.tick()
    return world


def names(perception: Perception, spec: ObjectSpec = ObjectSpec()) -> set[str]:
    return {percept.name for percept in perception.look(spec)}


def test_it_sees_what_stands_in_front_of_it_and_nothing_behind(scene: Scene) -> None:
    seen = names(Perception(standing(scene, AT_COUNTER, 0.8)))
    assert seen == {"white_bowl", "green_cereal", "blue_milk", "red_cup"}


def test_it_sees_nothing_above_its_field_of_view(scene: Scene) -> None:
    assert names(Perception(standing(scene, AT_COUNTER, -0.47))) == set()


def test_a_closed_door_hides_what_is_behind_it_and_an_open_one_does_not(scene: Scene) -> None:
    world = standing(scene, AT_CABINET, 0.3)
    perception = Perception(world)
    assert "white_cup" not in names(perception)
    world.move_container("cabinet", 1.5)
    assert "white_cup" in names(perception)


def test_a_closed_drawer_hides_the_spoon_and_an_open_one_does_not(scene: Scene) -> None:
    world = standing(scene, AT_DRAWER, 1.0)
    perception = Perception(world)
    assert "blue_spoon" not in names(perception)
    world.move_container("drawer", 0.4)
    spoon = next(percept for percept in perception.look() if percept.name == "blue_spoon")
    assert spoon.place == "drawer"
    assert spoon.pose.position == pytest.approx(world.object_pose("blue_spoon").position, abs=0.01)


def test_an_arm_before_the_camera_hides_objects(scene: Scene) -> None:
    world = standing(scene, AT_COUNTER, 0.8)
    perception = Perception(world)
    before = perception.visible_share("green_cereal")
    raised = {"shoulder_pan": 0.15, "shoulder_lift": -0.3, "upper_arm_roll": 0.0, "elbow_flex": -0.1}
    for arm, sign in (("right", 1.0), ("left", -1.0)):
        for kind, angle in raised.items():
            world.command(f"{pr2.SIDE[arm]}_{kind}_joint", angle * sign if kind == "shoulder_pan" else angle)
    for _ in range(100):
        world.tick()
    assert before == 1.0
    assert perception.visible_share("green_cereal") < before


def test_one_object_hides_another(scene: Scene) -> None:
    world = standing(scene, AT_COUNTER, 0.8)
    world.move_object("red_cup", (1.70, 3.90, 0.88))
    world.move_object("green_cereal", (1.70, 3.82, 0.88))
    assert "red_cup" not in names(Perception(world))


def test_what_is_too_far_away_is_not_recognised(scene: Scene) -> None:
    world = standing(scene, AT_COUNTER, 0.8)
    assert names(Perception(world, CameraSettings(farthest=0.8))) == set()


def test_only_what_fits_the_description_is_reported(scene: Scene) -> None:
    perception = Perception(standing(scene, AT_COUNTER, 0.8))
    assert names(perception, ObjectSpec(type="bowl")) == {"white_bowl"}
    assert names(perception, ObjectSpec(color="purple")) == set()


def test_positions_are_as_noisy_as_configured(scene: Scene) -> None:
    world = standing(scene, AT_COUNTER, 0.8)
    perception = Perception(world, CameraSettings(noise=0.01), seed=3)
    truth = np.array(world.object_pose("red_cup").position)
    errors = [perception.look(ObjectSpec(name="red_cup"))[0].pose.position - truth for _ in range(200)]
    assert np.std(errors) == pytest.approx(0.01, rel=0.15)


def test_as_many_looks_miss_as_configured(scene: Scene) -> None:
    perception = Perception(standing(scene, AT_COUNTER, 0.8), CameraSettings(miss=0.3), seed=3)
    found = sum(bool(perception.look(ObjectSpec(name="red_cup"))) for _ in range(300))
    assert found == pytest.approx(210, abs=25)


def test_the_same_seed_sees_the_same(scene: Scene) -> None:
    world = standing(scene, AT_COUNTER, 0.8)
    settings = CameraSettings(noise=0.01, miss=0.2)
    first, second = (Perception(world, settings, seed=7) for _ in range(2))
    assert [first.look() for _ in range(5)] == [second.look() for _ in range(5)]


def test_a_removed_object_is_seen_no_more(scene: Scene) -> None:
    world = standing(scene, AT_COUNTER, 0.8)
    world.remove_object("red_cup")
    assert "red_cup" not in names(Perception(world))
