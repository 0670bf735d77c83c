"""The link of one vehicle's master to its broker: MQTT on asyncio, reconnected after each loss.

It is thin on purpose: `control` decides on the messages. QoS is 0 but for `connection`, as the standard wants. The body is told
about a lost broker. Messages of that time are not kept, since the master repeats what matters.
"""

from __future__ import annotations

import asyncio
import ssl
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Protocol
from urllib.parse import urlsplit

import aiomqtt
import msgspec

from dray.errors import SettingsError
from dray.supervision import Failures

PORT, TLS_PORT = 1883, 8883
"""Customary ports of brokers, without and with TLS."""

KEEPALIVE_S = 10
"""MQTT keepalive; a broker silent for half as much again is gone."""

CONNECT_S = 5.0
"""Timeout of the MQTT handshake, once the connection is open."""

AGAIN_S = (0.5, 1.0, 2.0, 5.0)
"""Delays between attempts; the last one repeats."""

UNSAID_MAX = 200
"""Maximum waiting outgoing messages: a healthy link has none."""

UNHEARD_MAX = 1000
"""Maximum waiting incoming messages: ten states a second for more than a minute. The client drops more."""


OTHER_TOPIC = "another topic"
"""The name for messages on other topics in the count of failures."""


class BrokerAddress(msgspec.Struct, frozen=True):
    """A broker's address and login."""

    host: str
    port: int
    tls: bool
    user: str = ""
    password: str = ""
    authority: Path | None = None
    """The authority of the broker's certificate, as PEM; None for those that the computer trusts."""
    certificate: Path | None = None
    key: Path | None = None
    """Our own key, where the broker asks for a certificate."""

    def __str__(self) -> str:
        return f"{'mqtts' if self.tls else 'mqtt'}://{self.host}:{self.port}"

    def context(self) -> ssl.SSLContext | None:
        """The TLS context; None without TLS.

        Raises:
            SettingsError: a file cannot be used; names it.
        """
        if not self.tls:
            return None
        try:
            context = ssl.create_default_context(cafile=self.authority)
        except (OSError, ssl.SSLError) as error:
            raise SettingsError("DRAY_BROKER_AUTHORITY", f"{self.authority}: {error}") from None
        if self.certificate is not None:
            try:
                context.load_cert_chain(self.certificate, self.key)
            except (OSError, ssl.SSLError) as error:
                raise SettingsError("DRAY_BROKER_CERTIFICATE", f"{self.certificate}: {error}") from None
        return context


def read_address(text: str) -> tuple[str, int, bool]:
    """Host, port and use of TLS, from mqtt://HOST:PORT or mqtts://HOST:PORT.

    Raises:
        ValueError: it has another form.
    """
    parts = urlsplit(text)
    if parts.scheme not in ("mqtt", "mqtts") or not parts.hostname or parts.path.strip("/") or parts.username:
        raise ValueError(
            "write it as mqtt://HOST:1883, or as mqtts://HOST:8883 for TLS; no name and password in it"
        )
    tls = parts.scheme == "mqtts"
    return parts.hostname, parts.port or (TLS_PORT if tls else PORT), tls


class Listener(Protocol):
    """The receiver of messages. Its exceptions are our own bugs and end no link, except `UnavailableError`: a full disk, say."""

    def on_link(self) -> None:
        """The broker is connected, and the topics are subscribed to."""

    def on_link_lost(self, reason: str) -> None:
        """The connection to the broker is lost."""

    def on_message(self, topic: str, data: bytes) -> None:
        """A message has come on one of the topics (the last chunk)."""


class MqttLink:
    """A connection to a broker, reopened after each loss.

    Args:
        broker: its address.
        prefix: of the vehicle's topics, MANUFACTURER/SERIAL included; empty where the topics are whole.
        client: our client name at the broker; a second client of this name ends the first.
        topics: the subscribed topics, as last chunks.
        retained: receives retained messages instead of the listener; None for the listener.
        will: a vehicle's last will on `connection`. None for none.

    Attributes:
        dropped: outgoing messages lost while the broker was away, or beyond the maximum.
        failures: errors of the listener, by topic.
    """

    def __init__(
        self,
        broker: BrokerAddress,
        prefix: str,
        client: str,
        topics: Iterable[str],
        will: bytes | None = None,
        retained: Callable[[str, bytes], None] | None = None,
    ) -> None:
        self._retained = retained
        self._broker, self._prefix, self._client = broker, prefix, client
        self._topics = tuple(topics)
        self._will = None if will is None else aiomqtt.Will(f"{prefix}/connection", will, qos=1, retain=True)
        self._context = broker.context()
        self._unsaid: asyncio.Queue[tuple[str, bytes, bool]] | None = None
        """None while the broker is away."""
        self.dropped = 0
        self.failures = Failures(prefix)

    def publish(self, topic: str, data: bytes, *, retain: bool = False) -> None:
        """Publish on one of the vehicle's topics (the last chunk); dropped and counted while the broker is away."""
        if self._unsaid is None:
            self.dropped += 1
            return
        try:
            self._unsaid.put_nowait((topic, data, retain))
        except asyncio.QueueFull:
            self.dropped += 1

    async def run(self, listener: Listener) -> None:
        """Stay linked until cancelled, whatever errors a message causes in the listener.

        Raises:
            UnavailableError: raised by the listener.

        The loop checks for cancellation itself, because it can get lost: in `asyncio.wait_for` in the client, and in the
        client's own end, whose error replaces the cancellation.
        """
        attempt = 0
        while True:
            try:
                async with self._connect() as client:
                    for topic in self._topics:
                        await client.subscribe(self._whole(topic), qos=1 if topic == "connection" else 0)
                    _end_if_cancelled()
                    attempt, self._unsaid = 0, asyncio.Queue(UNSAID_MAX)
                    self.failures.tell("the link", listener.on_link)
                    await self._serve(client, self._unsaid, listener)
            except (aiomqtt.MqttError, OSError, ValueError) as error:
                # A ValueError is the client's error for an impossible address or message.
                self._unsaid = None
                _end_if_cancelled()
                self.failures.tell("the link", listener.on_link_lost, f"{self._broker}: {_words(error)}")
            finally:
                self._unsaid = None
            await asyncio.sleep(AGAIN_S[min(attempt, len(AGAIN_S) - 1)])
            attempt += 1

    def _connect(self) -> aiomqtt.Client:
        broker = self._broker
        return aiomqtt.Client(
            broker.host,
            broker.port,
            username=broker.user or None,
            password=broker.password or None,
            identifier=self._client,
            timeout=CONNECT_S,
            keepalive=KEEPALIVE_S,
            max_queued_incoming_messages=UNHEARD_MAX,
            tls_context=self._context,
            will=self._will,
        )

    async def _serve(
        self, client: aiomqtt.Client, unsaid: asyncio.Queue[tuple[str, bytes, bool]], listener: Listener
    ) -> None:
        saying = asyncio.create_task(self._say(client, unsaid))
        try:
            async for message in client.messages:
                whole = message.topic.value
                topic = whole.rpartition("/")[2] if self._prefix else whole
                self.failures.tell(
                    topic if topic in self._topics else OTHER_TOPIC,
                    self._retained if message.retain and self._retained else listener.on_message,
                    topic,
                    bytes(message.payload),
                )
                if saying.done():
                    break
        finally:
            saying.cancel()
            results = await asyncio.gather(saying, return_exceptions=True)
        for result in results:
            if isinstance(result, Exception):
                raise result

    def _whole(self, topic: str) -> str:
        return f"{self._prefix}/{topic}" if self._prefix else topic

    async def _say(self, client: aiomqtt.Client, unsaid: asyncio.Queue[tuple[str, bytes, bool]]) -> None:
        while True:
            topic, data, retain = await unsaid.get()
            await client.publish(
                self._whole(topic), data, qos=1 if topic == "connection" else 0, retain=retain
            )
            _end_if_cancelled()


def _end_if_cancelled() -> None:
    """End a task that missed its cancellation.

    Raises:
        asyncio.CancelledError: the task was cancelled.
    """
    task = asyncio.current_task()
    if task is not None and task.cancelling():
        raise asyncio.CancelledError


def _words(error: Exception) -> str:
    text = str(error).strip()
    return text[:200] if text else type(error).__name__
