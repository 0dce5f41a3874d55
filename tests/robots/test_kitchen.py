from pathlib import Path

import numpy as np
import pytest

from attune.core.scene import Scene, SceneError, load_scene
from attune.robots.mujoco.kitchen import handle_name, joint_name
from attune.robots.mujoco.world import TICK, World

CONTAINERS = tuple(container.name for container in load_scene().containers)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene()


def run(world: World, seconds: float) -> None:
    for _ in range(round(seconds / TICK)):
        world.tick()


def pull(world: World, container: str, force: float, seconds: float = 3.0) -> None:
    """Push the moving part with a force [N] along its joint, then let it come to rest."""
    dof = world.model.joint(joint_name(container)).dofadr[0]
    lever = 1.0 if world.scene.container(container).kind == "drawer" else 0.4
    world.data.qfrc_applied[dof] = force * lever
    run(world, seconds)
    world.data.qfrc_applied[dof] = 0.0
    run(world, 1.0)


def test_all_objects_rest_where_they_were_put_for_ten_seconds(scene: Scene) -> None:
    world = World(scene)
    run(world, 10.0)
    for thing in scene.objects:
        start, now = scene.starts[thing.name], world.object_pose(thing.name).position
        assert np.linalg.norm(np.array(now) - start[:3]) < 0.002, thing.name
        assert world.is_upright(thing.name), thing.name


def test_all_objects_stay_put_when_nothing_is_allowed_to_sleep(scene: Scene) -> None:
    world = World(scene)
    for _ in range(10):
        for thing in scene.objects:
            world.data.joint(f"{thing.name}_free").qvel[:] += 1e-9
        run(world, 0.2)
    for thing in scene.objects:
        assert world.place_of(thing.name) == thing.at
        assert world.is_upright(thing.name)


@pytest.mark.parametrize("container", CONTAINERS)
def test_a_container_opens_and_closes_by_force_and_stays_where_it_is_left(scene: Scene, container: str) -> None:
    world = World(scene)
    pull(world, container, 15.0)
    opened = world.container_position(container)
    assert opened >= scene.container(container).opened - 0.01
    run(world, 3.0)
    assert world.container_position(container) == pytest.approx(opened, abs=1e-3)
    pull(world, container, -15.0)
    assert world.container_position(container) == pytest.approx(0.0, abs=0.005)


def test_what_is_in_a_drawer_comes_along(scene: Scene) -> None:
    world = World(scene)
    before = world.object_pose("blue_spoon").position
    pull(world, "drawer", 15.0)
    after = world.object_pose("blue_spoon").position
    assert after[1] - before[1] < -0.3
    assert world.place_of("blue_spoon") == "drawer"
    assert world.is_upright("blue_spoon")


@pytest.mark.parametrize("container", CONTAINERS)
def test_handles_stand_out_in_front_and_lie_along_their_bar(scene: Scene, container: str) -> None:
    world = World(scene)
    site = world.data.site(handle_name(container))
    bar, out = site.xmat.reshape(3, 3)[:, 0], site.xmat.reshape(3, 3)[:, 2]
    assert out == pytest.approx((0, -1, 0), abs=1e-6), "all fronts of this kitchen look down the map"
    along = (0, 0, 1) if scene.container(container).hinge in ("left", "right") else (1, 0, 0)
    assert np.abs(bar) == pytest.approx(along, abs=1e-6)
    geom = world.data.geom(handle_name(container))
    assert np.abs(geom.xmat.reshape(3, 3)[:, 2]) == pytest.approx(along, abs=1e-6)
    assert geom.xpos == pytest.approx(site.xpos)


def test_a_person_can_add_furniture_and_objects_in_a_file(tmp_path: Path) -> None:
    path = tmp_path / "small.toml"
    path.write_text(
        """
        room = [4.0, 3.0]
        robot_start = [1.0, 1.0, 0.0]
        user = [3.0, 0.5]
        [[furniture]]
        kind = "table"
        name = "desk"
        place = "table"
        position = [2.6, 1.6]
        yaw = 0.4
        size = [1.2, 0.6, 0.7]
        [[furniture]]
        kind = "cupboard"
        name = "locker"
        place = "cabinet"
        position = [0.3, 2.4]
        yaw = 1.5708
        size = [0.5, 0.4, 1.2]
        board = 0.6
        [[objects]]
        name = "mug"
        type = "mug"
        color = "pink"
        at = "desk"
        [[objects]]
        name = "glass"
        type = "glass"
        color = "blue"
        at = "locker"
        """,
        encoding="utf-8",
    )
    world = World(load_scene(path))
    run(world, 2.0)
    assert world.place_of("mug") == "desk"
    assert world.place_of("glass") == "locker"


@pytest.mark.parametrize("name", ["base_link", "walls", "floor", "drawer_leaf"])
def test_an_object_named_like_a_part_of_the_simulation_is_refused(scene: Scene, name: str) -> None:
    thing = scene.object("red_cup").model_copy(update={"name": name})
    clashing = Scene(room=scene.room, robot_start=scene.robot_start, furniture=scene.furniture, objects=(thing,))
    with pytest.raises(SceneError, match=f"the name '{name}' is needed for something else"):
        World(clashing)
