"""Random sequences of commands, stops, moved objects and failures at random times; what must hold after each."""

import hypothesis
from hypothesis import strategies as st

from attune.core.bus import WORLD
from attune.core.messages import (
    BringMe,
    CancelObject,
    CarryOn,
    ChangeLocation,
    ObjectSpec,
    PutBack,
    ReplaceObject,
    SettingBreakfast,
    Stop,
)
from attune.robots.interface import Collision, GraspMissed, ObjectLost, PlacementFailed, Unreachable

SPECS = st.sampled_from(
    [
        ObjectSpec(type="cup"),
        ObjectSpec(type="cup", color="white"),
        ObjectSpec(type="milk"),
        ObjectSpec(type="spoon"),
        ObjectSpec(type="juice"),
        ObjectSpec(type="cup", color="purple"),
    ]
)
PLACES = st.sampled_from(["", "table", "countertop", "fridge"])

COMMANDS = st.one_of(
    st.builds(BringMe, time=st.just(0.0), objects=st.tuples(SPECS) | st.tuples(SPECS, SPECS), destination=PLACES),
    st.builds(ReplaceObject, time=st.just(0.0), remove=SPECS, add=SPECS),
    st.builds(ChangeLocation, time=st.just(0.0), destination=st.sampled_from(["table", "countertop", "moon"])),
    st.builds(CancelObject, time=st.just(0.0), object=SPECS),
    st.builds(PutBack, time=st.just(0.0)),
    st.builds(SettingBreakfast, time=st.just(0.0)),
    st.builds(CarryOn, time=st.just(0.0)),
    st.builds(Stop, time=st.just(0.0)),
)
SIGNALS = st.sampled_from(["spotted", "confirmed", "withdrawn"])
FAULTS = st.sampled_from(
    [
        ("pick", GraspMissed("it", "right")),
        ("pick", Unreachable("it")),
        ("place", PlacementFailed("it", "slid")),
        ("place", ObjectLost("it", "right")),
        ("place", Collision("arm", "it")),
    ]
)
MOVES = st.tuples(
    st.sampled_from(["red_cup", "white_cup", "blue_milk"]), st.sampled_from(["counter", "shelf", "island"])
)
EVENTS = st.tuples(st.one_of(COMMANDS, SIGNALS, FAULTS, MOVES), st.floats(0.0, 40.0))


@hypothesis.settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[hypothesis.HealthCheck.function_scoped_fixture],  # The fixture is only a class.
)
@hypothesis.given(st.lists(EVENTS, min_size=2, max_size=6))
def test_nothing_is_lost_and_every_command_is_answered(make_kitchen, events):
    kitchen = make_kitchen(tick=0.2)
    commands = [event for event, _ in events if hasattr(event, "kind")]
    stops = []

    async def script():
        for event, pause in events:
            if isinstance(event, str):
                kitchen.signal(event)
                if event == "confirmed" or (event == "spotted" and kitchen.states[-1].step == "paused"):
                    stops.append(event)
                    await kitchen.clock.sleep(0.3)
                    assert not kitchen.robot.status().moving
            elif hasattr(event, "kind"):
                kitchen.say(event)
            elif event[0] in {"pick", "place"}:
                kitchen.robot.fail_next(*event)
            else:
                kitchen.robot.move_object(*event)
            holding = [thing.held_by for thing in kitchen.robot.true_objects().values() if thing.held_by]
            assert len(holding) == len(set(holding))
            await kitchen.clock.sleep(pause)
        kitchen.signal("withdrawn")
        await kitchen.settle(limit=20000.0)
        if kitchen.states[-1].step == "stopped":
            kitchen.say(CarryOn(time=0.0))
            await kitchen.settle(limit=20000.0)

    kitchen.play(script)
    kitchen.check_nothing_lost()
    assert kitchen.bus.latest(WORLD) is not None
    for command in commands:
        told = kitchen.of(command)
        assert told, f"nothing was said about {command}"
        assert told[-1][0] in {"done", "failed", "refused", "cancelled", "interrupted"}, (command, told)
        assert told[0][0] in {"accepted", "deferred", "refused"}
