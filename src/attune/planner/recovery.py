"""Recovery chosen by the type of the failure, and what a failure is called when it is told to the user."""

from collections.abc import Callable, Mapping
from typing import Any

from attune.core.errors import AttuneError
from attune.core.messages import ObjectSpec, OutcomeReason
from attune.planner.belief import Individual
from attune.planner.combinators import Recovery
from attune.planner.plan import Node, Part, PlanFailure
from attune.planner.skills import Skills
from attune.robots.interface import (
    Collision,
    ContainerStuck,
    GraspMissed,
    GripperFull,
    ObjectLost,
    ObjectNotThere,
    PathBlocked,
    PlacementFailed,
    Unreachable,
)

WAIT_FOR_PATH = 2.0
"""Before a blocked path is planned again: what stands there may leave [s]."""


class NotFound(PlanFailure):
    """An object is nowhere where it might be.

    Args:
        spec: What was searched.
        because: Why a place where it may be could not be searched, if one could not.
        behind: What it may be hidden by, if there is something behind which the robot could not see.
    """

    def __init__(self, spec: ObjectSpec, because: AttuneError | None = None, behind: ObjectSpec | None = None) -> None:
        self.because = because
        self.behind = behind
        super().__init__(f"no {spec} was found{' in the ' + spec.location if spec.location else ''}")


class NoSpace(PlanFailure):
    """There is no free spot to put something down."""

    def __init__(self, place: str) -> None:
        super().__init__(f"there is no free spot on the {place}")


_REASONS: tuple[tuple[type[AttuneError], OutcomeReason], ...] = (
    (NotFound, "not_found"),
    (ObjectNotThere, "not_found"),
    (NoSpace, "no_space"),
    (Unreachable, "unreachable"),
    (GraspMissed, "grasp_failed"),
    (ObjectLost, "dropped"),
    (PlacementFailed, "dropped"),
    (PathBlocked, "blocked"),
    (ContainerStuck, "blocked"),
)


def reason_of(failure: AttuneError) -> OutcomeReason:
    """What a failure is called towards the user."""
    if isinstance(failure, NotFound) and failure.because:
        return reason_of(failure.because)
    return next((reason for type_, reason in _REASONS if isinstance(failure, type_)), "robot_fault")


def recoveries(
    skills: Skills, clear_way: Callable[[], Part[None]], make_room: Callable[[], Part[None]]
) -> Mapping[type[AttuneError], Recovery]:
    """What is done after each type of failure, before the delivery is tried again from the world as it is.

    The next attempt uses the other arm and computes new base poses anyway; what is here is what that attempt
    needs to find: a true belief, a robot that is free to move, and nothing in the way.

    Args:
        skills: The robot.
        clear_way: Moves aside what is in the way of the object, if something is.
        make_room: Moves aside what takes up the room at the destination.
    """

    def part(name: str, body: Any) -> Part[None]:
        async def recovering(node: Node) -> None:
            skills.board.update(step="recovering")
            await body(node)

        return Part(name, recovering)

    def search_again(failure: ObjectNotThere) -> Part[None]:
        async def body(_: Node) -> None:
            skills.belief.vanished(failure.name)

        return part(f"forget where {failure.name} was", body)

    def look_for_lost(failure: ObjectLost) -> Part[None]:
        async def body(node: Node) -> None:
            skills.belief.vanished(failure.name)
            if skills.placing:
                await node.do(skills.look_over(skills.placing.surface, _named(failure.name)))

        return part(f"look for {failure.name}", body)

    def look_at_placed(_: PlacementFailed) -> Part[None]:
        async def body(node: Node) -> None:
            holding = skills.robot.status().holding
            for arm, item in skills.belief.held().items():
                if holding.get(arm) != item.name and skills.placing:
                    skills.belief.vanished(item.name)
                    await node.do(skills.look_over(skills.placing.surface, _named(item.name)))

        return part("look how it stands", body)

    def wait_for_path(_: PathBlocked) -> Part[None]:
        async def body(_: Node) -> None:
            await skills.clock.sleep(WAIT_FOR_PATH)

        return part("wait for the way to be free", body)

    def draw_back(_: AttuneError) -> Part[None]:
        async def body(_: Node) -> None:
            await skills.robot.park_arms()

        return part("draw the arms back", body)

    def draw_back_and_clear(_: Unreachable) -> Part[None]:
        async def body(node: Node) -> None:
            await skills.robot.park_arms()
            await node.do(clear_way())

        return part("draw the arms back and see what is in the way", body)

    def move_something(_: NoSpace) -> Part[None]:
        async def body(node: Node) -> None:
            await node.do(make_room())

        return part("make room", body)

    def draw_back_and_look(_: Collision) -> Part[None]:
        async def body(node: Node) -> None:
            await skills.robot.park_arms()
            await node.do(skills.look_around())  # Something stands or lies there that was not seen before.
            if skills.placing:
                await node.do(skills.look_over(skills.placing.surface, lambda item: False))

        return part("draw the arms back and look around", body)

    return {
        ObjectNotThere: Recovery(search_again, 4),
        ObjectLost: Recovery(look_for_lost, 3),
        PlacementFailed: Recovery(look_at_placed, 3),
        PathBlocked: Recovery(wait_for_path, 2),
        GraspMissed: Recovery(draw_back, 4),
        Unreachable: Recovery(draw_back_and_clear, 2),
        NoSpace: Recovery(move_something, 2),
        ContainerStuck: Recovery(draw_back, 2),
        Collision: Recovery(draw_back_and_look, 3),
        GripperFull: Recovery(draw_back, 1),
    }


def _named(name: str) -> Any:
    def found(item: Individual) -> bool:
        return item.name == name

    return found
