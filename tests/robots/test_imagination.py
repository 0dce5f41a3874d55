import itertools

import numpy as np
import pytest

from attune.core.scene import load_scene
from attune.robots.interface import BasePose, Percept, Pose
from attune.robots.mujoco import pr2
from attune.robots.mujoco.carry import FOLDED, fold, folding_path, is_folded, is_out_of_the_way
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.grasps import more_grasps
from attune.robots.mujoco.imagination import Imagination
from attune.robots.mujoco.kinematics import rotation
from attune.robots.mujoco.kitchen import joint_name
from attune.robots.mujoco.reaching import free_between, stacked
from attune.robots.mujoco.skeleton import through_things
from attune.robots.mujoco.upright_paths import upright_path
from attune.robots.mujoco.world import World

SCENE = load_scene()
ACROSS = np.array([-0.459, 0.619, -0.446, -2.145, 4.962, -1.955, 2.914])
"""Of the left arm: close to the body, where the folded right arm would be."""
BESIDE = np.array([0.006, 0.205, -0.877, -2.047, -0.532, -1.872, -4.034])
"""Of the right arm: close to the body, beside the left one."""
AHEAD, ASIDE = (0.6, -0.1, 0.0), (0.1, -0.9, 0.1)


@pytest.fixture(scope="module")
def world() -> World:
    return World(SCENE)


def in_the_open(world: World, *, carrying: bool = False) -> Imagination:
    """The robot in the middle of the room, with a cup in its right hand or empty hands."""
    in_hand = Frame(np.array([0.0, 0.0, -0.04]), np.eye(3))
    imagined = Imagination(world.model, world.snapshot(), {}, {"right": ("red_cup", in_hand)} if carrying else {})
    imagined.base = BasePose(2.9, 2.9, 0.0)
    return imagined


def level(imagined: Imagination, place: tuple[float, float, float]) -> np.ndarray:
    """A configuration of the right arm with the hand level at a place in the torso's frame, pointing ahead."""
    kinematics = imagined.kinematics["right"]
    q, _ = kinematics.solutions(np.array([place]), np.eye(3)[None], kinematics.pan_grid())
    return q[len(q) // 2]


@pytest.mark.parametrize(("margin", "is_free"), [(0.02, False), (0.004, True)])
def test_what_is_carried_keeps_as_far_from_objects_as_it_is_told(world: World, margin: float, is_free: bool) -> None:
    imagined = in_the_open(world, carrying=True)
    imagined.set_arm("right", level(imagined, AHEAD))
    cup = imagined.carried_frame("right")
    radii = sum(SCENE.shape(name).extent[0] / 2 for name in ("red_cup", "black_mug"))
    imagined.put("black_mug", Frame(cup.position + (radii + 0.012, 0.0, 0.0), cup.rotation))
    imagined.widen_objects(margin)
    assert imagined.free() == is_free


def test_an_empty_arm_has_somewhere_to_go_also_where_the_other_is_in_its_way(world: World) -> None:
    imagined = in_the_open(world)
    imagined.set_arm("left", ACROSS)
    imagined.set_arm("right", BESIDE)
    assert is_out_of_the_way(imagined, "right")
    stretched = level(imagined, AHEAD)
    imagined.set_arm("right", stretched)
    assert not is_out_of_the_way(imagined, "right")
    path = folding_path(imagined, "right", np.random.default_rng(0), stretched, instead=BESIDE)
    assert path is not None
    imagined.set_arm("right", path[-1])
    assert is_out_of_the_way(imagined, "right")
    imagined.set_arm("left", FOLDED["left"])
    fold(imagined, "right")
    assert is_folded(imagined, "right")


def test_a_carried_object_stays_upright_around_the_shoulder(world: World) -> None:
    imagined = in_the_open(world, carrying=True)
    start, goal = level(imagined, AHEAD), level(imagined, ASIDE)
    path = upright_path(imagined, "right", start, goal, np.random.default_rng(0))
    assert path is not None
    assert path[0] == pytest.approx(start)
    assert path[-1] == pytest.approx(imagined.kinematics["right"].unwrap(goal, path[-1]))
    dense = np.concatenate([np.linspace(a, b, 5) for a, b in itertools.pairwise(path)])
    _, orientation = imagined.kinematics["right"].forward(dense)
    assert orientation[:, 2, 2].min() > np.cos(np.radians(3.0))


def test_what_is_in_the_way_between_two_points_of_a_path_is_seen(world: World) -> None:
    imagined = in_the_open(world, carrying=True)
    path = np.stack([level(imagined, AHEAD), level(imagined, AHEAD)])
    path[:, 0] += (-0.3, 0.3)  # The cup swings around the shoulder, past where the mug is.
    assert free_between(imagined, "right", path)
    imagined.set_arm("right", path.mean(axis=0))
    imagined.put("black_mug", imagined.carried_frame("right"))
    assert imagined.all_free("right", path)
    assert not free_between(imagined, "right", path)


def test_what_lies_flat_may_be_grasped_far_from_its_middle_and_askew() -> None:
    pose = Pose((1.0, 2.0, 0.9), (1.0, 0.0, 0.0, 0.0))
    spoon = Percept("spoon", "spoon", "grey", "small", pose, (0.14, 0.03, 0.014), "counter")
    tools = [grasp.tool for grasp in more_grasps(spoon)]
    assert max(abs(tool.position[0] - 1.0) for tool in tools) > 0.05
    # Turned from straight across, both pads still go around it, over what it lies on.
    assert max(abs(tool.rotation[0, 1]) for tool in tools) > 0.2
    assert all(abs(tool.rotation[0, 1]) * 0.14 + abs(tool.rotation[1, 1]) * 0.03 < pr2.GRIPPER_OPEN for tool in tools)
    assert all(tool.position[2] - pr2.PAD_LENGTH / 2 * -tool.rotation[2, 0] > 0.9 for tool in tools)


def test_what_is_sorted_out_at_once_could_not_be_free(world: World) -> None:
    imagined = in_the_open(world)
    imagined.base = BasePose(4.67, 3.62, 0.44)  # Before the cabinet.
    imagined.set_joint(joint_name("cabinet"), 1.5)
    rng, kinematics = np.random.default_rng(0), imagined.kinematics["left"]
    inside = SCENE.surface("cabinet").center + rng.uniform((-0.2, -0.1, 0.05), (0.2, 0.1, 0.3), (60, 3))
    hands = [Frame(place, rotation(2, yaw)) for place, yaw in zip(inside, rng.uniform(0.0, np.pi, 60), strict=True)]
    q, _ = kinematics.solutions(*stacked(imagined.torso_frame(), hands), kinematics.pan_grid(0.4))
    blocked = through_things(imagined, "left", q, "red_cup")
    free = np.array([imagined.all_free("left", configuration[None]) for configuration in q])
    assert free.any()
    assert not (blocked & free).any()
    assert blocked.sum() > 0.5 * (~free).sum()
