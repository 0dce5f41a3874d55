import math
from pathlib import Path

import pytest

from attune.core.scene import Scene, SceneError, load_scene
from attune.core.shapes import clearance_needed

TABLE = """
room = [5.0, 4.0]
robot_start = [1.0, 1.0, 0.0]
user = [4.0, 1.0]

[[furniture]]
kind = "table"
name = "table"
place = "table"
position = [3.0, 2.0]
size = [1.4, 0.8, 0.72]

[[objects]]
name = "white_cup"
type = "cup"
color = "white"
at = "table"
position = [0.1, 0.1]
"""

CABINET = """
[[furniture]]
kind = "cupboard"
name = "cabinet"
place = "cabinet"
position = [1.0, 3.5]
size = [0.6, 0.4, 0.6]
above_floor = 1.0
"""

COUNTER = """
[[furniture]]
kind = "counter"
name = "counter"
place = "countertop"
position = [1.0, 3.5]
yaw = 1.5707963
size = [1.0, 0.6, 0.88]

[[furniture.drawers]]
name = "cutlery"
x = 0.2
width = 0.4
"""


def an_object(name: str = "thing", **more: object) -> str:
    entry = {"type": "cup", "color": "red", "at": "table", **more}
    return "\n[[objects]]\n" + "\n".join(
        f"{key} = {value if isinstance(value, list | float) else repr(value)}"
        for key, value in {"name": name, **entry}.items()
    )


def read(tmp_path: Path, text: str) -> Scene:
    path = tmp_path / "my_kitchen.toml"
    path.write_text(text, encoding="utf-8")
    return load_scene(path)


def test_the_kitchen_that_comes_with_attune_has_every_kind_of_place() -> None:
    places = load_scene().vocabulary.places
    assert places == ("cabinet", "countertop", "dishwasher", "drawer", "fridge", "shelf", "table")


def test_the_kitchen_has_the_objects_of_the_paper() -> None:
    scene = load_scene()
    there = {(o.type, o.color, o.size, scene.surface(o.at).place) for o in scene.objects}
    assert {("spoon", "blue", "normal", "drawer"), ("cup", "white", "normal", "cabinet")} <= there
    assert {
        ("bowl", "white", "normal"),
        ("cereal", "green", "normal"),
        ("milk", "blue", "normal"),
        ("milk", "red", "big"),
    } <= {entry[:3] for entry in there}


def test_open_surfaces_hold_a_red_and_a_blue_cup() -> None:
    scene = load_scene()
    open_cups = {o.color for o in scene.objects if o.type == "cup" and not scene.surface(o.at).container}
    assert {"red", "blue"} <= open_cups


def test_every_object_starts_on_its_surface() -> None:
    scene = load_scene()
    for thing in scene.objects:
        surface, start = scene.surface(thing.at), scene.starts[thing.name]
        x, y = surface.from_map(start.x, start.y)
        assert abs(x) < surface.size[0] / 2
        assert abs(y) < surface.size[1] / 2
        assert start.z == surface.center[2]


def test_a_surface_maps_points_to_the_map_and_back() -> None:
    surface = load_scene().surface("table")
    x, y, z = surface.to_map(0.3, -0.2)
    assert surface.from_map(x, y) == pytest.approx((0.3, -0.2))
    assert z == surface.center[2]


def test_a_drawer_moves_out_of_its_counters_front(tmp_path: Path) -> None:
    scene = read(tmp_path, TABLE + COUNTER)
    # Turned by a quarter, the front (the counter's -y) faces the map's +x.
    assert scene.surface("cutlery").shift == pytest.approx((0.4, 0.0, 0.0), abs=1e-6)
    assert scene.surface("cutlery").container == "cutlery"
    assert scene.container("cutlery").kind == "drawer"


def test_surfaces_are_found_by_what_people_call_them() -> None:
    assert [surface.name for surface in load_scene().surfaces_at("countertop")] == ["counter", "island"]
    assert load_scene().surfaces_at("garage") == ()


def test_an_object_without_a_position_takes_a_free_spot(tmp_path: Path) -> None:
    scene = read(tmp_path, TABLE + "".join(an_object(f"cup_{i}") for i in range(6)))
    spots = [scene.starts[o.name] for o in scene.objects]
    nearest = min(math.dist(a[:2], b[:2]) for a in spots for b in spots if a is not b)
    assert nearest > scene.shape("white_cup").extent[0]


def test_a_type_of_ones_own_becomes_vocabulary(tmp_path: Path) -> None:
    scene = read(
        tmp_path,
        TABLE
        + an_object("atlas", type="book", color="green")
        + '\n[types.book]\nform = "box"\ngrasps = ["side"]\nsizes.normal = {extent = [0.15, 0.03, 0.2], mass = 0.4}',
    )
    assert "book" in scene.vocabulary.types
    assert scene.shape("atlas").extent == (0.15, 0.03, 0.2)


def test_what_is_only_taken_from_above_needs_a_free_sky() -> None:
    scene = load_scene()
    assert clearance_needed(scene.shape("white_bowl")) == math.inf
    assert clearance_needed(scene.shape("white_cup")) < 0.2


WRONG = {
    "unknown object type": (an_object(type="sofa"), "object 'thing': type: 'sofa' is not known; allowed: cup, mug"),
    "unknown size": (
        an_object(size="huge"),
        "object 'thing': size: Input should be 'small', 'normal' or 'big' (got 'huge')",
    ),
    "unknown color": (an_object(color="mauve"), "object 'thing': color: 'mauve' is not known; allowed: red, green"),
    "unknown surface": (an_object(at="sofa"), "object 'thing': at: there is no surface 'sofa'; allowed: table"),
    "unknown key": (
        an_object(weight=3.0),
        "object 'thing': unknown key 'weight' (value 3.0); allowed: name, type, color",
    ),
    "missing key": (
        '[[objects]]\nname = "thing"\ncolor = "red"\nat = "table"',
        "object 'thing': key 'type' is missing",
    ),
    "over the edge": (
        an_object(position=[0.69, 0.0]),
        "object 'thing': position: [0.69, 0.0] puts it over the edge of 'table'",
    ),
    "two in one place": (
        an_object(position=[0.12, 0.1]),
        "object 'thing': position: less than 0.01 m from 'white_cup'",
    ),
    "same name twice": (an_object("white_cup"), "name 'white_cup' is used 2 times"),
    "no name": ('[[objects]]\ntype = "cup"', "object number 2: key 'name' is missing"),
    "plate in a cabinet": (
        CABINET + an_object(type="plate", at="cabinet"),
        "'cabinet' has 0.56 m of room above it, too low for a plate",
    ),
    "too high": (
        CABINET.replace("1.0\n", "1.5\n"),
        "furniture 'cabinet': its surface is 1.52 m high, which the robot cannot reach; allowed: 0.3 to 1.3",
    ),
    "no kind": (
        CABINET.replace('kind = "cupboard"\n', ""),
        "furniture 'cabinet': key 'kind' is missing; allowed: counter, table, shelf, cupboard",
    ),
    "opened too far": (
        CABINET + "travel = 1.0\nopened = 1.2",
        "furniture 'cabinet': opened: must not be more than travel, which is 1.0",
    ),
    "no finite number": (
        CABINET.replace("[1.0, 3.5]", "[nan, 3.5]"),
        "furniture 'cabinet': position.0: Input should be a finite number (got nan)",
    ),
    "unknown hinge": (
        CABINET + 'hinge = "top"',
        "furniture 'cabinet': hinge: Input should be 'left', 'right' or 'bottom' (got 'top')",
    ),
    "unknown furniture key": (
        CABINET + "doors = 2",
        "furniture 'cabinet': unknown key 'doors' (value 2); allowed: name, place",
    ),
    "unknown kind": (
        CABINET.replace("cupboard", "hammock"),
        "furniture 'cabinet': Input tag 'hammock' found using 'kind' does not match any of the expected tags",
    ),
    "furniture outside": (CABINET.replace("3.5]", "3.9]"), "furniture 'cabinet': position: it stands outside the room"),
    "furniture in furniture": (
        COUNTER.replace("[1.0, 3.5]", "[3.5, 2.0]"),
        "furniture 'counter': position: it overlaps 'table'",
    ),
    "drawer too wide": (
        COUNTER.replace("width = 0.4", "width = 0.9"),
        "furniture 'counter': drawers: 'cutlery' is too wide or too deep for it",
    ),
    "wrong drawer key": (
        COUNTER + "color = 1",
        "furniture 'counter': unknown key 'drawers.0.color' (value 1); allowed: name, place, x",
    ),
    "unknown top key": ("[weather]\nrain = true", "unknown key 'weather'"),
    "type too thick": (
        '[types.book]\nform = "box"\ngrasps = ["side"]\nsizes.normal = {extent = [0.15, 0.1, 0.2], mass = 0.4}',
        "types.book: sizes.normal.extent: too thick for the gripper, which holds 0.08 m",
    ),
    "type held wrongly": (
        '[types.book]\nform = "box"\ngrasps = ["rim"]\nsizes.normal = {extent = [0.15, 0.03, 0.2], mass = 0.4}',
        "types.book: grasps: a box cannot be held by 'rim'; allowed: side, top",
    ),
}


@pytest.mark.parametrize(("entry", "message"), WRONG.values(), ids=WRONG)
def test_a_wrong_entry_is_named_with_what_is_allowed(tmp_path: Path, entry: str, message: str) -> None:
    with pytest.raises(SceneError) as error:
        read(tmp_path, TABLE + entry)
    assert message in str(error.value)
    assert "my_kitchen.toml" in str(error.value)


def test_a_robot_that_would_start_in_the_table_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"robot_start: 3.0, 1.7 is inside or within 0.48 m of 'table'"):
        read(tmp_path, TABLE.replace("[1.0, 1.0, 0.0]", "[3.0, 1.7, 0.0]"))


def test_a_full_surface_is_reported(tmp_path: Path) -> None:
    many = "".join(an_object(f"plate_{i}", type="plate", size="big") for i in range(20))
    with pytest.raises(SceneError, match="there is no room left on 'table'"):
        read(tmp_path, TABLE + many)


def test_a_file_that_is_not_toml_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="not TOML"):
        read(tmp_path, "furniture = [")


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="No such file"):
        load_scene(tmp_path / "nowhere.toml")


def test_asking_for_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(KeyError, match="known: fridge, counter"):
        load_scene().surface("sofa")
