"""Random sequences of commands, stops, moved objects and failures, with physics; what must hold after each."""

import math

import hypothesis
import pytest
from hypothesis import strategies as st

from attune.core.bus import COMMAND, ROBOT_STOP
from attune.core.config import RobotConfig
from attune.core.messages import (
    BringMe,
    CancelObject,
    CarryOn,
    ChangeLocation,
    ObjectSpec,
    PutBack,
    ReplaceObject,
    Stop,
    StopSignal,
)
from attune.core.scene import load_scene
from attune.evaluation.kitchen import Kitchen
from attune.robots.interface import Collision, GraspMissed, Unreachable
from attune.robots.mujoco import pr2
from attune.robots.mujoco.robot import MujocoRobot

SCENE = load_scene()
STILL = 0.01
"""A robot stands still when no joint moves faster [m/s or rad/s]."""
INSIDE = 0.005
"""Objects that overlap by more than this are in each other [m]."""

SPECS = st.sampled_from(
    [ObjectSpec(type="cup"), ObjectSpec(type="milk"), ObjectSpec(type="bowl"), ObjectSpec(type="glass", color="red")]
)
COMMANDS = st.one_of(
    st.builds(BringMe, time=st.just(0.0), objects=st.tuples(SPECS), destination=st.sampled_from(["", "countertop"])),
    st.builds(ReplaceObject, time=st.just(0.0), remove=SPECS, add=SPECS),
    st.builds(ChangeLocation, time=st.just(0.0), destination=st.sampled_from(["table", "countertop", "moon"])),
    st.builds(CancelObject, time=st.just(0.0), object=SPECS),
    st.builds(PutBack, time=st.just(0.0)),
    st.builds(CarryOn, time=st.just(0.0)),
    st.builds(Stop, time=st.just(0.0)),
)
SIGNALS = st.sampled_from(["spotted", "confirmed", "withdrawn"])
FAULTS = st.sampled_from(
    [
        ("pick", GraspMissed("it", "right")),
        ("pick", Unreachable("it")),
        ("place", Unreachable("it")),
        ("place", Collision("arm", "it")),
    ]
)
MOVES = st.tuples(
    st.sampled_from(["red_cup", "blue_milk", "white_bowl", "what is held"]), st.sampled_from(["counter", "island", ""])
)
EVENTS = st.tuples(st.one_of(COMMANDS, SIGNALS, FAULTS, MOVES), st.floats(0.0, 40.0))


class ClumsyRobot(MujocoRobot):
    """The PR2, told to fail."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.faults = {"pick": [], "place": []}

    async def pick(self, percept, arm=None, goal=None):
        if self.faults["pick"]:
            raise self.faults["pick"].pop(0)
        return await super().pick(percept, arm, goal)

    async def place(self, arm, position):
        if self.faults["place"]:
            raise self.faults["place"].pop(0)
        await super().place(arm, position)


class Run:
    """One sequence, and what somebody else did meanwhile."""

    def __init__(self):
        self.kitchen = Kitchen(SCENE, lambda scene, clock: ClumsyRobot(scene, clock, RobotConfig()))
        self.world = self.kitchen.robot.world
        self.moved_at = {}
        self.removed = set()

    def move(self, name, surface):
        """Somebody moves an object, or (to nowhere) takes it away; also out of the gripper."""
        held = self.kitchen.robot.status().holding
        name = next(iter(held.values()), "") if name == "what is held" else name
        if not name or name in self.removed:
            return
        self.moved_at[name] = self.kitchen.clock.now()
        if surface:
            self.world.move_object(name, self._free_spot(name, surface))
        else:
            self.world.remove_object(name)
            self.removed.add(name)

    def _free_spot(self, name, surface):
        """A point of a surface with nothing near, neither objects nor hands."""
        around = [thing.position for other, thing in self.world.true_objects().items() if other != name]
        around += [tuple(self.world.data.site(frame).xpos) for frame in pr2.TOOL_FRAME.values()]
        top = SCENE.surface(surface)
        grid = [
            top.to_map(along * top.size[0], across * top.size[1])
            for along in (-0.35, -0.2, -0.05, 0.1, 0.25, 0.4)
            for across in (-0.3, 0.0, 0.3)
        ]
        return max(grid, key=lambda spot: min(math.dist(spot[:2], other[:2]) for other in around))

    async def stand_still(self):
        """A stop is in force: 0.3 s after it nothing moves any more."""
        await self.kitchen.clock.sleep(0.3)
        for _ in range(10):
            assert self.kitchen.speed() <= STILL, "it does not stand still"
            await self.kitchen.clock.sleep(0.05)

    async def happen(self, event):
        if isinstance(event, str):
            self.kitchen.bus.publish(ROBOT_STOP, StopSignal(time=self.kitchen.clock.now(), state=event))
            if event == "confirmed" or (event == "spotted" and self.kitchen.states[-1].step == "paused"):
                await self.stand_still()
        elif hasattr(event, "kind"):
            self.kitchen.bus.publish(COMMAND, event)
        elif event[0] in {"pick", "place"}:
            self.kitchen.robot.faults[event[0]].append(event[1])
        else:
            self.move(*event)
        held = [thing.held_by for thing in self.kitchen.after().values() if thing.held_by]
        assert len(held) == len(set(held)), "two objects in one gripper"

    def check_world(self):
        truth = self.kitchen.after()
        assert set(truth) == {thing.name for thing in SCENE.objects} - self.removed, "an object is lost"
        for name, thing in truth.items():
            assert thing.place, f"{name} is {'held' if thing.held_by else 'on the floor'}"
        model, data = self.world.model, self.world.data
        for contact in data.contact[: data.ncon]:
            names = {model.body(model.geom_bodyid[geom]).name for geom in contact.geom}
            assert contact.dist > -INSIDE or not names <= set(truth), f"{names} are in each other"
        for believed in self.kitchen.believed().objects:
            name = believed.spec.name
            looked_since = (believed.seen or 0.0) >= self.moved_at.get(name, 0.0)
            if believed.confidence > 0.5 and looked_since:
                assert name in truth, f"{name} is believed in, but was taken away"
                assert believed.place == truth[name].place, believed
                assert math.dist(believed.position, truth[name].position) < 0.05, believed

    def check_answers(self, commands):
        for command in commands:
            told = [outcome.status for outcome in self.kitchen.outcomes if outcome.command == command.id]
            assert told, f"nothing was said about {command}"
            assert told[0] in {"accepted", "deferred", "refused"}, (command, told)
            assert told[-1] in {"done", "failed", "refused", "cancelled", "interrupted"}, (command, told)


@pytest.mark.slow
@hypothesis.settings(
    max_examples=6, deadline=None, derandomize=True, database=None, phases=(hypothesis.Phase.generate,)
)
@hypothesis.given(st.lists(EVENTS, min_size=3, max_size=6))
def test_nothing_is_lost_and_every_command_is_answered_with_physics(events):
    run = Run()

    async def script():
        for event, pause in events:
            await run.happen(event)
            await run.kitchen.clock.sleep(pause)
        run.kitchen.bus.publish(ROBOT_STOP, StopSignal(time=run.kitchen.clock.now(), state="withdrawn"))
        assert await run.kitchen.settle()
        if run.kitchen.states[-1].step == "stopped":
            run.kitchen.bus.publish(COMMAND, CarryOn(time=0.0))
            assert await run.kitchen.settle()

    run.kitchen.play(script)
    run.check_world()
    run.check_answers([event for event, _ in events if hasattr(event, "kind")])
