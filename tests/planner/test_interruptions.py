"""Each command interrupting each other, at every change of the robot's state, judged by the final world."""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import replace as replace_fields

import pytest

from attune.core.messages import (
    BringMe,
    CancelObject,
    CarryOn,
    ChangeLocation,
    Command,
    ObjectSpec,
    PutBack,
    ReplaceObject,
    SettingBreakfast,
    Stop,
)

Moved = dict[str, str]

COARSE = 0.25
"""Control period of the many runs [s]: what is tested is the order of things."""


def named(name: str) -> ObjectSpec:
    return ObjectSpec(name=name)


def bring(*names: str) -> BringMe:
    return BringMe(time=0.0, objects=tuple(named(name) for name in names))


CUP = {"red_cup": "table"}
BOTH = {"red_cup": "table", "blue_spoon": "table"}
SET = {"white_bowl": "table", "green_cereal": "table", "blue_milk": "table", "blue_spoon": "table"}


@dataclass(frozen=True)
class Case:
    """What interrupts what, and the right final worlds if the second is carried out (else `undisturbed`)."""

    first: Callable[[], Command]
    undisturbed: Moved
    second: Callable[[], Command]
    right: tuple[Moved, ...]

    def __str__(self) -> str:
        return f"{self.second().kind} during {self.first().kind}"


def replace(old: str, new: str) -> Callable[[], Command]:
    return lambda: ReplaceObject(time=0.0, remove=named(old), add=named(new))


def cancel(name: str) -> Callable[[], Command]:
    return lambda: CancelObject(time=0.0, object=named(name))


def to_the_counter() -> Command:
    return ChangeLocation(time=0.0, destination="countertop")


def put_back() -> Command:
    return PutBack(time=0.0)


def breakfast() -> Command:
    return SettingBreakfast(time=0.0)


def carry_on() -> Command:
    return CarryOn(time=0.0)


def one() -> Command:
    return bring("red_cup")


def two() -> Command:
    return bring("red_cup", "blue_spoon")


CASES = (
    Case(one, CUP, lambda: bring("white_bowl"), ({**CUP, "white_bowl": "table"},)),
    Case(one, CUP, breakfast, ({**CUP, **SET},)),
    Case(one, CUP, replace("red_cup", "blue_glass"), ({"blue_glass": "table"},)),
    Case(one, CUP, to_the_counter, ({"red_cup": "island"},)),
    Case(one, CUP, cancel("red_cup"), ({},)),
    Case(one, CUP, put_back, ({},)),
    Case(one, CUP, carry_on, ()),
    Case(two, BOTH, lambda: bring("white_bowl"), ({**BOTH, "white_bowl": "table"},)),
    Case(two, BOTH, replace("red_cup", "blue_glass"), ({"blue_glass": "table", "blue_spoon": "table"},)),
    Case(two, BOTH, replace("blue_spoon", "black_knife"), ({"red_cup": "table", "black_knife": "table"},)),
    Case(two, BOTH, to_the_counter, ({"red_cup": "island", "blue_spoon": "island"}, {**BOTH, "blue_spoon": "island"})),
    Case(two, BOTH, cancel("red_cup"), ({"blue_spoon": "table"},)),
    Case(two, BOTH, cancel("blue_spoon"), (CUP,)),
    Case(two, BOTH, put_back, (CUP, {"blue_spoon": "table"})),
    Case(breakfast, SET, one, ({**SET, **CUP},)),
    Case(breakfast, SET, breakfast, ()),
    Case(
        breakfast,
        SET,
        replace("blue_milk", "yellow_juice"),
        ({**{name: at for name, at in SET.items() if name != "blue_milk"}, "yellow_juice": "table"},),
    ),
    Case(breakfast, SET, cancel("green_cereal"), ({n: at for n, at in SET.items() if n != "green_cereal"},)),
)


def changes_of(make_kitchen, command: Command) -> int:
    """How many states an undisturbed run publishes."""
    kitchen = make_kitchen(tick=COARSE)
    before: list[int] = []

    async def script():
        before.append(len(kitchen.states))
        kitchen.say(command)
        await kitchen.settle()

    kitchen.play(script)
    return len(kitchen.states) - before[0]


@pytest.mark.parametrize("case", CASES, ids=str)
def test_a_command_interrupts_another_at_every_step(make_kitchen, case):
    stride = {one: 1, two: 3, breakfast: 7}[case.first]  # Each kind of step occurs several times in the longer ones.
    for count in range(0, changes_of(make_kitchen, case.first()) + 1, stride):
        kitchen = make_kitchen(tick=COARSE)
        second = case.second()

        async def script(kitchen=kitchen, second=second, count=count):
            kitchen.say(case.first())
            await kitchen.after_changes(count)
            kitchen.say(second)
            await kitchen.settle()

        kitchen.play(script)
        told = kitchen.of(second)
        refused = told[0][0] == "refused"
        assert kitchen.moved() in ((case.undisturbed,) if refused else case.right), (count, told)
        assert told[0][0] in {"accepted", "deferred", "refused"}, (count, told)
        assert refused or told[-1][0] == "done", (count, told)
        kitchen.check_nothing_lost()


@pytest.mark.parametrize("first", ["red_cup", "blue_spoon"])
def test_a_replacement_at_any_time_leaves_only_the_new_object(make_kitchen, first):
    seconds = 0.0
    while seconds < 50.0:
        kitchen = make_kitchen(tick=COARSE)

        async def script(kitchen=kitchen, seconds=seconds):
            kitchen.say(bring(first))
            await kitchen.clock.sleep(seconds)
            kitchen.say(ReplaceObject(time=0.0, remove=named(first), add=named("white_bowl")))
            await kitchen.settle()

        kitchen.play(script)
        assert kitchen.moved() == {"white_bowl": "table"}, seconds
        kitchen.check_nothing_lost()
        seconds += 1.1


@pytest.mark.parametrize("first", [one, lambda: bring("blue_spoon"), two], ids=["cup", "spoon", "both"])
def test_a_stop_at_every_step_stands_still_and_carry_on_completes(make_kitchen, first):
    undisturbed = {name: "table" for name in [spec.name for spec in first().objects]}
    for count in range(0, changes_of(make_kitchen, first()) + 1, 1 if first is not two else 3):
        kitchen = make_kitchen(tick=COARSE)
        command, again = first(), CarryOn(time=0.0)

        async def script(kitchen=kitchen, command=command, again=again, count=count):
            kitchen.say(command)
            await kitchen.after_changes(count)
            kitchen.signal("confirmed")
            kitchen.say(Stop(time=0.0))
            assert not kitchen.robot.status().moving
            await kitchen.clock.sleep(0.3)
            before = kitchen.robot.true_objects(), kitchen.robot.status()
            assert not before[1].moving
            await kitchen.clock.sleep(20.0)
            assert (kitchen.robot.true_objects(), kitchen.robot.status()) == before, count
            assert kitchen.states[-1].step == "stopped"
            assert not kitchen.states[-1].move_base
            kitchen.say(again)
            await kitchen.settle()

        kitchen.play(script)
        assert kitchen.moved() == undisturbed, count
        assert ("done", "") in kitchen.of(command), count
        kitchen.check_nothing_lost()


@pytest.mark.parametrize("first", [one, lambda: bring("blue_spoon")], ids=["cup", "spoon"])
def test_after_a_stop_at_every_step_a_new_command_starts_afresh(make_kitchen, first):
    (name,) = (spec.name for spec in first().objects)
    for count in range(changes_of(make_kitchen, first())):
        kitchen = make_kitchen(tick=COARSE)
        command, second = first(), bring("white_bowl")

        async def script(kitchen=kitchen, command=command, second=second, count=count):
            kitchen.say(command)
            await kitchen.after_changes(count)
            kitchen.signal("confirmed")
            kitchen.say(Stop(time=0.0))
            await kitchen.clock.sleep(5.0)
            kitchen.say(second)
            await kitchen.settle()

        kitchen.play(script)
        moved = kitchen.moved()
        assert moved.pop(name, "") in {"", "table"}
        assert moved == {"white_bowl": "table"}, count
        assert kitchen.of(command)[-1] in {("interrupted", "stopped"), ("done", "")}, count
        kitchen.check_nothing_lost()


def test_what_is_carried_at_a_stop_is_used_by_the_next_command(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red_cup"))
        await kitchen.until(lambda state: bool(state.holding))
        kitchen.signal("confirmed")
        await kitchen.clock.sleep(1.0)
        picks = sum("pick up" in node.name for node in _nodes(kitchen.plans[-1].root))
        assert picks == 1
        kitchen.say(BringMe(time=0.0, objects=(ObjectSpec(type="cup"),), destination="shelf"))
        await kitchen.settle()
        assert not any("pick up" in node.name for plan in kitchen.plans[-3:] for node in _nodes(plan.root))

    kitchen.play(script)
    assert kitchen.moved() == {"red_cup": "shelf"}


@pytest.mark.parametrize(
    ("command", "moved"),
    [
        (ChangeLocation(time=0.0, destination="shelf"), {"red_cup": "shelf"}),
        (PutBack(time=0.0), {}),
        (CancelObject(time=0.0, object=ObjectSpec(type="cup")), {}),
        (ReplaceObject(time=0.0, remove=ObjectSpec(type="cup"), add=named("white_bowl")), {"white_bowl": "table"}),
    ],
    ids=lambda value: getattr(value, "kind", ""),
)
def test_after_a_stop_commands_about_the_carried_object_are_understood(make_kitchen, command, moved):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red_cup"))
        await kitchen.until(lambda state: bool(state.holding))
        kitchen.signal("confirmed")
        await kitchen.clock.sleep(1.0)
        kitchen.say(command)
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == moved
    assert kitchen.of(command)[-1] == ("done", "")


def test_a_refused_command_after_a_stop_leaves_the_robot_stopped_and_carry_on_possible(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red_cup"))
        await kitchen.until(lambda state: bool(state.holding))
        kitchen.signal("confirmed")
        kitchen.say(bring("no_such_thing"))
        await kitchen.clock.sleep(5.0)
        assert kitchen.states[-1].step == "stopped"
        assert kitchen.robot.status().halted
        kitchen.say(carry_on())
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == CUP


def test_a_spotted_stop_that_is_withdrawn_only_delays(make_kitchen):
    for count in range(0, changes_of(make_kitchen, bring("red_cup")) + 1):
        kitchen = make_kitchen(tick=COARSE)
        command = bring("red_cup")

        async def script(kitchen=kitchen, command=command, count=count):
            kitchen.say(command)
            await kitchen.after_changes(count)
            kitchen.signal("spotted")
            assert kitchen.states[-1].step == "paused"
            assert not kitchen.robot.status().moving
            await kitchen.clock.sleep(3.0)
            kitchen.signal("withdrawn")
            assert kitchen.states[-1].step != "paused"
            await kitchen.settle()

        kitchen.play(script)
        assert kitchen.moved() == CUP
        assert kitchen.of(command) == [("accepted", ""), ("done", "")]


def test_a_stop_said_twice_is_one_stop(make_kitchen):
    kitchen = make_kitchen()
    command = bring("red_cup")

    async def script():
        kitchen.say(command)
        await kitchen.until(lambda state: state.move_base)
        kitchen.signal("spotted")
        kitchen.signal("confirmed")
        kitchen.signal("confirmed")
        kitchen.signal("spotted")
        kitchen.signal("withdrawn")
        await kitchen.clock.sleep(10.0)

    kitchen.play(script)
    assert kitchen.states[-1].step == "stopped"
    assert kitchen.robot.status().halted
    assert kitchen.of(command).count(("interrupted", "stopped")) == 1


def test_a_minor_interruption_waits_for_the_end_of_an_atomic_part_and_says_so(make_kitchen):
    kitchen = make_kitchen()
    second = ReplaceObject(time=0.0, remove=named("blue_spoon"), add=named("white_bowl"))

    async def script():
        kitchen.say(bring("blue_spoon"))
        await kitchen.until(lambda state: not state.interruptible)
        kitchen.say(second)
        await kitchen.clock.sleep(0.5)
        assert not kitchen.states[-1].interruptible
        state = await kitchen.until(lambda state: state.interruptible)
        assert "drawer" in kitchen.robot.status().opened
        assert state.holding == ()
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.of(second) == [("deferred", "atomic_step"), ("done", "")]
    assert kitchen.moved() == {"white_bowl": "table"}
    kitchen.check_nothing_lost()


def test_a_minor_interruption_while_the_fingers_close_says_so_and_the_object_is_known_to_be_held(make_kitchen):
    kitchen = make_kitchen(tick=0.02)
    second = PutBack(time=0.0, object=named("red_cup"))

    async def script():
        kitchen.say(bring("red_cup"))
        await kitchen.until(lambda state: not state.interruptible)
        assert kitchen.states[-1].move_arm
        kitchen.say(second)
        await kitchen.until(lambda state: bool(state.holding))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.of(second) == [("deferred", "atomic_step"), ("done", "")]
    assert kitchen.moved() == {}
    kitchen.check_nothing_lost()


def test_the_state_tells_where_each_object_of_the_task_goes_and_how_far_it_is(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("blue_spoon"))
        await kitchen.until(lambda state: bool(state.holding))
        kitchen.say(ReplaceObject(time=0.0, remove=named("blue_spoon"), add=named("white_bowl")))
        await kitchen.settle()

    kitchen.play(script)
    queues = [[(task.object.name, task.destination, task.status) for task in s.queue] for s in kitchen.states]
    assert [("blue_spoon", "drawer", "returning"), ("white_bowl", "table", "waiting")] in queues
    assert queues[-1] == [("white_bowl", "table", "delivered")]
    assert {state.progress for state in kitchen.states} == {0.0, 1.0}
    before = kitchen.states[0]
    for state in kitchen.states[1:]:
        assert replace_fields(state, id=before.id, time=before.time) != before, "published without a change"
        before = state


def test_a_deferred_interruption_can_be_taken_back(make_kitchen):
    kitchen = make_kitchen()
    command = bring("blue_spoon")

    async def script():
        kitchen.say(command)
        await kitchen.until(lambda state: not state.interruptible)
        kitchen.say(ChangeLocation(time=0.0, destination="shelf"))
        await kitchen.clock.sleep(0.5)
        kitchen.say(ChangeLocation(time=0.0, destination="table"))
        await kitchen.settle()

    kitchen.play(script)
    assert kitchen.moved() == {"blue_spoon": "table"}
    assert not any(node.status == "interrupted" for plan in kitchen.plans for node in _nodes(plan.root))


def test_a_stop_does_not_wait_for_an_atomic_part(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("blue_spoon"))
        await kitchen.until(lambda state: not state.interruptible)
        kitchen.signal("confirmed")
        await kitchen.clock.sleep(10.0)
        assert kitchen.robot.status().opened == frozenset()

    kitchen.play(script)
    assert kitchen.states[-1].step == "stopped"


def test_a_further_wish_does_not_disturb_the_present_transport(make_kitchen):
    kitchen = make_kitchen()

    async def script():
        kitchen.say(bring("red_cup"))
        await kitchen.until(lambda state: state.step == "transporting_fetch" and state.move_arm)
        kitchen.say(bring("white_bowl"))
        await kitchen.settle()

    kitchen.play(script)
    assert not any(node.status == "interrupted" for plan in kitchen.plans for node in _nodes(plan.root))


def test_states_announce_a_movement_before_it_begins(make_kitchen):
    kitchen = make_kitchen()
    announced: list[tuple[bool, bool]] = []

    def check(state):
        if state.move_base:
            announced.append((kitchen.robot.status().moving, state.destination_location != ""))

    from attune.core.bus import ROBOT_STATE

    kitchen.bus.on(ROBOT_STATE, check)

    async def script():
        kitchen.say(bring("red_cup"))
        await kitchen.settle()

    kitchen.play(script)
    assert len(announced) >= 2
    assert all(not moving and told for moving, told in announced)


def _nodes(root):
    yield root
    for child in root.children:
        yield from _nodes(child)
