"""The plan language: outcomes, trees, interruption."""

import anyio
import pytest

from attune.core.clock import VirtualClock, run
from attune.planner.combinators import (
    Recovery,
    atomic_while,
    monitor,
    parallel,
    repeat,
    retry,
    sequence,
    try_in_order,
)
from attune.planner.plan import Node, Part, Plan, PlanFailure


class Broken(PlanFailure):
    pass


class Other(PlanFailure):
    pass


class Bench:
    """Runs one plan in virtual time and keeps its trees and its diary."""

    def __init__(self):
        self.clock = VirtualClock()
        self.trees = []
        self.diary = []
        self.atomic = []
        self.plan = None

    def work(self, name, seconds=1.0, failures=(), atomic=False):
        remaining = list(failures)

        async def body(_: Node):
            self.diary.append(f"{name} begins")
            await self.clock.sleep(seconds)
            if remaining:
                raise remaining.pop(0)
            self.diary.append(f"{name} ends")
            return name

        return Part(name, body, atomic)

    def run(self, part, *events):
        """`events`: (time, function of the plan)."""

        async def main():
            self.plan = Plan(self.clock, self.trees.append, self.atomic.append, atomic_limit=10.0)

            async def at(time, event):
                await self.clock.sleep(time)
                event(self.plan)

            async with anyio.create_task_group() as group:
                for time, event in events:
                    group.start_soon(at, time, event)
                result = await self.plan.run(part)
                group.cancel_scope.cancel()
            return result

        return run(main, self.clock)


@pytest.fixture
def bench():
    return Bench()


def test_a_sequence_runs_its_parts_in_order_and_its_tree_shows_what_is_to_come(bench):
    assert bench.run(sequence("all", bench.work("a"), bench.work("b"))).status == "succeeded"
    assert bench.diary == ["a begins", "a ends", "b begins", "b ends"]
    during_a = next(tree for tree in bench.trees if tree.children and tree.children[0].status == "running")
    assert [child.status for child in during_a.children] == ["running", "pending"]
    last = bench.trees[-1]
    assert [(child.started, child.ended) for child in last.children] == [(0.0, 1.0), (1.0, 2.0)]


def test_a_sequence_fails_with_the_first_part_that_fails(bench):
    result = bench.run(sequence("all", bench.work("a", failures=[Broken("a broke")]), bench.work("b")))
    assert result.status == "failed"
    assert isinstance(result.failure, Broken)
    assert [child.status for child in bench.trees[-1].children] == ["failed", "pending"]
    assert "a broke" in bench.trees[-1].reason


def test_parallel_parts_run_at_once(bench):
    assert bench.run(parallel("both", bench.work("a", 2.0), bench.work("b", 1.0))).status == "succeeded"
    assert bench.clock.now() == 2.0


def test_a_failure_interrupts_the_parallel_parts(bench):
    result = bench.run(parallel("both", bench.work("a", 5.0), bench.work("b", 1.0, [Broken("b broke")])))
    assert isinstance(result.failure, Broken)
    assert [child.status for child in bench.trees[-1].children] == ["interrupted", "failed"]
    assert bench.clock.now() == 1.0


def test_try_in_order_takes_the_first_that_succeeds(bench):
    parts = [bench.work("a", failures=[Broken("no")]), bench.work("b"), bench.work("c")]
    assert bench.run(try_in_order("one", *parts)).status == "succeeded"
    assert [child.status for child in bench.trees[-1].children] == ["failed", "succeeded", "pending"]


def test_try_in_order_goes_on_only_after_the_named_failures(bench):
    parts = [bench.work("a", failures=[Other("no")]), bench.work("b")]
    assert isinstance(bench.run(try_in_order("one", *parts, on=(Broken,))).failure, Other)


def test_repeat_runs_while_its_condition_holds(bench):
    assert bench.run(repeat("thrice", bench.work("a"), lambda rounds: rounds < 3)).status == "succeeded"
    assert bench.diary.count("a ends") == 3


def test_retry_recovers_by_the_type_of_the_failure(bench):
    part = bench.work("a", failures=[Broken("1"), Other("2"), Broken("3")])
    recoveries = {
        Broken: Recovery(lambda failure: bench.work(f"mend {failure.problem}"), 2),
        Other: Recovery(lambda failure: bench.work(f"help {failure.problem}"), 1),
    }
    assert bench.run(retry("tries", lambda attempt: part, recoveries)).status == "succeeded"
    assert [line for line in bench.diary if "ends" in line] == ["mend 1 ends", "help 2 ends", "mend 3 ends", "a ends"]


def test_retry_is_bounded_for_each_type_of_failure(bench):
    part = bench.work("a", failures=[Broken(str(number)) for number in range(9)])
    result = bench.run(retry("tries", lambda attempt: part, {Broken: Recovery(lambda failure: bench.work("mend"), 2)}))
    assert isinstance(result.failure, Broken)
    assert bench.diary.count("a begins") == 3


def test_a_failing_recovery_does_not_end_the_retries(bench):
    part = bench.work("a", failures=[Broken("1")])
    mend = Recovery(lambda failure: bench.work("mend", failures=[Other("bad")]), 1)
    assert bench.run(retry("tries", lambda attempt: part, {Broken: mend})).status == "succeeded"


def test_a_monitor_interrupts_its_part_when_the_condition_breaks(bench):
    part = monitor("watch", bench.work("a", 10.0), lambda: bench.clock.now() < 3.0, lambda: Broken("gone"), bench.clock)
    assert isinstance(bench.run(part).failure, Broken)
    assert 3.0 <= bench.clock.now() < 3.3
    assert bench.trees[-1].children[0].status == "interrupted"


def test_a_monitor_whose_condition_holds_gives_the_value_of_its_part(bench):
    values = []

    async def body(node):
        values.append(await node.do(monitor("watch", bench.work("a"), lambda: True, lambda: Broken("x"), bench.clock)))

    assert bench.run(Part("all", body)).status == "succeeded"
    assert values == ["a"]


def test_an_interruption_ends_the_plan_at_once_and_says_how_far_it_got(bench):
    plan = sequence("all", bench.work("a"), bench.work("b", 9.0))
    assert bench.run(plan, (3.0, Plan.interrupt)).status == "interrupted"
    assert bench.clock.now() == 3.0
    assert bench.trees[-1].status == "interrupted"
    assert bench.trees[-1].reason == "after 1 of 2 parts, during b"


def test_an_interruption_waits_for_an_atomic_part(bench):
    plan = sequence("all", bench.work("a", 5.0, atomic=True), bench.work("b"))
    waits = []
    assert bench.run(plan, (1.0, lambda plan: waits.append(plan.interrupt()))).status == "interrupted"
    assert waits == [True]
    assert bench.diary == ["a begins", "a ends"]
    assert bench.clock.now() == 5.0
    assert bench.atomic == [True, False]


def test_an_atomic_part_that_lasts_too_long_is_interrupted_all_the_same(bench):
    assert bench.run(bench.work("a", 60.0, atomic=True), (1.0, Plan.interrupt)).status == "interrupted"
    assert bench.clock.now() == 11.0


def test_a_stop_does_not_wait_for_an_atomic_part(bench):
    assert bench.run(bench.work("a", 60.0, atomic=True), (1.0, Plan.stop)).status == "interrupted"
    assert bench.clock.now() == 1.0


def test_an_interruption_waits_while_an_action_cannot_be_cut_short(bench):
    part = atomic_while(bench.work("a", 9.0), lambda: 2.0 <= bench.clock.now() < 4.0, bench.clock)
    waits = []
    assert bench.run(part, (3.0, lambda plan: waits.append(plan.interrupt()))).status == "interrupted"
    assert waits == [True]
    assert 4.0 <= bench.clock.now() < 4.3
    assert bench.atomic == [True, False]


def test_an_interruption_that_waits_can_be_taken_back(bench):
    plan = sequence("all", bench.work("a", 20.0, atomic=True), bench.work("b"))
    assert bench.run(plan, (1.0, Plan.interrupt), (2.0, Plan.spare)).status == "succeeded"


def test_an_error_of_the_program_is_no_failure_of_the_plan(bench):
    async def body(_):
        raise ZeroDivisionError

    with pytest.raises(ExceptionGroup):
        bench.run(try_in_order("one", Part("bug", body), bench.work("b")))
    assert bench.trees[-1].status == "failed"
