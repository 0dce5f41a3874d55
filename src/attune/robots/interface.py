"""The Robot interface: everything above it works with any implementation.

Contract for implementers:

* Every coroutine can be cancelled at every control tick. Cancelled, it brings the robot to rest within a bounded
  time, leaves it in a safe state that `status()` describes, and lets the cancellation go on. What must not be cut
  short (closing the fingers) is shielded for a bounded time, stated in the method.
* An action that cannot be done raises a `RobotFailure`; its type says what a planner can try next.
* `halt` and `resume` may be called from any thread. `halt` takes effect at the next control tick whatever the
  robot does; running actions are held, not failed: after `resume` they go on, or they are cancelled meanwhile.
* Positions are in the map frame, x, y, z in metres; angles in radians; quaternions are w, x, y, z.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from attune.core.errors import AttuneError
from attune.core.messages import ObjectSpec, Size

Arm = Literal["left", "right"]
ARMS: tuple[Arm, Arm] = ("right", "left")

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class BasePose:
    """Where the base stands: x, y [m] and yaw [rad] in the map frame."""

    x: float
    y: float
    yaw: float


@dataclass(frozen=True, slots=True)
class Pose:
    """A position [m] and an orientation (unit quaternion w, x, y, z) in the map frame."""

    position: Point
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Percept:
    """An object that the robot sees now.

    Attributes:
        name: The perception's own name for this individual; stable while the object is tracked.
        pose: Of the object's origin: the centre of its footprint, at its bottom.
        extent: Size of its bounding box along its own axes [m].
        place: Name of the furniture or compartment it rests on or in, "" when held or on the floor.
        confidence: 0 to 1.
    """

    name: str
    type: str
    color: str
    size: Size
    pose: Pose
    extent: Point
    place: str
    confidence: float = 1.0

    def matches(self, spec: ObjectSpec) -> bool:
        """Whether this fits a partial description (its `location` is not compared)."""
        return all(
            not wanted or wanted == has
            for wanted, has in (
                (spec.name, self.name), (spec.type, self.type), (spec.color, self.color), (spec.size, self.size),
            )
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class PickTarget:
    """Grasp this object where it was seen.

    `goal` is where it will be put, if that is known: a hint for choosing a grasp with which it can be put there. `arm`
    is the arm to be used, None for any free one. `without` names objects that are imagined away: could it be grasped
    if they were not there?
    """

    percept: Percept
    goal: Point | None = None
    arm: Arm | None = None
    without: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class PlaceTarget:
    """Put what `arm` holds down so that its origin (bottom centre) is at `position`, upright."""

    arm: Arm
    position: Point


@dataclass(frozen=True, slots=True)
class OpenTarget:
    """Open or close this container: the name of a compartment with a door or drawer."""

    container: str


@dataclass(frozen=True, slots=True)
class LookTarget:
    """See this point from near enough to recognise what is there.

    `hidden` are points near it that could not be seen before: poses are wanted from which they can be.
    """

    point: Point
    hidden: tuple[Point, ...] = ()


Target = PickTarget | PlaceTarget | OpenTarget | LookTarget


@dataclass(frozen=True, slots=True)
class RobotStatus:
    """What the robot knows of itself.

    Attributes:
        base: Where it stands.
        moving: Whether any joint or the base moves faster than the implementation's standstill threshold.
        halted: Whether `halt` is in force.
        holding: What each arm holds: the names of percepts.
        opened: Containers that it has opened and not closed again.
        atomic: Whether it does something that a cancellation waits for, such as closing the fingers.
    """

    base: BasePose
    moving: bool
    halted: bool
    holding: Mapping[Arm, str] = field(default_factory=dict)
    opened: frozenset[str] = frozenset()
    atomic: bool = False


class RobotFailure(AttuneError):
    """An action ended without reaching its goal. The robot is at rest and in a safe state."""

    retryable = True


class PathBlocked(RobotFailure):
    """There is no free way to the goal, or something came into the way and did not leave."""

    def __init__(self, goal: BasePose, detail: str = "") -> None:
        self.goal = goal
        super().__init__(f"no free path to x={goal.x:.2f} y={goal.y:.2f}{': ' + detail if detail else ''}")


class Unreachable(RobotFailure):
    """No arm configuration reaches the target from where the base stands."""

    def __init__(self, what: str, detail: str = "") -> None:
        super().__init__(f"{what} cannot be reached from here{': ' + detail if detail else ''}")


class GraspMissed(RobotFailure):
    """The fingers closed, but not both pads press the object."""

    def __init__(self, name: str, arm: Arm) -> None:
        super().__init__(f"the {arm} gripper did not get hold of {name}")


class ObjectLost(RobotFailure):
    """An object that should be in a gripper is not there any more."""

    def __init__(self, name: str, arm: Arm) -> None:
        self.name = name
        super().__init__(f"{name} is no longer in the {arm} gripper")


class ObjectNotThere(RobotFailure):
    """The object is not where the target says; look again."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(f"{name} is not where it was seen")


class GripperFull(RobotFailure):
    """The arm already holds something, or no arm is free."""

    retryable = False

    def __init__(self, holding: str) -> None:
        super().__init__(f"no free gripper: holding {holding}")


class PlacementFailed(RobotFailure):
    """The object was released but does not stand where it should."""

    def __init__(self, name: str, detail: str) -> None:
        super().__init__(f"{name} was put down but {detail}")


class ContainerStuck(RobotFailure):
    """A door or drawer did not open or close."""

    def __init__(self, container: str, detail: str = "") -> None:
        super().__init__(f"{container} does not move{': ' + detail if detail else ''}")


class Collision(RobotFailure):
    """The robot touched something that it must not touch."""

    def __init__(self, robot_part: str, thing: str) -> None:
        super().__init__(f"{robot_part} touched {thing}")


class UnknownTarget(RobotFailure):
    """The robot has no such thing."""

    retryable = False

    def __init__(self, kind: str, name: str, known: Sequence[str]) -> None:
        super().__init__(f"there is no {kind} {name!r}", f"Known: {', '.join(known)}")


class Robot(ABC):
    """A mobile robot with arms. See the module's docstring for the contract."""

    arms: tuple[Arm, ...] = ARMS
    """The arms it has, the preferred one first."""

    @abstractmethod
    def status(self) -> RobotStatus:
        """The robot's own state, now. Cheap; any thread."""

    @abstractmethod
    async def run(self) -> None:
        """Keep the robot alive (control ticks, connections) until cancelled. The session runs this once."""

    @abstractmethod
    async def base_poses(self, target: Target) -> Sequence[BasePose]:
        """Base poses from which the target can be reached (or seen), best first; empty when there is none.

        Each is free of collisions and has a verified arm solution for the whole action.
        """

    @abstractmethod
    async def navigate(self, goal: BasePose) -> None:
        """Drive along a free path.

        Raises:
            PathBlocked: There is none, or it was blocked on the way.
            Collision: The robot touched something.
        """

    @abstractmethod
    async def look_at(self, point: Point) -> None:
        """Turn the head towards a point, as far as its joints allow."""

    @abstractmethod
    async def perceive(self, spec: ObjectSpec = ObjectSpec()) -> tuple[Percept, ...]:
        """What the head camera sees now and fits `spec`. Takes one camera period."""

    def sees(self, points: Sequence[Point]) -> tuple[bool, ...]:
        """Which points the camera sees now: they are in its view and nothing is before or around them. Cheap.

        Where an object should be and its middle is seen, it is not there; where something hides a point, nothing can be
        said. A robot that cannot tell says that it sees all of them.
        """
        return (True,) * len(points)

    @abstractmethod
    async def open(self, container: str) -> None:
        """Open a door or drawer, from a base pose for its `OpenTarget`. Nothing happens if it is open.

        Raises:
            ContainerStuck, Unreachable, UnknownTarget, GripperFull.
        """

    @abstractmethod
    async def close(self, container: str) -> None:
        """Close a door or drawer. Raises as `open` does."""

    @abstractmethod
    async def pick(self, percept: Percept, arm: Arm | None = None, goal: Point | None = None) -> Arm:
        """Grasp and lift an object, from a base pose for its `PickTarget`. Returns the arm that holds it.

        `arm` is the one to use, `goal` the hint that `PickTarget` explains.

        Cancelled before the fingers close, the gripper is empty; after, it holds the object: see `status`.

        Raises:
            Unreachable, GraspMissed, ObjectNotThere, GripperFull, Collision.
        """

    @abstractmethod
    async def place(self, arm: Arm, position: Point) -> None:
        """Put down what `arm` holds, from a base pose for its `PlaceTarget`, let go and verify that it stands.

        Cancelled before the fingers open, the object is still held.

        Raises:
            Unreachable, ObjectLost, PlacementFailed, Collision.
        """

    @abstractmethod
    async def park_arms(self) -> None:
        """Bring the arms to a posture safe for driving; held objects stay upright."""

    @abstractmethod
    async def move_torso(self, height: float) -> None:
        """Lift the torso to `height` [m] above its lowest position."""

    @abstractmethod
    def halt(self) -> None:
        """Stop all commanded motion at the next control tick. Idempotent; any thread."""

    @abstractmethod
    def resume(self) -> None:
        """End a halt. Held actions go on. Idempotent; any thread."""
