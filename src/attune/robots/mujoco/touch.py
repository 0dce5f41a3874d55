"""What the robot and what it carries touch: forces at the pads, and contacts that should not be."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from attune.core.scene import Scene
from attune.robots.interface import ARMS, Arm
from attune.robots.mujoco import contact, pr2
from attune.robots.mujoco.kitchen import handle_name, leaf_name

FLOOR = "floor"
"""What the floor is called as a thing that is touched."""
_LEFT = 15
"""Updates without a contact after which something carried has left what it stood on: it may rattle when lifted."""
_UPWARD = 0.7
"""Vertical share of the normal of a contact with what something stands on, at least."""
_ARM_BITS: Mapping[Arm, int] = {"right": contact.RIGHT_ARM, "left": contact.LEFT_ARM}


class Touch:
    """The robot's contacts as they were at the last update."""

    def __init__(self, model: Any, scene: Scene) -> None:
        self._model = model
        things = {leaf_name(box.name): box.name for box in scene.containers}
        bodies = [model.body(body).name for body in range(model.nbody)]
        geom_body = [bodies[body] for body in model.geom_bodyid]
        self._name = [things.get(body, body) if body != "world" else FLOOR for body in geom_body]
        self._robot: list[bool] = np.isin(model.geom_contype, (contact.TRUNK, *_ARM_BITS.values())).tolist()
        self._pads = {arm: [model.geom(pad).id for pad in pr2.PADS[arm]] for arm in ARMS}
        self._arm: list[Arm | None] = [None] * model.ngeom
        for arm, bit in _ARM_BITS.items():
            for geom in np.flatnonzero(model.geom_contype == bit):
                self._arm[geom] = arm
        self._hand = ["gripper" in body for body in geom_body]
        handles = {model.geom(handle_name(box.name)).id for box in scene.containers}
        objects = {thing.name for thing in scene.objects}
        self._graspable = [geom in handles or body in objects for geom, body in enumerate(geom_body)]
        self._permitted: dict[Arm, frozenset[str]] = dict.fromkeys(ARMS, frozenset())
        self._contacts: list[tuple[int, int]] = []
        self._lowered: Arm | None = None
        self._standing: dict[str, tuple[frozenset[str], int]] = {}
        self._bumps: dict[tuple[str, str], None] = {}
        self._forces: dict[Arm, dict[str, list[float]]] = {arm: {} for arm in ARMS}

    def update(self, data: Any, held: Mapping[Arm, str | None]) -> None:
        """Read the contacts of the robot with everything else and with itself, and of what each arm holds."""
        touching: list[tuple[int, int, int]] = []
        if data.ncon:
            # They are few, and read at every tick: lists are faster than arrays.
            pairs, distances = data.contact.geom.tolist(), data.contact.dist.tolist()
            touching = [
                (index, *pair) for index, (pair, away) in enumerate(zip(pairs, distances, strict=True)) if away <= 0.0
            ]
        self._contacts = []
        self._forces = {arm: {} for arm in ARMS}
        self._update_carried(data, held, touching)
        for index, first, second in touching:
            if self._robot[first]:
                self._update_robot(data, index, first, second)
            elif self._robot[second]:
                self._update_robot(data, index, second, first)

    def _update_robot(self, data: Any, index: int, part: int, other: int) -> None:
        self._contacts.append((part, other))
        arm = self._arm[part]
        if arm and part in self._pads[arm] and self._graspable[other]:
            force = np.zeros(6)
            mujoco.mj_contactForce(self._model, data, index, force)
            forces = self._forces[arm].setdefault(self._name[other], [0.0, 0.0])
            forces[self._pads[arm].index(part)] += float(force[0])

    def _update_carried(
        self, data: Any, held: Mapping[Arm, str | None], touching: Sequence[tuple[int, int, int]]
    ) -> None:
        """Find what carried objects bump into: all that they touch but what they are lifted from or put down on."""
        self._bumps = {}
        self._standing = {name: stood for name, stood in self._standing.items() if name in held.values()}
        for arm, name in held.items():
            if name is None:
                continue
            others: dict[str, float] = {}
            for index, *pair in touching:
                for mine, other in (pair, pair[::-1]):
                    if self._name[mine] == name and not self._robot[other]:
                        others[self._name[other]] = abs(float(data.contact.frame[index, 2]))
            stood_on, away = self._standing.get(name, (frozenset(), 0))
            if not stood_on and away < _LEFT:  # The fingers may have lifted it a little when they closed.
                stood_on = frozenset(others)
            away = 0 if stood_on & others.keys() else away + 1
            self._standing[name] = (stood_on if away < _LEFT else frozenset(), away)
            for thing, upward in others.items():
                put_down = arm == self._lowered and upward > _UPWARD
                if thing not in stood_on and not put_down:
                    self._bumps[name, thing] = None

    @property
    def bumps(self) -> tuple[tuple[str, str], ...]:
        """What carried objects touch that they should not: object, thing; without duplicates."""
        return tuple(self._bumps)

    def lower(self, arm: Arm | None) -> None:
        """What this arm carries may now be set on something; None ends it."""
        self._lowered = arm

    def pad_forces(self, arm: Arm) -> Mapping[str, tuple[float, float]]:
        """What the pads press: name, and force of left and right pad [N]."""
        return {name: (left, right) for name, (left, right) in self._forces[arm].items()}

    def pressed_by_both(self, arm: Arm, force: float) -> str | None:
        """The object or container's handle that both pads press with more than `force` [N]."""
        pressed = [name for name, (left, right) in self._forces[arm].items() if min(left, right) > force]
        return pressed[0] if pressed else None

    def permit(self, arm: Arm, things: Iterable[str]) -> None:
        """Set what the arm's hand may touch."""
        self._permitted[arm] = frozenset(things)

    def forbidden(self, held: Mapping[Arm, str | None]) -> tuple[tuple[str, str], ...]:
        """Contacts that are not permitted: robot part, thing; without duplicates.

        Args:
            held: What each arm holds. The robot may touch it anywhere: a box in the hand that brushes the torso stays
                in the hand, while a robot that called this a collision could never move again.
        """
        found: dict[tuple[str, str], None] = {}
        carried = {name for name in held.values() if name is not None}
        for part, other in self._contacts:
            arm, thing = self._arm[part], self._name[other]
            permitted = thing in carried or (arm and self._hand[part] and thing in self._permitted[arm])
            if not permitted:
                found[self._name[part], thing] = None
        return tuple(found)
