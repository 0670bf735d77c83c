"""A machine that doubts nobody, for tests in which prices are plain numbers."""

from __future__ import annotations

from defaults import PLANT, SOME_TIME_S

from dray.messages import Bid, Handover, Transport, Work
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.liveness.progress import Progress
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.life import Life


class Credulous(Assessor):
    """Believes every bid, and gives every carrier all the time: for tests in which prices are plain numbers."""

    def __init__(self) -> None:
        super().__init__(PLANT, Life())

    def refuses(self, bidder: str, work: Work, bid: Bid, now_s: float) -> bool:
        """Nothing is said against it."""
        return False

    def progress(self, promised_s: float, now_s: float) -> Progress:
        """None is asked for."""
        return Progress(SOME_TIME_S, SOME_TIME_S, now_s)


def believing(machine: Machine) -> Machine:
    """Let a machine believe its bidders and its carriers: a load is down when its carrier says so."""
    tasks, handle = machine._flow.tasks, machine._message_handlers[Handover]
    credulous = Credulous()
    tasks._auctions._assessor = tasks.failover._assessor = credulous
    credulous.reliability = tasks.reliability

    def on_handover(sender: str, message: Handover, now_s: float) -> None:
        task = tasks.get(message.task)
        if task is not None:
            task.witnessed = False
            goal = machine._goals.get(task.work.goal) if isinstance(task.work, Transport) else None
            if goal is not None:
                goal.arrived = goal.delivered + message.quantity
        handle(sender, message, now_s)

    machine._message_handlers = {**machine._message_handlers, Handover: on_handover}
    return machine
