import pytest
from pydantic import ValidationError

from attune.core.shapes import Dimensions, ObjectType, standard_types


def test_the_twelve_types_of_the_design_exist() -> None:
    assert set(standard_types()) == {
        "milk", "bowl", "cereal", "spoon", "cup", "plate", "bread", "knife", "fork", "glass", "juice", "mug",
    }  # fmt: skip


def test_every_standard_type_comes_in_three_sizes_that_differ() -> None:
    for kind in standard_types().values():
        volumes = [kind.sizes[size].extent for size in ("small", "normal", "big")]
        assert volumes == sorted(volumes)
        assert len(set(volumes)) == 3


@pytest.mark.parametrize(("depth", "fits"), [(0.08, True), (0.081, False)])
def test_one_side_of_a_box_must_fit_between_the_fingers(depth: float, *, fits: bool) -> None:
    def make() -> ObjectType:
        size = Dimensions(extent=(0.15, depth, 0.2), mass=0.3)
        return ObjectType(form="box", grasps=("side",), sizes={"normal": size})

    if fits:
        assert make().shape("normal").grasps == ("side",)
    else:
        with pytest.raises(ValidationError, match=r"too thick for the gripper, which holds 0.08 m"):
            make()


def test_a_round_thing_must_be_round() -> None:
    with pytest.raises(ValidationError, match="a cylinder is round, so x and y must be equal"):
        ObjectType(form="cylinder", grasps=("side",), sizes={"normal": Dimensions(extent=(0.05, 0.06, 0.1), mass=0.3)})


def test_what_is_too_heavy_for_an_arm_is_refused() -> None:
    with pytest.raises(ValidationError, match="less than or equal to 2"):
        Dimensions(extent=(0.05, 0.05, 0.1), mass=3.0)
