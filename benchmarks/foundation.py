"""Speed of the whole chain: stopping, understanding, listening, simulating. All audio is synthetic (espeak-ng)."""

import math
import time
from statistics import median
from typing import Any

import anyio
import numpy as np

from attune.core.bus import COMMAND, ROBOT_STOP, UTTERANCE, Bus
from attune.core.clock import RealClock, VirtualClock, run
from attune.core.config import Config, SpeechConfig, load_config, with_values
from attune.core.scene import load_scene
from attune.dialogue.corpus import domain_sentences
from attune.evaluation.scenarios import BRING_ME
from attune.evaluation.speakers import Speaker, UserAudio, people
from attune.evaluation.trial import run_trial
from attune.robots.mujoco.robot import MujocoRobot
from attune.session.session import Session
from attune.speech.audio import SAMPLE_RATE, ArraySource
from attune.speech.listener import Listener

STOPS = 8


def quiet() -> Config:
    return with_values(load_config(environment={}), {"voice": {"output": "none"}})


def stopping() -> dict[str, Any]:
    """Real time: a person says "stop" while the robot drives, then asks again; several voices."""
    clock = RealClock()
    user = UserAudio(clock, people()[0])
    to_signal: list[float] = []
    to_zero: list[float] = []
    to_command: list[float] = []
    missed = 0

    async def command_after(session: Session, text: str) -> float:
        with session.bus.subscribe(COMMAND) as commands:
            said = user.say(text)
            with anyio.move_on_after(said - clock.now() + 6):
                return (await commands.receive()).time - said
        return math.nan

    async def one_stop(session: Session, robot: MujocoRobot, speaker: Speaker) -> None:
        nonlocal missed
        to_command.append(await command_after(session, "bring me a cup"))
        with anyio.move_on_after(60):
            while robot.commanded_speed() < 0.5:
                await clock.sleep(0.02)
        await clock.sleep(0.5)
        signals: list[float] = []
        forget = session.bus.on(ROBOT_STOP, lambda stop: signals.append(stop.time))
        ended = user.say("stop", speaker=speaker)
        with anyio.move_on_after(ended - clock.now() + 5) as limit:
            while robot.commanded_speed() > 0 or not signals:
                await clock.sleep(0.002)
        forget()
        if limit.cancelled_caught:
            missed += 1
        else:
            to_signal.append(signals[0] - ended)
            to_zero.append(clock.now() - ended)
        await clock.sleep(2.5)

    async def main() -> None:
        session = Session(quiet(), clock, audio=user)
        assert isinstance(session.robot, MujocoRobot)
        async with session.running():
            await clock.sleep(3)  # the recogniser loads
            for speaker in people()[:STOPS]:
                await one_stop(session, session.robot, speaker)

    run(main, clock)
    return {
        "end of the word stop to signal [ms]": spread(to_signal),
        "end of the word stop to zero commanded velocity [ms]": spread(to_zero),
        "stops missed": f"{missed} of {STOPS}",
        "end of utterance to command [ms]": spread(to_command),
    }


def listening() -> dict[str, Any]:
    """Processor time for hearing a minute in which somebody speaks about a third of the time."""
    speech = [speaker.say("could you bring me the small red cup from the table please") for speaker in people()[:6]]
    minute = np.zeros(60 * SAMPLE_RATE, np.float32)
    minute += np.random.default_rng(0).normal(0, 5e-4, len(minute)).astype(np.float32)
    for index, samples in enumerate(speech):
        start = index * 10 * SAMPLE_RATE
        minute[start : start + len(samples)] += samples
    sentences = domain_sentences(load_scene())
    heard: list[Any] = []

    def cost(samples: Any) -> float:
        clock, bus = VirtualClock(), Bus()
        bus.on(UTTERANCE, heard.append)
        listener = Listener(bus, clock, ArraySource(samples), sentences, SpeechConfig())
        began = time.process_time()
        run(listener.run, clock)
        return time.process_time() - began

    start_up = cost(minute[:SAMPLE_RATE])
    heard.clear()
    share = (cost(minute) - start_up) / 59
    return {
        "listening: share of one core [%]": round(100 * share, 1),
        "start-up with a built model [s]": round(start_up, 2),
        "utterances heard": f"{len(heard)} of {len(speech)}",
    }


def simulating() -> dict[str, Any]:
    """Virtual time: the bring_me scenario, typed, planning included."""
    clock = VirtualClock()
    began = time.process_time()
    result = run(lambda: run_trial(BRING_ME, quiet(), clock, None), clock)
    seconds = time.process_time() - began
    return {
        "simulated seconds per processor second, planning included": round(result.robot_time / seconds, 1),
        "verdict": result.passed,
    }


def spread(values: list[float]) -> dict[str, float]:
    """Median, smallest and largest, in milliseconds."""
    finite = [1000 * value for value in values if math.isfinite(value)]
    if not finite:
        return {}
    return {"median": round(median(finite)), "min": round(min(finite)), "max": round(max(finite)), "n": len(finite)}


def main() -> dict[str, Any]:
    """All figures."""
    return simulating() | listening() | stopping()


if __name__ == "__main__":
    import json

    print(json.dumps(main(), indent=2))
