"""A placeholder for perception, with the parameters of a real one: it sees only what the head camera could see.

An object is reported when enough points of it are inside the view frustum, within range, and not hidden behind
furniture, other objects or the robot's own arms. What is reported is noisy and sometimes missing, as configured.
Telling individuals apart is taken for granted: an object's name in the scene is its name here.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import sqrt
from typing import Any, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from attune.core.messages import ObjectSpec
from attune.robots.interface import Percept, Point, Pose
from attune.robots.mujoco import pr2
from attune.robots.mujoco.contact import VISUAL_GROUP
from attune.robots.mujoco.world import World

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

PERIOD = 0.1
"""Time the camera and the recognition take for one look [s]."""
_SAMPLES = np.array([*product((-0.35, 0.35), (-0.35, 0.35), (0.15, 0.85)), (0, 0, 0.5), (0, 0, 0.9)])
"""Points of an object that are looked for, in units of its extent, from its bottom centre."""
_TOLERANCE = 0.005


@dataclass(frozen=True, slots=True)
class CameraSettings:
    """What the camera and the recognition are capable of.

    Attributes:
        nearest: Of the camera's range [m].
        farthest: At which an object is recognised [m].
        least_visible: Share of an object that must be visible, 0 to 1.
        noise: Standard deviation of the reported position, along each axis [m].
        miss: Probability that a visible object is not reported, in one look.
    """

    nearest: float = 0.3
    farthest: float = 3.0
    least_visible: float = 0.35
    noise: float = 0.002
    miss: float = 0.0


class Perception:
    """The head camera's view.

    Args:
        world: What there is to see.
        settings: How well it sees.
        seed: Of noise and misses.
    """

    def __init__(self, world: World, settings: CameraSettings = CameraSettings(), *, seed: int = 0) -> None:
        self._world = world
        self._settings = settings
        self._random = np.random.default_rng(seed)
        model = world.model
        self._camera = model.camera(pr2.HEAD_CAMERA).id
        self._head = model.cam_bodyid[self._camera]
        width, height = model.cam_resolution[self._camera]
        upwards = np.tan(np.radians(model.cam_fovy[self._camera]) / 2)
        self._half_view = np.array([upwards * width / height, upwards])
        self._seen_groups = np.array([group != VISUAL_GROUP for group in range(6)], dtype=np.uint8)

    def look(self, spec: ObjectSpec = ObjectSpec()) -> tuple[Percept, ...]:
        """What is seen now and fits a partial description (its `location` is not compared)."""
        percepts = []
        for name in self._world.object_names:
            # Drawn for each object, seen or not, so that one object does not change the luck of the next.
            noise = self._random.normal(0.0, 1.0, 3) * self._settings.noise
            missed = self._random.random() < self._settings.miss
            with self._world.lock:
                share = self.visible_share(name)
                if missed or share < self._settings.least_visible:
                    continue
                percept = self._percept(name, noise, share)
            if percept.matches(spec):
                percepts.append(percept)
        return tuple(percepts)

    def visible_share(self, name: str) -> float:
        """Share of an object's sample points that the camera sees now, 0 to 1."""
        with self._world.lock:
            body = self._world.data.body(name)
            points = body.xpos + (_SAMPLES * self._world.extent(name)) @ body.xmat.reshape(3, 3).T
            return float(np.mean(self._sees(points, self._world.model.body(name).id)))

    def sees(self, points: Sequence[Point]) -> tuple[bool, ...]:
        """Which points are in view, with nothing between them and the camera, as a depth camera would measure it."""
        with self._world.lock:
            return tuple(self._sees(np.array(points).reshape(-1, 3), -1).tolist())

    def _sees(self, points: Array, body: int) -> Mask:
        """Which points are in view, and hidden by nothing but `body` itself."""
        model, data = self._world.model, self._world.data
        eye, rotation = data.cam_xpos[self._camera], data.cam_xmat[self._camera].reshape(3, 3)
        rays = points - eye
        in_camera = rays @ rotation
        ahead = -in_camera[:, 2]
        distance = np.linalg.norm(rays, axis=1)
        in_view = (np.abs(in_camera[:, :2]) <= ahead[:, None] * self._half_view).all(axis=1)
        in_view &= (distance >= self._settings.nearest) & (distance <= self._settings.farthest)
        if not in_view.any():
            return cast("Mask", in_view)
        hit, reach = self._cast(model, data, eye, rays / distance[:, None])
        hidden = (hit >= 0) & (reach < distance - _TOLERANCE) & (model.geom_bodyid[hit] != body)
        return cast("Mask", in_view & ~hidden)

    def _cast(self, model: Any, data: Any, eye: Array, rays: Array) -> tuple[NDArray[np.int32], Array]:
        hit, reach = np.full(len(rays), -1, dtype=np.int32), np.zeros(len(rays))
        cutoff = self._settings.farthest
        groups, head = self._seen_groups, self._head
        mujoco.mj_multiRay(model, data, eye, rays.flatten(), groups, True, head, hit, reach, None, len(rays), cutoff)
        return hit, reach

    def _percept(self, name: str, noise: Array, share: float) -> Percept:
        thing, pose = self._world.scene.object(name), self._world.object_pose(name)
        x, y, z = (float(value) for value in np.array(pose.position) + noise)
        return Percept(
            name=name,
            type=thing.type,
            color=thing.color,
            size=thing.size,
            pose=Pose((x, y, z), pose.orientation),
            extent=self._world.extent(name),
            place=self._world.place_of(name),
            confidence=round(sqrt(share), 3),
        )
