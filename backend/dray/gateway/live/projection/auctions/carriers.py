"""Who carries a task, and who did, as panels see it."""

from __future__ import annotations

from msgspec import UNSET

from dray.gateway.live.views import CarrierView, StrandedView, TaskView
from dray.messages import Event, Reason, TaskBrief
from dray.messages.fact import ContractEnded
from dray.store.history.clocks import ToWall

MAX_CARRIERS = 16
"""Changes of a task's carrier that are kept, newest last: more than one task sees while somebody looks."""


def reopen_task(task: TaskView) -> None:
    """Nobody carries it any more: another one is sought, in a new epoch."""
    task.trouble = None
    task.state, task.primary, task.phase, task.source = "bidding", "", "", ""
    task.contracted_at_s = task.promised_at_s = None


def give_to(task: TaskView, carrier: str, epoch: int) -> None:
    """Somebody else carries it."""
    if carrier != task.primary:
        # What the one before has promised binds nobody any more.
        task.phase, task.promised_at_s = "", None
    task.epoch, task.primary, task.state = epoch, carrier, "contracted"
    if task.secondary == carrier:
        task.secondary = ""


def add_carrier(task: TaskView, carrier: CarrierView) -> None:
    """Add to the list of carriers, which has one line per epoch."""
    others = [other for other in task.carriers if other.epoch != carrier.epoch]
    task.carriers = (*others[1 - MAX_CARRIERS :], carrier)


def undo_takeover(task: TaskView, event: Event, fact: ContractEnded) -> bool:
    """A takeover that its coordinator has refused is undone: the carrier before it still carries.

    Returns:
        False when the contract that has ended is none of that kind.
    """
    last = task.carriers[-1] if task.carriers else None
    if last is None or last.confirmed or (last.carrier, last.epoch) != (event.agent, fact.epoch):
        return False
    if fact.reason == Reason.HANDED_OVER:
        return False
    task.carriers = task.carriers[:-1]
    before = task.carriers[-1] if task.carriers else None
    if before is None or not before.carrier:
        reopen_task(task)
    else:
        task.primary, task.phase = before.carrier, ""
    task.epoch = fact.epoch - 1 if before is None else before.epoch
    return True


def stranded_of(brief: TaskBrief, order: tuple[str, str], to_wall_s: ToWall) -> StrandedView | None:
    """What a coordinator tells of goods that wait for a person's word; and for which order they are: its id, and its name."""
    goods = brief.stranded
    if goods is UNSET:
        return None
    until_at_s = to_wall_s(goods.until_s)
    return StrandedView(
        atv=goods.atv,
        node=goods.node,
        until_at_s=until_at_s,
        handed_at=goods.handed_at,
        order=order[0],
        order_name=order[1],
    )
