"""Insiders: agents with a valid certificate that lie.

They know the plant and the protocol, and say anything that serves them. They cannot speak under another one's name
unless they have stolen its certificate, for the bus prevents that. They are agents like any other
(`dray.protocol.runtime.events.Agent`): an ordinary worker runs them, on the simulated bus and on the real one. Their
lies are data (`Behaviour`).
"""

from dray_sim.insiders.behaviour import BEHAVIOURS, Answer, Behaviour, Price
from dray_sim.insiders.liar import Liar
from dray_sim.insiders.turncoat import Turncoat

__all__ = ["BEHAVIOURS", "Answer", "Behaviour", "Liar", "Price", "Turncoat"]
