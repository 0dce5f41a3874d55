import mujoco
import numpy as np
import pytest

from attune.core.scene import load_scene
from attune.robots.interface import ARMS, Arm, BasePose
from attune.robots.mujoco import pr2
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import ArmKinematics
from attune.robots.mujoco.pr2_arm import arm_geometry
from attune.robots.mujoco.world import World


def configurations(kinematics: ArmKinematics, count: int) -> np.ndarray:
    random = np.random.default_rng(0)
    low = np.where(kinematics.continuous, -3.0, kinematics.geometry.low)
    high = np.where(kinematics.continuous, 3.0, kinematics.geometry.high)
    return random.uniform(low, high, (count, 7))


@pytest.mark.parametrize("arm", ARMS)
def test_forward_kinematics_is_that_of_the_simulated_robot(arm: Arm) -> None:
    world = World(load_scene())
    imagined = Imagination(world.model, world.snapshot(), {}, {})
    imagined.base = BasePose(0.7, -0.4, 1.1)
    for q in configurations(imagined.kinematics[arm], 20):
        imagined.set_arm(arm, q)
        mujoco.mj_kinematics(imagined.model, imagined.data)
        site = imagined.data.site(pr2.TOOL_FRAME[arm])
        assert imagined.tool(arm).position == pytest.approx(site.xpos, abs=1e-9)
        assert imagined.tool(arm).rotation.flatten() == pytest.approx(site.xmat, abs=1e-9)


@pytest.mark.parametrize("arm", ARMS)
def test_inverse_kinematics_gives_back_every_configuration_from_its_pan_and_branch(arm: Arm) -> None:
    kinematics = ArmKinematics(arm_geometry(arm))
    q = configurations(kinematics, 2000)
    position, orientation = kinematics.forward(q)
    found, good = kinematics.inverse(position, orientation, q[:, 0], kinematics.branch(q))
    assert good.all()
    assert np.abs(kinematics.unwrap(found, q) - q).max() < 1e-6


@pytest.mark.parametrize("arm", ARMS)
def test_all_solutions_reach_their_pose_within_limits(arm: Arm) -> None:
    kinematics = ArmKinematics(arm_geometry(arm))
    position, orientation = kinematics.forward(configurations(kinematics, 50))
    q, index = kinematics.solutions(position, orientation, kinematics.pan_grid())
    reached, turned = kinematics.forward(q)
    assert len(set(index)) >= 45  # those at the edge of the arm's reach fall between two pans of the grid
    assert np.abs(reached - position[index]).max() < 1e-9
    assert np.abs(turned - orientation[index]).max() < 1e-9
    assert ((q >= kinematics.geometry.low) & (q <= kinematics.geometry.high)).all()


def test_a_pose_out_of_reach_has_no_solution() -> None:
    kinematics = ArmKinematics(arm_geometry("left"))
    q, _ = kinematics.solutions(np.array([[1.5, 0.0, 0.0]]), np.eye(3)[None], kinematics.pan_grid())
    assert len(q) == 0
