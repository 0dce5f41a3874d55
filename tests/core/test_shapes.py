import pytest
from pydantic import ValidationError

from attune.core.shapes import FINGERTIP, WIDEST_GRIP, Dimensions, ObjectType, standard_types

ALL = [(name, size) for name, kind in standard_types().items() for size in kind.sizes]


@pytest.mark.parametrize(("name", "size"), ALL)
def test_every_standard_object_can_be_held(name: str, size: str) -> None:
    shape = standard_types()[name].shape(size)  # type: ignore[arg-type]
    assert shape.grasps
    for grasp in shape.grasps:
        assert 0.0 < grasp.width <= WIDEST_GRIP
        assert grasp.height < shape.extent[2] + FINGERTIP
        if grasp.kind != "side":
            assert grasp.height > FINGERTIP, "the fingertips stay over what it stands on"


def test_the_twelve_types_of_the_design_exist() -> None:
    assert set(standard_types()) == {
        "milk", "bowl", "cereal", "spoon", "cup", "plate", "bread", "knife", "fork", "glass", "juice", "mug",
    }  # fmt: skip


def test_every_standard_type_comes_in_three_sizes_that_differ() -> None:
    for kind in standard_types().values():
        volumes = [kind.sizes[size].extent for size in ("small", "normal", "big")]
        assert volumes == sorted(volumes)
        assert len(set(volumes)) == 3


def test_a_box_is_held_across_each_side_that_is_thin_enough() -> None:
    box = ObjectType(form="box", grasps=("side",), sizes={"normal": Dimensions(extent=(0.15, 0.06, 0.2), mass=0.3)})
    assert [(grasp.across, grasp.width) for grasp in box.shape("normal").grasps] == [("y", 0.06)]


def test_a_round_thing_must_be_round() -> None:
    with pytest.raises(ValidationError, match="a cylinder is round, so x and y must be equal"):
        ObjectType(form="cylinder", grasps=("side",), sizes={"normal": Dimensions(extent=(0.05, 0.06, 0.1), mass=0.3)})


def test_what_is_too_heavy_for_an_arm_is_refused() -> None:
    with pytest.raises(ValidationError, match="less than or equal to 2"):
        Dimensions(extent=(0.05, 0.05, 0.1), mass=3.0)
