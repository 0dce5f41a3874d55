"""How fast the embedded interpreter understands, and whether a long talk makes the dialogue slower or bigger.

The interpreter is timed on the sentences of the language benchmark, each in its situation. The long talk is one session
of the dialogue with sentences of the kitchen grammar, while a robot works on what was asked for.
"""

import gc
import json
import random
import time
import tracemalloc
from statistics import median
from typing import Any

import anyio

from attune.cli.understanding import LineContext
from attune.core.bus import COMMAND, OUTCOME, REPLY, ROBOT_STATE, UTTERANCE, Bus
from attune.core.clock import RealClock, VirtualClock, run
from attune.core.config import DialogueConfig
from attune.core.messages import BringMe, Command, CommandOutcome, QueuedTask, RobotState, Utterance
from attune.core.scene import load_scene
from attune.dialogue.bridge import DialogueBridge
from attune.dialogue.corpus import domain_sentences, scene_lexicon
from attune.dialogue.grammar.interpreter import GrammarInterpreter
from attune.dialogue.repair import Repairer
from attune.evaluation.language.run import benchmark_items

TARGET_P99_MS = 5.0
ROUNDS = 3
TURNS = 10_000
PARTS = 10


def percentile(values: list[float], percent: float) -> float:
    """The value within which so many percent of the values lie."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(len(ordered) * percent / 100))]


def interpreting() -> dict[str, Any]:
    """Time to understand each sentence of the language benchmark, repair of misheard words included.

    Processor time is what it needs by itself; the other also counts waiting for busy cores.
    """
    lexicon = scene_lexicon(load_scene())
    interpreter, repairer = GrammarInterpreter(lexicon), Repairer(lexicon)
    asked = [(item.utterance, LineContext.model_validate(item.context).context()) for item in benchmark_items()]
    wall: list[float] = []
    processor: list[float] = []

    async def main() -> None:
        for text, context in asked * ROUNDS:
            start, start_processor = time.perf_counter(), time.thread_time()
            meaning = await interpreter.interpret(text, context)
            await repairer.repaired(meaning, Utterance(time=0.0, text=text), context, interpreter)
            wall.append(time.perf_counter() - start)
            processor.append(time.thread_time() - start_processor)

    run(main, RealClock())
    # The best of several rounds is what an idle machine needs: other programs slow down one round or another.
    best = [min(wall[start :: len(asked)]) for start in range(len(asked))]
    return {
        "utterances": len(wall),
        "p50 [ms]": round(1000 * percentile(wall, 50), 2),
        "p99 [ms]": round(1000 * percentile(wall, 99), 2),
        "p99 target [ms]": TARGET_P99_MS,
        "p50, best of the rounds [ms]": round(1000 * percentile(best, 50), 2),
        "p99, best of the rounds [ms]": round(1000 * percentile(best, 99), 2),
        "p50, processor time [ms]": round(1000 * percentile(processor, 50), 2),
        "p99, processor time [ms]": round(1000 * percentile(processor, 99), 2),
        "longest, processor time [ms]": round(1000 * max(processor), 2),
        "utterances per second of processor time": round(len(processor) / sum(processor)),
    }


def obey(bus: Bus, clock: VirtualClock, command: Command) -> None:
    """A robot that has always just begun what it was told, and has done what it was told before."""
    state = bus.latest(ROBOT_STATE)
    for task in state.queue if state else ():
        done = CommandOutcome(
            time=clock.now(), command=task.command, kind="bring_me", status="done", object=task.object,
            place=task.destination,
        )  # fmt: skip
        bus.publish(OUTCOME, done)
    queue: tuple[QueuedTask, ...] = ()
    if isinstance(command, BringMe):
        queue = tuple(QueuedTask(object=spec, destination="table", command=command.id) for spec in command.objects)
    step = "transporting_fetch" if queue else "idle"
    bus.publish(ROBOT_STATE, RobotState(time=clock.now(), step=step, queue=queue))


def talking(*, traced: bool) -> tuple[dict[str, int], list[float], list[int]]:
    """One session of many turns; each part of it says the same sentences in another order.

    Args:
        traced: Measure memory, which makes it slower.

    Returns:
        What came of it, the processor time per turn of each part [s], and the memory after each part [bytes].
    """
    clock, bus, scene = VirtualClock(), Bus(), load_scene()
    sentences = domain_sentences(scene, TURNS // PARTS, seed=1)
    order = random.Random(1)
    counts = {"commands": 0, "replies": 0}
    seconds: list[float] = []
    memory: list[int] = []

    def count(what: str) -> None:
        counts[what] += 1

    async def main() -> None:
        bridge = DialogueBridge(bus, clock, scene, DialogueConfig())
        bus.on(REPLY, lambda reply: count("replies"))
        bus.on(COMMAND, lambda command: count("commands"))
        bus.on(COMMAND, lambda command: obey(bus, clock, command))
        async with anyio.create_task_group() as group:
            group.start_soon(bridge.run)
            await clock.sleep(0.1)
            for _ in range(PARTS):
                order.shuffle(sentences)
                start = time.process_time()
                for text in sentences:
                    now = clock.now()
                    bus.publish(UTTERANCE, Utterance(time=now, text=text, start=now, end=now, typed=True))
                    await clock.sleep(3.0)
                seconds.append((time.process_time() - start) / len(sentences))
                gc.collect()
                memory.append(tracemalloc.get_traced_memory()[0] if traced else 0)
            group.cancel_scope.cancel()

    if traced:
        tracemalloc.start(1)
    try:
        run(main, clock)
    finally:
        tracemalloc.stop()
    return counts, seconds, memory


def long_talk() -> dict[str, Any]:
    """Whether a long talk becomes slower or bigger: timed once, and once again with memory traced."""
    counts, seconds, _ = talking(traced=False)
    _, _, memory = talking(traced=True)
    return {
        "turns": TURNS,
        **counts,
        "processor time per turn, each tenth [ms]": [round(1000 * part, 2) for part in seconds],
        "median over the tenths [ms]": round(1000 * median(seconds), 2),
        "memory grown from the second tenth to the last [KiB]": round((memory[-1] - memory[1]) / 1024, 1),
        "of it in the last five tenths [KiB]": round((memory[-1] - memory[-6]) / 1024, 1),
    }


def main() -> dict[str, Any]:
    return {"interpreting": interpreting(), "talking": long_talk()}


if __name__ == "__main__":
    print(json.dumps(main(), indent=2))
