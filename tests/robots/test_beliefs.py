import pytest

from attune.core.scene import load_scene
from attune.robots.mujoco.beliefs import Beliefs
from attune.robots.mujoco.perception import Perception
from attune.robots.mujoco.world import World


def test_what_was_seen_in_a_drawer_is_believed_to_move_with_it() -> None:
    world = World(load_scene().model_copy(update={"robot_start": (1.4, 2.85, 1.57)}))
    world.command("head_tilt_joint", 1.0)
    for _ in range(50):
        world.tick()
    world.move_container("drawer", 0.4)
    spoon = next(percept for percept in Perception(world).look() if percept.name == "blue_spoon")
    beliefs = Beliefs(world)
    beliefs.notice([spoon])
    opened = beliefs.surroundings()
    world.move_container("drawer", 0.0)
    imagined = beliefs.imagine()
    address = imagined.model.joint("blue_spoon_free").qposadr[0]
    assert imagined.data.qpos[address : address + 3] == pytest.approx(
        world.object_pose("blue_spoon").position, abs=0.02
    )
    assert beliefs.surroundings() != opened
