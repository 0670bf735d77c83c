"""Insiders: agents with a valid certificate that lie.

They know the plant and the protocol, and say whatever serves them; what they cannot do is speak under another one's name, unless they have
stolen its certificate, for that is the bus's to see to. They are agents like any other (`dray.protocol.runtime.events.Agent`):
an ordinary worker runs them, on the simulated bus and on the real one. What they do is data (`Behaviour`).
"""

from dray_sim.insiders.behaviour import BEHAVIOURS, Answer, Behaviour, Price
from dray_sim.insiders.liar import Liar
from dray_sim.insiders.turncoat import Turncoat

__all__ = ["BEHAVIOURS", "Answer", "Behaviour", "Liar", "Price", "Turncoat"]
