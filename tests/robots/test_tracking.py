import numpy as np
import pytest

from attune.robots.interface import ARMS, Arm
from attune.robots.mujoco.kinematics import ArmKinematics
from attune.robots.mujoco.pr2_arm import arm_geometry
from attune.robots.mujoco.tracking import follow


@pytest.mark.parametrize("arm", ARMS)
def test_the_hand_goes_through_all_poses_without_a_jump_of_any_joint(arm: Arm) -> None:
    kinematics = ArmKinematics(arm_geometry(arm))
    random = np.random.default_rng(0)
    low = np.where(kinematics.continuous, -3.0, kinematics.geometry.low)
    high = np.where(kinematics.continuous, 3.0, kinematics.geometry.high)
    followed = 0
    for start in random.uniform(low, high, (100, 7)):
        position, orientation = kinematics.forward(start[None])
        way = random.normal(size=3)
        positions = position + np.linspace(0.0, 0.1, 6)[:, None] * way / np.linalg.norm(way)
        path = follow(kinematics, start, positions, np.repeat(orientation, 6, axis=0))
        if path is None:
            continue
        followed += 1
        reached, turned = kinematics.forward(path)
        assert np.abs(path[0] - start).max() < 1e-9
        assert np.abs(reached - positions).max() < 1e-9
        assert np.abs(turned - orientation).max() < 1e-9
        assert np.abs(np.diff(path, axis=0)).max() <= 0.5
        assert ((path >= kinematics.geometry.low) & (path <= kinematics.geometry.high)).all()
    assert followed > 60


def test_what_is_out_of_reach_cannot_be_followed() -> None:
    kinematics = ArmKinematics(arm_geometry("left"))
    start = np.array([0.3, 0.4, 0.5, -1.5, 0.0, -1.0, 0.0])
    position, orientation = kinematics.forward(start[None])
    positions = position + np.linspace(0.0, 1.0, 50)[:, None] * np.array([1.0, 0.0, 0.0])
    assert follow(kinematics, start, positions, np.repeat(orientation, 50, axis=0)) is None
