"""The robot's own copy of the kitchen, in which it tries motions before it makes them.

It is the simulation's model with objects where the robot believes them to be, and with wider geoms. What the robot does
not know of is not there. Furniture and believed objects never touch each other here; only contacts of the robot, and of
what it carries, are looked for.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from attune.robots.interface import ARMS, Arm, Pose
from attune.robots.mujoco import contact, pr2
from attune.robots.mujoco.frames import Frame
from attune.robots.mujoco.imagined_state import AWAY, ImaginedState
from attune.robots.mujoco.kitchen import handle_name
from attune.robots.mujoco.solids import Solid, solids

Array = NDArray[np.float64]

MARGIN = 0.004
"""Kept between the arms and everything else [m]."""
_FINGER_MARGIN = 0.002
"""The fingers must come near to what they grasp [m]."""
_TRUNK_MARGIN = 0.006
"""Kept in addition from the robot's own trunk, also by what it carries [m]."""
_OBJECT_MARGIN = 0.004
"""Kept in addition from objects, whose places are known only so well [m]."""
_GIVE = 0.012
"""How much farther the gap may close between the first pad's touch and the second's [m]."""
_ARM_BITS: Mapping[Arm, int] = {"right": contact.RIGHT_ARM, "left": contact.LEFT_ARM}
_CARRIED_BITS: Mapping[Arm, int] = {"right": 32, "left": 64}
"""With which what an arm carries meets the arm itself, the hand excepted."""


class Imagination(ImaginedState):
    """An imagined state, and what is too near to what in it.

    Attributes:
        checks: Collision checks made so far: the measure of a search's work.
    """

    def __init__(
        self, model: Any, qpos: Array, objects: Mapping[str, Pose], carried: Mapping[Arm, tuple[str, Frame]]
    ) -> None:
        super().__init__(model, qpos, objects, carried)
        self.checks = 0
        self._rubbed = (-1, 0.0)
        self._set_contacts()

    def _set_contacts(self) -> None:
        m = self.model
        robot = np.isin(m.geom_contype, (contact.TRUNK, *_ARM_BITS.values()))
        others = ~robot & (m.geom_contype > 0)
        m.geom_conaffinity[others] = 0
        m.geom_margin[:] = 0.0
        m.geom_margin[m.geom_contype == contact.OBJECT] = _OBJECT_MARGIN
        m.geom_margin[np.isin(m.geom_contype, tuple(_ARM_BITS.values()))] = MARGIN
        m.geom_margin[m.geom_contype == contact.TRUNK] = _TRUNK_MARGIN
        self._fingers = [m.jnt_bodyid[m.joint(joint).id] for arm in ARMS for joint in pr2.FINGER_JOINTS[arm]]
        m.geom_margin[np.isin(m.geom_bodyid, self._fingers)] = _FINGER_MARGIN
        meets = contact.FURNITURE | contact.OBJECT | contact.TRUNK
        for arm in self.carried:
            m.geom_conaffinity[self._links(arm)] |= _CARRIED_BITS[arm]
        for arm, (name, _) in self.carried.items():
            other = contact.LEFT_ARM if arm == "right" else contact.RIGHT_ARM
            for geom in np.flatnonzero(m.geom_bodyid == m.body(name).id):
                if m.geom_contype[geom]:
                    m.geom_contype[geom] = _ARM_BITS[arm] | _CARRIED_BITS[arm]
                    m.geom_conaffinity[geom] = meets | other
                    m.geom_margin[geom] = MARGIN / 2
        self._tell_bodies_margins()
        m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_WARMSTART
        self._tell_bodies_contacts()

    def _tell_bodies_contacts(self) -> None:
        """After geoms' bits were changed: MuJoCo first compares those of bodies. What is unknown meets nothing."""
        m = self.model
        unknown = self.unknown - {m.body(name).id for name, _ in self.carried.values()}
        for of_body, of_geom in ((m.body_contype, m.geom_contype), (m.body_conaffinity, m.geom_conaffinity)):
            of_body[:] = 0
            np.bitwise_or.at(of_body, m.geom_bodyid, of_geom)
            of_body[list(unknown)] = 0

    def put(self, name: str, frame: Frame) -> None:
        """Put an object somewhere; from now on the robot knows of it."""
        unknown = self.model.body(name).id in self.unknown
        super().put(name, frame)
        if unknown:
            self._tell_bodies_contacts()

    def _tell_bodies_margins(self) -> None:
        """After geoms' margins were changed: MuJoCo compares only bodies whose boxes, grown by theirs, overlap."""
        margins = np.zeros(self.model.nbody)
        np.maximum.at(margins, self.model.geom_bodyid, self.model.geom_margin)
        self.model.body_margin[:] = margins

    def _links(self, arm: Arm) -> NDArray[np.bool_]:
        """Which geoms belong to an arm without its hand."""
        m = self.model
        before_hand = m.geom_bodyid < m.body(pr2.PALM[arm]).id
        own = m.body_rootid[m.geom_bodyid] == self.robot_root
        return np.asarray((m.geom_contype == _ARM_BITS[arm]) & before_hand & own)

    def ignore_handle(self, container: str, *, ignored: bool = True) -> None:
        """Let the hand touch a container's handle, or no longer."""
        self.model.geom_contype[self.model.geom(handle_name(container)).id] = 0 if ignored else contact.FURNITURE

    def widen_arm(self, arm: Arm, margin: float = MARGIN) -> None:
        """Set how far an arm without its hand keeps from everything [m]; without a margin, the usual one."""
        m = self.model
        hand = m.body(pr2.PALM[arm]).id
        links = (m.geom_contype == _ARM_BITS[arm]) & (m.geom_bodyid < hand)
        links &= m.body_rootid[m.geom_bodyid] == self.robot_root
        m.geom_margin[links] = margin
        self._tell_bodies_margins()

    def crowded(self, arm: Arm, path: Array, room: float) -> tuple[int, int]:
        """At how many points of a path something is near to an arm or to what it carries, and at how many too near.

        Args:
            arm: The arm.
            path: Configurations, shape (n, 7).
            room: How much farther away than it must be what counts as near is [m].
        """
        with self.roomier(arm, room):
            near = [q for q in path if not self._free_at(arm, q)]
        return len(near), sum(not self._free_at(arm, q) for q in near)

    @contextmanager
    def roomier(self, arm: Arm, room: float) -> Iterator[None]:
        """For a while, an arm and what it carries keep so much farther away from things than usual [m]."""
        m, usual = self.model, self.model.geom_margin.copy()
        m.geom_margin[(m.geom_contype & _ARM_BITS[arm]) > 0] += room
        self._tell_bodies_margins()
        try:
            yield
        finally:
            m.geom_margin[:] = usual
            self._tell_bodies_margins()

    def widen_carried(self, arm: Arm, margin: float = MARGIN / 2) -> None:
        """Set how far what an arm carries keeps from everything [m]; without a margin, the usual one."""
        body = self.model.body(self.carried[arm][0]).id
        self.model.geom_margin[(self.model.geom_bodyid == body) & (self.model.geom_contype > 0)] = margin
        self._tell_bodies_margins()

    def widen_objects(self, margin: float = _OBJECT_MARGIN) -> None:
        """Set how far the robot and what it carries keep from objects [m]; without a margin, the usual distance."""
        self.model.geom_margin[self.model.geom_contype == contact.OBJECT] = margin
        self._tell_bodies_margins()

    def let_brush(self, arm: Arm) -> None:
        """If what an arm carries lies against the robot now, let it: no path could begin there otherwise."""
        m, body = self.model, self.model.body(self.carried[arm][0]).id
        self._collide()
        pairs = self.data.contact.geom
        carried, robot = m.geom_bodyid[pairs] == body, m.body_rootid[m.geom_bodyid[pairs]] == self.robot_root
        if not (carried[:, 0] & robot[:, 1] | carried[:, 1] & robot[:, 0]).any():
            return
        # Without a type of its own it still meets what it is set to meet: furniture, objects and the other arm.
        geoms = (m.geom_bodyid == body) & (m.geom_contype > 0)
        m.geom_contype[geoms] = 0
        m.geom_conaffinity[geoms] &= ~contact.TRUNK
        self._tell_bodies_contacts()

    def aim_at(self, name: str, rub: float = 0.0) -> None:
        """Let the robot come as near to an object as its fingers must, until `keep_clear`.

        Args:
            name: The object.
            rub: How far a finger may give way to it [m]: one that was grasped off centre is rubbed when it is let go.
        """
        body = self.model.body(name).id
        # Distances are wrong where margins add up to less than nothing, so what may be rubbed is sorted out in `free`.
        self.model.geom_margin[self.model.geom_bodyid == body] = -_FINGER_MARGIN if rub else 0.0
        self._tell_bodies_margins()
        self._rubbed = (body, rub)

    def keep_clear(self, name: str) -> None:
        """End `aim_at`."""
        self.model.geom_margin[self.model.geom_bodyid == self.model.body(name).id] = _OBJECT_MARGIN
        self._tell_bodies_margins()
        self._rubbed = (-1, 0.0)

    def contacts(self) -> list[tuple[str, str, float]]:
        """Pairs of bodies that are nearer to each other than their margin now, with their distance [m]."""
        self._collide()
        m, touching = self.model, self.data.contact
        return [
            (m.body(m.geom_bodyid[a]).name, m.body(m.geom_bodyid[b]).name, float(distance))
            for (a, b), distance, margin in zip(touching.geom, touching.dist, touching.includemargin, strict=True)
            if distance < margin
        ]

    def free(self) -> bool:
        """Whether the robot and what it carries touch nothing."""
        self._collide()
        if not self.data.ncon or not self._rubbed[1]:
            return bool(self.data.ncon == 0)
        body, rub = self._rubbed
        pairs = self.model.geom_bodyid[self.data.contact.geom]
        rubbing = (pairs == body).any(axis=1) & np.isin(pairs, self._fingers).any(axis=1)
        return bool((rubbing & (self.data.contact.dist > -rub)).all())

    def clear_of_itself(self) -> bool:
        """Whether robot and carried objects touch nothing of themselves, whatever else they touch."""
        self._collide()
        m = self.model
        near = self.data.contact.dist < self.data.contact.includemargin
        bodies = m.geom_bodyid[self.data.contact.geom[near]]
        own = [m.body(name).id for name, _ in self.carried.values()]
        return not bool(((m.body_rootid[bodies] == self.robot_root) | np.isin(bodies, own)).all(axis=1).any())

    def hand_free(self, arm: Arm) -> bool:
        """Whether an arm's hand and what it carries touch neither furniture nor objects, wherever the robot stands."""
        self._collide()
        m = self.model
        near = self.data.contact.dist < self.data.contact.includemargin
        bodies = m.geom_bodyid[self.data.contact.geom[near]]
        hand = [m.body(pr2.PALM[arm]).id, *(m.jnt_bodyid[m.joint(name).id] for name in pr2.FINGER_JOINTS[arm])]
        if arm in self.carried:
            hand.append(m.body(self.carried[arm][0]).id)
        foreign = m.body_rootid[bodies] != self.robot_root
        return not bool((np.isin(bodies, hand) & foreign[:, ::-1]).any())

    def all_free(self, arm: Arm, path: Array) -> bool:
        """Whether an arm can take all configurations of `path`, shape (n, 7). It keeps the last one tried."""
        return all(self._free_at(arm, q) for q in path)

    def _free_at(self, arm: Arm, q: Array) -> bool:
        self.set_arm(arm, q)
        return self.free()

    def pads_meet(self, arm: Arm, name: str) -> float | None:
        """The gap at which both pads would press an object if the fingers closed now [m]; None if they would not.

        The fingers are coupled and the object gives way a little, so the second pad may come a little later.
        """
        pads = [self.model.geom(pad).id for pad in pr2.PADS[arm]]
        body = self.model.body(name).id
        limit = -np.inf
        for gap in np.linspace(pr2.GRIPPER_OPEN, 0.0, 35):
            self.set_gripper(arm, float(gap))
            self._collide()
            touched = set()
            for a, b in self.data.contact.geom:
                for pad, other in ((a, b), (b, a)):
                    if pad in pads and self.model.geom_bodyid[other] == body:
                        touched.add(pad)
            if len(touched) == 2:
                return float(gap)
            if gap < limit:
                return None
            if touched:
                limit = max(limit, gap - _GIVE)
        return None

    def _collide(self) -> None:
        self.checks += 1
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)

    def obstacle_boxes(self, without: str) -> tuple[Array, Array, Array]:
        """Boxes inside furniture and objects: centres (n, 3), rotations (n, 3, 3), half lengths (n, 3), map frame.

        Args:
            without: An object that does not count.
        """
        mujoco.mj_kinematics(self.model, self.data)
        m, d = self.model, self.data
        solid = np.isin(m.geom_contype, (contact.FURNITURE, contact.OBJECT)) & (m.geom_bodyid != m.body(without).id)
        cylinder = m.geom_type == mujoco.mjtGeom.mjGEOM_CYLINDER
        boxes = np.flatnonzero(solid & (cylinder | (m.geom_type == mujoco.mjtGeom.mjGEOM_BOX)))
        round_ = np.column_stack((m.geom_size[:, 0], m.geom_size[:, 0], np.sqrt(2) * m.geom_size[:, 1])) / np.sqrt(2)
        halves = np.where(cylinder[:, None], round_, m.geom_size)[boxes]
        return d.geom_xpos[boxes].copy(), d.geom_xmat[boxes].reshape(-1, 3, 3).copy(), halves

    def body_solids(self) -> list[Solid]:
        """Robot and carried objects in the base's frame."""
        mujoco.mj_kinematics(self.model, self.data)
        m, base = self.model, self.base
        bits = contact.TRUNK | contact.RIGHT_ARM | contact.LEFT_ARM
        return solids(m, self.data, np.flatnonzero(m.geom_contype & bits), (base.x, base.y, base.yaw))

    def obstacle_solids(self) -> list[Solid]:
        """Furniture and believed objects in the map frame."""
        mujoco.mj_kinematics(self.model, self.data)
        m = self.model
        here = self.data.geom_xpos[:, 0] < AWAY - 1
        return solids(m, self.data, np.flatnonzero(here & np.isin(m.geom_contype, (contact.FURNITURE, contact.OBJECT))))
