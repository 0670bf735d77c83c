"""One trace follows one task through all agents, and nothing is traced unless somebody asks for it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from random import Random

import pytest
from opentelemetry.sdk.trace import ReadableSpan, TracerProvider
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from opentelemetry.trace import TraceFlags

from dray.adapters.telemetry.spans import TASKS, Spans
from dray.adapters.telemetry.tracing import TracedBus, open_provider
from dray.codec import decode, decode_with_context, encode
from dray.errors import WireError
from dray.messages import (
    Event,
    Handover,
    Message,
    OrderItem,
    Role,
    TaskAnnounced,
    Transport,
)
from dray.messages.contract import Refusal
from dray.messages.fact import (
    AnyFact,
    BidRefused,
    ContractEnded,
    ContractTaken,
    TaskClosed,
    TaskOpened,
    TookOver,
)
from dray.plant import default_plant
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.latency import WLAN
from dray_sim.network.sim_network import SimNetwork
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient

PLANT = default_plant()

ORDER = Order(id="O-1", at_s=0.0, due_s=3600.0, items=(OrderItem(product="gear-unit-g1", quantity=4),))

CONTEXT = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
"""The example of W3C's recommendation."""

LATEST_S = 7200.0


class Facts:
    """Hears what agents tell of themselves."""

    def __init__(self) -> None:
        self._told: list[tuple[str, AnyFact]] = []
        self._more = asyncio.Event()

    def on_message(self, _at_s: float, sender: str, address: str, message: Message) -> None:
        if isinstance(message, Event) and address.startswith(PLANT.id):
            self._told.append((sender, message.fact))
            self._more.set()

    async def until(self, wanted: Callable[[AnyFact], bool]) -> tuple[str, AnyFact]:
        """Who tells this, and what it is."""
        while True:
            for agent, fact in self._told:
                if wanted(fact):
                    return agent, fact
            self._more.clear()
            await self._more.wait()


@pytest.fixture
def exporter() -> InMemorySpanExporter:
    return InMemorySpanExporter()


@pytest.fixture
def provider(exporter: InMemorySpanExporter) -> TracerProvider:
    return open_provider(1.0, SimpleSpanProcessor(exporter))


def told(span: ReadableSpan, name: str) -> object:
    return (span.attributes or {}).get(f"dray.{name}")


def carry_goods(provider: TracerProvider) -> tuple[str, str, str, str]:
    """Let an order be made, and switch off the first vehicle that carries goods of it.

    Returns:
        The task, its coordinator, the vehicle that failed, and the one that took over.
    """

    async def main() -> tuple[str, str, str, str]:
        facts = Facts()
        factory = SimFactory(
            PLANT,
            clock(),
            seed=1,
            listener=facts,
            meet=lambda network: TracedBus(network, provider, lambda plant_s: plant_s),
        )
        async with asyncio.timeout(LATEST_S):
            life = asyncio.create_task(factory.run())
            await OrderClient(factory.bus, factory.clock).order(ORDER)
            machine, opened = await facts.until(
                lambda fact: (
                    isinstance(fact, TaskOpened) and isinstance(fact.work, Transport) and fact.work.goal != ""
                )
            )
            task = opened.task
            taken = {}
            for role in Role:
                taken[role], _ = await facts.until(
                    lambda fact, role=role: (
                        isinstance(fact, ContractTaken) and (fact.task, fact.role) == (task, role)
                    )
                )
            factory.power_off(taken[Role.PRIMARY])
            await facts.until(lambda fact: isinstance(fact, TookOver) and fact.task == task)
            await facts.until(
                lambda fact: (
                    isinstance(fact, ContractEnded) and fact.task == task and fact.role is Role.PRIMARY
                )
            )
            await facts.until(lambda fact: isinstance(fact, TaskClosed) and fact.task == opened.work.goal)
            life.cancel()
            await asyncio.gather(life, return_exceptions=True)
        return task, machine, taken[Role.PRIMARY], taken[Role.SECONDARY]

    return run(main())


def test_one_trace_holds_strategist_machine_primary_and_secondary_with_its_takeover(
    provider: TracerProvider, exporter: InMemorySpanExporter
) -> None:
    task, machine, primary, secondary = carry_goods(provider)
    spans = exporter.get_finished_spans()
    (root,) = [span for span in spans if span.name == "task" and told(span, "task") == task]
    trace = [span for span in spans if span.context.trace_id == root.context.trace_id]
    assert {"strategist", machine, primary, secondary} <= {told(span, "agent") for span in trace}

    by_id = {span.context.span_id: span for span in trace}
    (first,) = [span for span in trace if span.parent is None]
    assert (first.name, told(first, "agent")) == ("task", "strategist")
    for span in trace:
        assert span.parent is None or span.parent.span_id in by_id, "every parent is told, too"
        assert span.end_time is not None
        assert span.start_time is not None
        assert span.end_time >= span.start_time

    def of(agent: str, name: str) -> list[ReadableSpan]:
        return [
            span
            for span in trace
            if (told(span, "agent"), span.name, told(span, "task")) == (agent, name, task)
        ]

    (carried,) = of(primary, "carry")
    (watched,) = of(secondary, "watch")
    (took,) = of(secondary, "carry")
    assert by_id[carried.parent.span_id].name == "auction"
    assert told(by_id[carried.parent.span_id], "agent") == machine
    assert by_id[took.parent.span_id] is watched
    assert (told(took, "epoch"), told(took, "replaces")) == (2, primary)
    assert (told(took, "reason"), told(took, "outcome")) == ("silent", "handed_over")
    assert {span.name for span in trace if span.parent and span.parent.span_id == took.context.span_id} >= {
        "approaching",
        "carrying",
        "unloading",
    }
    (produced,) = [span for span in trace if span.name == "produce"]
    assert told(produced, "agent") == machine
    assert by_id[root.parent.span_id] is produced
    assert told(root, "outcome") == "delivered"
    assert "CarrierChanged" in [event.name for event in root.events]


def test_who_refuses_says_why_in_the_trace(provider: TracerProvider, exporter: InMemorySpanExporter) -> None:
    spans = Spans("ATV1", provider.get_tracer("test"), lambda plant_s: plant_s)
    spans.on_message(announcement("M1-1"), CONTEXT)
    refused = BidRefused(task="M1-1", epoch=1, role=Role.PRIMARY, reason=Refusal.BATTERY)
    spans.tell(event(refused))
    (span,) = exporter.get_finished_spans()
    assert span.name == "refusal"
    assert told(span, "reason") == "battery"
    assert span.parent is not None
    assert f"{span.context.trace_id:032x}" == CONTEXT.split("-")[1]
    assert f"{span.parent.span_id:016x}" == CONTEXT.split("-")[2]


def announcement(task: str) -> TaskAnnounced:
    work = Transport(item="steel", quantity=4, sources=("S1",), destination="M1", ability="tote")
    return TaskAnnounced(task=task, epoch=1, role=Role.PRIMARY, coordinator="M1", work=work, deadline_s=900.0)


def event(fact: AnyFact) -> Event:
    return Event(agent="ATV1", incarnation=1, number=1, at_s=100.0, fact=fact)


@pytest.mark.parametrize(
    "context", ["", "nonsense", CONTEXT.replace("0af7", "0AF7"), f"00-{'0' * 32}-{'0' * 16}-01"]
)
def test_a_context_that_nobody_can_read_is_none(provider: TracerProvider, context: str) -> None:
    spans = Spans("ATV1", provider.get_tracer("test"), lambda plant_s: plant_s)
    spans.on_message(announcement("M1-1"), context)
    assert spans.context_of(announcement("M1-1")) == ""


def test_tasks_are_forgotten_when_there_are_too_many_and_an_agent_that_goes_ends_its_spans(
    provider: TracerProvider, exporter: InMemorySpanExporter
) -> None:
    spans = Spans("ATV1", provider.get_tracer("test"), lambda plant_s: plant_s)
    taken = ContractTaken(task="M1-0", epoch=1, role=Role.PRIMARY, coordinator="M1")
    spans.tell(event(taken))
    for number in range(1, TASKS):
        spans.on_message(announcement(f"M1-{number}"), CONTEXT)
    assert exporter.get_finished_spans() == ()
    spans.on_message(announcement("one more"), CONTEXT)
    assert [span.name for span in exporter.get_finished_spans()] == ["carry"]
    spans.tell(event(ContractTaken(task="M1-1", epoch=1, role=Role.SECONDARY, coordinator="M1")))
    spans.close()
    assert [span.name for span in exporter.get_finished_spans()] == ["carry", "watch"]


def test_a_share_of_all_tasks_may_be_traced(exporter: InMemorySpanExporter) -> None:
    spans = Spans("M1", open_provider(0.0, SimpleSpanProcessor(exporter)).get_tracer("test"), float)
    spans.tell(event(ContractTaken(task="M1-1", epoch=1, role=Role.PRIMARY, coordinator="M1")))
    flags = int(spans.context_of(announcement("M1-1"))[-2:], 16)
    assert not flags & TraceFlags.SAMPLED, "others are told not to trace it either"
    spans.close()
    assert exporter.get_finished_spans() == ()


def test_the_envelope_carries_a_context_only_when_there_is_one() -> None:
    message = Handover(task="M1-1", epoch=1, quantity=4)
    plain, traced = encode("ATV1", message), encode("ATV1", message, CONTEXT)
    assert b'"t"' not in plain
    assert decode_with_context(plain) == ("ATV1", message, "")
    assert decode_with_context(traced) == ("ATV1", message, CONTEXT)
    assert decode(traced) == ("ATV1", message)
    with pytest.raises(WireError):
        decode(encode("ATV1", message, "0" * 257))


def test_the_simulated_network_carries_it_to_those_who_hear_the_message_and_no_further() -> None:
    heard: list[str] = []

    async def main() -> None:
        network = SimNetwork(clock(), Random(1))
        speaker = network.join("A", lambda _sender, _message: None)
        listener = network.join("B", lambda _sender, _message: heard.append(listener.context))
        speaker.context = CONTEXT
        speaker.send("B", Handover(task="M1-1", epoch=1, quantity=4))
        speaker.context = ""
        speaker.send("B", Handover(task="M1-1", epoch=1, quantity=4))
        await asyncio.sleep(WLAN.cap_s)
        assert listener.context == ""

    run(main())
    assert heard == [CONTEXT, ""]
