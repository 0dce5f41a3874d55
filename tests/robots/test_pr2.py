from typing import Any

import mujoco
import numpy as np
import pytest

from attune.robots.interface import ARMS, BasePose
from attune.robots.mujoco import pr2
from attune.robots.mujoco.pr2_body import add_pr2

STEP = 0.004


@pytest.fixture(scope="module")
def model() -> Any:
    spec = mujoco.MjSpec()
    add_pr2(spec)
    spec.option.timestep = STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return spec.compile()


@pytest.fixture
def robot(model: Any) -> Any:
    """The robot at rest in its start posture, at the origin."""
    data = mujoco.MjData(model)
    for joint, position in pr2.start_posture(BasePose(0.0, 0.0, 0.0)).items():
        data.joint(joint).qpos[0] = position
        if joint in pr2.SERVOS:
            data.actuator(joint).ctrl[0] = position
    mujoco.mj_forward(model, data)
    return data


def bodies_in_contact(model: Any, data: Any) -> list[tuple[str, str]]:
    return [tuple(model.body(model.geom_bodyid[geom]).name for geom in pair) for pair in data.contact.geom]  # type: ignore[misc]


def test_the_stretched_arms_reach_as_far_as_the_real_ones(model: Any) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for arm, y in (("right", -0.188), ("left", 0.188)):
        # -0.05 to the shoulder, 0.1 to its lift axis, 0.4 upper arm, 0.321 forearm, 0.18 hand.
        assert data.site(pr2.TOOL_FRAME[arm]).xpos == pytest.approx((0.951, y, 0.790675))


@pytest.mark.parametrize(
    ("joint", "low", "high", "speed"),
    [
        ("r_shoulder_pan_joint", -2.2854, 0.7146, 2.088),
        ("l_shoulder_pan_joint", -0.7146, 2.2854, 2.088),
        ("r_upper_arm_roll_joint", -3.9, 0.8, 3.27),
        ("l_elbow_flex_joint", -2.3213, 0.0, 3.3),
        ("torso_lift_joint", 0.0, 0.31, 0.013),
    ],
)
def test_limits_are_those_of_the_published_description(
    model: Any, joint: str, low: float, high: float, speed: float
) -> None:
    assert model.joint(joint).range == pytest.approx((low, high), abs=1e-4)
    assert pr2.SERVOS[joint].speed == speed


def test_forearm_and_wrist_roll_turn_without_end(model: Any) -> None:
    for arm in ARMS:
        for joint in (pr2.ARM_JOINTS[arm][4], pr2.ARM_JOINTS[arm][6]):
            assert not model.joint(joint).limited[0]


def test_the_robot_at_rest_touches_nothing_of_itself(model: Any, robot: Any) -> None:
    assert bodies_in_contact(model, robot) == []


def test_parked_hands_are_level_and_in_front(robot: Any) -> None:
    for arm in ARMS:
        tool = robot.site(pr2.TOOL_FRAME[arm])
        assert tool.xmat[8] > 0.99, "the hand's top looks up"
        assert tool.xmat[0] > 0.9, "it points ahead"
        assert 0.3 < tool.xpos[0] < 0.5
        assert abs(tool.xpos[1]) < pr2.BASE_HALF_WIDTH


def test_arms_that_cross_touch_each_other(model: Any, robot: Any) -> None:
    for joint, angle in (("r_shoulder_pan_joint", 0.4), ("l_shoulder_pan_joint", -0.4)):
        robot.joint(joint).qpos[0] = angle
    for arm in ARMS:
        for joint in pr2.ARM_JOINTS[arm][1:]:
            robot.joint(joint).qpos[0] = 0.0
    mujoco.mj_forward(model, robot)
    sides = {tuple(sorted((a[:2], b[:2]))) for a, b in bodies_in_contact(model, robot)}
    assert ("l_", "r_") in sides


def test_the_camera_looks_along_the_head(robot: Any) -> None:
    camera = robot.cam(pr2.HEAD_CAMERA)
    looks, up = -camera.xmat.reshape(3, 3)[:, 2], camera.xmat.reshape(3, 3)[:, 1]
    assert looks == pytest.approx((1, 0, 0), abs=1e-6)
    assert up == pytest.approx((0, 0, 1), abs=1e-6)
    # The published heights of base, torso, head and plate, and the camera 2 cm over the plate.
    assert camera.xpos[2] - pr2.TORSO_HEIGHT == pytest.approx(0.051 + 0.739675 + 0.38145 + 0.0645 + 0.02, abs=1e-3)


def test_the_robot_stands_still_against_gravity(model: Any, robot: Any) -> None:
    before = robot.qpos.copy()
    mujoco.mj_step(model, robot, round(2.0 / STEP))
    assert np.abs(robot.qvel).max() < 1e-4
    assert robot.qpos == pytest.approx(before, abs=1e-3)


@pytest.mark.parametrize(
    "joint", ["r_shoulder_pan_joint", "r_elbow_flex_joint", "l_wrist_flex_joint", "base_x", "base_yaw"]
)
def test_servos_follow_a_smooth_motion_closely(model: Any, robot: Any, joint: str) -> None:
    servo, start = pr2.SERVOS[joint], robot.joint(joint).qpos[0]
    worst = 0.0
    for time in np.arange(0.0, 3.0, STEP):
        wanted, speed = start + 0.15 * (1 - np.cos(2 * time)), 0.3 * np.sin(2 * time)
        robot.actuator(joint).ctrl[0] = wanted + servo.damping / servo.stiffness * speed
        mujoco.mj_step(model, robot)
        worst = max(worst, abs(robot.joint(joint).qpos[0] - wanted))
    assert worst < 0.006


def test_an_arm_at_full_speed_stops_within_300_ms(model: Any, robot: Any) -> None:
    joint = "r_shoulder_pan_joint"
    servo, position = pr2.SERVOS[joint], robot.joint(joint).qpos[0]
    for _ in range(round(0.3 / STEP)):
        position += servo.speed * STEP
        robot.actuator(joint).ctrl[0] = position + servo.damping / servo.stiffness * servo.speed
        mujoco.mj_step(model, robot)
    assert robot.joint(joint).qvel[0] == pytest.approx(servo.speed, rel=0.05)
    robot.actuator(joint).ctrl[0] = position
    mujoco.mj_step(model, robot, round(0.3 / STEP))
    assert np.abs(robot.qvel).max() < 0.01


def test_grippers_open_as_far_as_the_pads_are_apart(model: Any, robot: Any) -> None:
    robot.actuator(pr2.GRIPPER["left"]).ctrl[0] = pr2.GRIPPER_OPEN
    mujoco.mj_step(model, robot, round(1.0 / STEP))
    left, right = (robot.geom(pad) for pad in pr2.PADS["left"])
    inner_faces = np.linalg.norm(left.xpos - right.xpos) - 2 * model.geom(pr2.PADS["left"][0]).size[1]
    assert inner_faces == pytest.approx(pr2.GRIPPER_OPEN, abs=1e-3)
