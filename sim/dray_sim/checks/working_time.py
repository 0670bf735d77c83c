"""Invariant 25: a machine begins no piece while it rests by its working time.

Like those of `dray_sim.checks.invariants`, this check hears the machines' own messages, and takes no part. In one
rest a machine reports one piece at most: the one that it had begun before. A machine's reports are judged by its own
clock.
"""

from __future__ import annotations

from dray.messages import Event, Message
from dray.messages.fact import PieceMade, PieceScrapped, SparePieceMade
from dray.plant import Plant
from dray_sim.checks.broken import InvariantBroken


class RestsKept:
    """No machine makes a second piece in one rest.

    Args:
        plant: the working times of its machines.
    """

    hears = (Event,)

    def __init__(self, plant: Plant) -> None:
        times = {machine: plant.working_time_of(machine) for machine in plant.machines}
        self._times = {machine: time for machine, time in times.items() if not time.is_always}
        self._made_in: dict[str, float] = {}
        """End of the rest in which its newest piece came out, by machine."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        time = self._times.get(sender)
        if time is None or type(message) is not Event:
            return
        fact = message.fact
        if not isinstance(fact, PieceMade | SparePieceMade | PieceScrapped):
            return
        if (isinstance(fact, PieceMade) and fact.from_stock) or time.is_on(message.at_s):
            return
        ends_s = time.next_on_s(message.at_s)
        if self._made_in.get(sender) == ends_s:
            raise InvariantBroken(
                25, at_s, f"{sender} has made a second piece in its rest until {ends_s:.0f} s"
            )
        self._made_in[sender] = ends_s
