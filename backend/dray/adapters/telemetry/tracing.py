"""Tracing: a bus that turns every agent's work into spans, and adds their context to messages.

It stands between an agent's worker and the bus. Without tracing it is absent, and costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable

from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
from opentelemetry.sdk.resources import SERVICE_NAME, SERVICE_VERSION, Resource
from opentelemetry.sdk.trace import SpanProcessor, TracerProvider
from opentelemetry.sdk.trace.export import BatchSpanProcessor
from opentelemetry.sdk.trace.sampling import ParentBased, TraceIdRatioBased

from dray import __version__
from dray.adapters.telemetry.passing import PassingSession
from dray.adapters.telemetry.spans import Spans
from dray.messages import Event, Message
from dray.ports import Bus, Receive, Session

SERVICE = "dray"

EXPORT_S = 3.0
"""Timeout for one batch, all attempts together: an unreachable collector must not keep a process from ending."""


class TracedSession(PassingSession):
    """One agent's session on a traced bus (see `dray.ports.Session`).

    Args:
        inner: the wrapped session.
        spans: the agent's spans.
    """

    def __init__(self, inner: Session, spans: Spans) -> None:
        super().__init__(inner)
        self._spans = spans

    def publish(self, key: str, message: Message) -> None:
        """Publish to all subscribers of `key`, with the context."""
        if isinstance(message, Event):
            self._spans.tell(message)
        self.inner.context = self._spans.context_of(message)
        self.inner.publish(key, message)
        self.inner.context = ""

    def send(self, to: str, message: Message) -> None:
        """Send to one agent alone, with the context."""
        self.inner.context = self._spans.context_of(message)
        self.inner.send(to, message)
        self.inner.context = ""

    def leave(self) -> None:
        """Leave the bus; the agent's spans end here."""
        self.inner.leave()
        self._spans.close()


class TracedBus:
    """A bus whose agents are traced (see `dray.ports.Bus`).

    Args:
        bus: the bus itself.
        provider: the receiver of spans.
        to_wall_s: plant clock to wall clock.
    """

    def __init__(self, bus: Bus, provider: TracerProvider, to_wall_s: Callable[[float], float]) -> None:
        self._bus, self._to_wall_s = bus, to_wall_s
        self._tracer = provider.get_tracer(SERVICE, __version__)

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        """See `dray.ports.Bus.join`."""
        spans = Spans(agent, self._tracer, self._to_wall_s)

        def on_message(sender: str, message: Message) -> None:
            if inner.context:
                spans.on_message(message, inner.context)
            receive(sender, message)

        inner = self._bus.join(agent, on_message, life)
        return TracedSession(inner, spans)


def open_provider(share_frac: float, processor: SpanProcessor) -> TracerProvider:
    """The receiver of spans; shut it down at the end.

    Args:
        share_frac: the fraction of tasks that is traced, each of them wholly.
        processor: takes the ended spans.
    """
    provider = TracerProvider(
        sampler=ParentBased(TraceIdRatioBased(share_frac)),
        resource=Resource.create({SERVICE_NAME: SERVICE, SERVICE_VERSION: __version__}),
        shutdown_on_exit=False,
    )
    provider.add_span_processor(processor)
    return provider


def otlp(url: str) -> SpanProcessor:
    """Sends spans to a collector, in batches, on its own thread; drops them when the queue is full.

    Args:
        url: the collector's address, as http://127.0.0.1:4318/v1/traces.
    """
    return BatchSpanProcessor(OTLPSpanExporter(endpoint=url, timeout=EXPORT_S))
