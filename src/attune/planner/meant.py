"""Which delivery a description means."""

from dataclasses import replace

from attune.core.messages import ObjectSpec
from attune.planner.agenda import Agenda, Delivery
from attune.planner.belief import Belief, Home, Individual


def meant(belief: Belief, agenda: Agenda, spec: ObjectSpec) -> Delivery | None:
    """The delivery that a description is about: carried, else waiting, else delivered last."""
    delivered = [item for item in agenda.deliveries if item.status == "delivered"][::-1]
    return next(
        (item for item in (*carried(belief, agenda), *agenda.waiting, *delivered) if is_about(belief, item, spec)), None
    )


def carried(belief: Belief, agenda: Agenda) -> tuple[Delivery, ...]:
    """The open deliveries of what is in a gripper."""
    held = {item.name for item in belief.held().values()}
    return tuple(item for item in agenda.open if item.individual in held)


def last_delivered(agenda: Agenda) -> tuple[Delivery, ...]:
    """What the last task has delivered."""
    delivered = [item for item in agenda.deliveries if item.status == "delivered"]
    return tuple(item for item in delivered if item.command == delivered[-1].command)


def brought_but_open(belief: Belief, agenda: Agenda) -> tuple[Delivery, ...]:
    """What was put down at this moment, or was delivered before and waits to be brought elsewhere."""
    items = ((delivery, belief.get(delivery.individual)) for delivery in agenda.waiting)
    return tuple(delivery for delivery, item in items if item and item.displaced)


def is_about(belief: Belief, delivery: Delivery, spec: ObjectSpec) -> bool:
    """Whether a delivery fits a description, by the object chosen for it or else by what was asked for."""
    spec = replace(spec, location="")
    item = belief.get(delivery.individual)
    if item:
        return item.is_a(spec)
    asked = delivery.spec
    likeness = Individual(
        name=asked.name, type=asked.type, color=asked.color, size=asked.size or "normal", surface="", home=Home("")
    )
    return likeness.is_a(spec)


def described(belief: Belief, delivery: Delivery) -> ObjectSpec:
    """The object chosen for a delivery, or else what was asked for."""
    item = belief.get(delivery.individual)
    return belief.describe(item) if item else delivery.spec
