"""The link to a controller with an OPC UA server: it subscribes to the inputs, and writes the outputs."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

from asyncua import ua
from asyncua.client.client import Client
from asyncua.common.node import Node
from asyncua.crypto import security_policies
from asyncua.ua.uaerrors import UaError, UaStatusCodeError

from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import LinkListener, Quality, Sample, Signal, Tag, Value, is_told
from dray.errors import SettingsError, UnavailableError
from dray.supervision import Failures

ANSWER_S = 4.0
"""Seconds without an answer after which a controller counts as away."""

LOOK_S = 1.0
"""Seconds between checks of the server, and between our signs of life (`Signal.ALIVE`)."""

PERIOD_MS, SAMPLING_MS, QUEUE = 200.0, ua.Duration(50.0), 100
"""The server's publishing interval, sampling interval, and queue size; the queue is needed because each pulse is a change."""

AGAIN_S = (0.5, 1.0, 2.0, 4.0)
"""Delays between attempts; the last one repeats."""

REFUSED_AGAIN_S = 5.0
"""Delay before a refused value is written again."""

ALIVE_MODULUS = 30_000
"""It fits into every numeric type but a byte, where it is cut to 100."""

_POLICIES: dict[str, type[Any]] = {
    "Basic256Sha256": security_policies.SecurityPolicyBasic256Sha256,
    "Aes128Sha256RsaOaep": security_policies.SecurityPolicyAes128Sha256RsaOaep,
    "Aes256Sha256RsaPss": security_policies.SecurityPolicyAes256Sha256RsaPss,
}

_INTEGERS = {
    ua.VariantType.SByte: (7, 8),
    ua.VariantType.Byte: (8,),
    ua.VariantType.Int16: (15, 16),
    ua.VariantType.UInt16: (16,),
    ua.VariantType.Int32: (31, 32),
    ua.VariantType.UInt32: (32,),
    ua.VariantType.Int64: (63, 64),
    ua.VariantType.UInt64: (64,),
}
"""Bits of a counter of each type: a signed one restarts at 0, or continues below it."""

GO = (Signal.RUN, Signal.DOCK_PERMIT, Signal.ADMITTED)
"""Signals that are written last: a controller may act on them at once, by the product, vehicle or label that it was told before."""

LARGEST_FLOAT = 3.4e38
"""Of 32 bits, nearly."""

# It logs each request at INFO, and at WARNING what its caller is told anyway.
logging.getLogger("asyncua").setLevel(logging.ERROR)


class OpcUaLink:
    """A session that is reopened after each loss.

    Args:
        mapping: the controller's address, and its nodes.
        folder: the mapping file's folder, for its certificates.
        password: its user's password.

    Attributes:
        linked: set at the first reception of all values.
        failures: errors of the listener, by signal.
    """

    def __init__(self, mapping: OpcUaMapping, folder: Path, password: str = "") -> None:
        self._mapping, self._folder, self._password = mapping, folder, password
        self._changed = asyncio.Event()
        self.linked = asyncio.Event()
        self.failures = Failures(mapping.url)

    def write(self) -> None:
        """The listener's outputs have changed."""
        self._changed.set()

    async def run(self, listener: LinkListener) -> None:
        """Stay linked until cancelled, whatever errors a value causes in the listener.

        Raises:
            SettingsError: a certificate cannot be used.
            UnavailableError: raised by the listener.
        """
        attempt = 0
        while True:
            session = _Session(self._mapping, listener, self._changed, self.linked, self.failures.tell)
            client = await self._client()
            try:
                reason = await session.serve(client)
            except (OSError, TimeoutError, UaError) as error:
                reason = words(error)
            finally:
                await _leave(client)
            attempt = 0 if session.was_linked else attempt + 1
            self.failures.tell("the link", listener.on_link_lost, f"{self._mapping.url}: {reason}")
            await asyncio.sleep(AGAIN_S[min(attempt, len(AGAIN_S) - 1)])

    async def _client(self) -> Client:
        return await connection(self._mapping, self._folder, self._password)


async def connection(mapping: OpcUaMapping, folder: Path, password: str) -> Client:
    """A client that is not connected yet.

    Args:
        mapping: the controller's address.
        folder: the mapping file's folder, for its certificates.
        password: its user's password.

    Raises:
        SettingsError: a certificate cannot be used.
    """
    client = Client(mapping.url, timeout=ANSWER_S, watchdog_intervall=LOOK_S)
    client.name = client.description = "Dray"
    if mapping.user:
        client.set_user(mapping.user)
        client.set_password(password)
    if mapping.security != "none":
        files = {name: folder / getattr(mapping, name) for name in ("certificate", "key", "server")}
        for name, file in files.items():
            if not file.is_file():
                raise SettingsError("--mapping", f"{name}: there is no file {file}")
        try:
            await client.set_security(
                _POLICIES[mapping.security], files["certificate"], files["key"], None, str(files["server"])
            )
        except Exception as error:  # noqa: BLE001 - the library raises whatever its own parser does
            raise SettingsError("--mapping", f"the certificates of {mapping.url}: {words(error)}") from None
    return client


async def find(client: Client, node: str) -> Node:
    """The node of a tag.

    Args:
        client: a connected client.
        node: a node id, also with `nsu=` for a namespace's address; or a path of browse names from Objects.

    Raises:
        UaError: there is no such node.
        ValueError: the text has neither form.
    """
    if "=" not in node:
        return await client.nodes.objects.get_child(node.split("/"))
    if node.startswith("nsu="):
        uri, _, rest = node.removeprefix("nsu=").partition(";")
        node = f"ns={await client.get_namespace_index(uri)};{rest}"
    return client.get_node(ua.NodeId.from_string(node))


class _Session:
    """One connection, until its loss."""

    def __init__(
        self,
        mapping: OpcUaMapping,
        listener: LinkListener,
        changed: asyncio.Event,
        linked: asyncio.Event,
        tell: Callable[..., None],
    ) -> None:
        self._tags, self._listener, self._changed, self._tell = mapping.tags, listener, changed, tell
        self._linked = linked
        self._lost: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self._signals: dict[ua.NodeId, list[str]] = {}
        """Signals by node; one node may carry several."""
        self._outputs: dict[str, tuple[Node, ua.VariantType]] = {}
        self._written: dict[str, Value] = {}
        self._refused: dict[str, tuple[Value, float]] = {}
        """Refused values by signal, and when each is written again (time of the loop)."""
        self._beat = 0
        self.was_linked = False

    async def serve(self, client: Client) -> str:
        """Stay linked, and return the reason of the loss.

        Raises:
            OSError, TimeoutError, UaError: the controller is unreachable, or lacks a node of the mapping.
        """
        client.connection_lost_callback = self._on_lost
        await client.connect()
        told = await self._find_all(client)
        for node in told:
            self._take(node.nodeid, await node.read_data_value(raise_on_bad_status=False))
        self._tell("the link", self._listener.on_link)
        self.was_linked = True
        self._linked.set()
        subscription = await client.create_subscription(PERIOD_MS, self)
        await subscription.subscribe_data_change(told, queuesize=QUEUE, sampling_interval=SAMPLING_MS)
        writing = asyncio.ensure_future(self._write_all())
        try:
            await asyncio.wait((self._lost, writing), return_when=asyncio.FIRST_COMPLETED)
        finally:
            writing.cancel()
            await asyncio.gather(writing, return_exceptions=True)
        if self._lost.done():
            return self._lost.result()
        writing.result()
        raise AssertionError("writing ends by an error only")

    # --- what the controller tells: called by the subscription ---

    def datachange_notification(self, node: Node, _value: Any, data: Any) -> None:
        """A value has changed."""
        self._take(node.nodeid, data.monitored_item.Value)

    def status_change_notification(self, status: ua.StatusChangeNotification) -> None:
        """The controller has ended the subscription."""
        self._end(f"it has ended the subscription: {status.Status}")

    async def _on_lost(self, error: Exception) -> None:
        self._end(words(error))

    def _end(self, reason: str) -> None:
        if not self._lost.done():
            self._lost.set_result(reason)

    def _take(self, node: ua.NodeId, data: ua.DataValue) -> None:
        try:
            for signal in self._signals[node]:
                self._tell(signal, self._listener.on_sample, signal, sample_of(data))
        except UnavailableError as error:
            if not self._lost.done():
                self._lost.set_exception(error)

    # --- what it is told ---

    async def _write_all(self) -> None:
        clock = asyncio.get_running_loop()
        while True:
            self._changed.clear()
            self._beat += 1
            for signal, (node, kind) in self._outputs.items():
                value: Value | None = (
                    self._beat
                    % (100 if kind in (ua.VariantType.Byte, ua.VariantType.SByte) else ALIVE_MODULUS)
                    if signal == Signal.ALIVE
                    else self._listener.outputs.get(signal)
                )
                refused, again_s = self._refused.get(signal, (None, 0.0))
                is_early = clock.time() < again_s
                if value is None or (is_early and (value == refused or signal == Signal.ALIVE)):
                    continue
                if signal in GO and self._changed.is_set():
                    break  # What was written before it in this round may be outdated.
                if self._written.get(signal) == value:
                    # Another value may have been wanted for a moment; it was not written.
                    self._tell(signal, self._listener.on_written, signal, value)
                    if refused is not None and not is_early:
                        self._accept(signal)
                    continue
                try:
                    await node.write_value(ua.DataValue(ua.Variant(_as(value, kind), kind)))
                except (UaStatusCodeError, ValueError, TypeError, OverflowError, struct.error) as error:
                    self._refused[signal] = value, clock.time() + REFUSED_AGAIN_S
                    # What is wanted next is written, also if that was written before the refused value.
                    self._written.pop(signal, None)
                    self._tell(signal, self._listener.on_refused, signal, words(error))
                    continue
                self._written[signal] = value
                if signal != Signal.ALIVE:
                    self._tell(signal, self._listener.on_written, signal, value)
                if value == refused or not is_early:
                    self._accept(signal)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(LOOK_S):
                    await self._changed.wait()

    def _accept(self, signal: str) -> None:
        """Tell that nothing is refused any more.

        After a refusal another value is written at once, and this is told later: a listener may want the refused value again then.
        """
        self._refused.pop(signal, None)
        self._tell(signal, self._listener.on_refused, signal, "")

    async def _find_all(self, client: Client) -> list[Node]:
        """Find every node of the mapping; return those to be read."""
        told: list[Node] = []
        for signal, tag in self._tags.items():
            try:
                node = await find(client, tag.node)
                kind = await node.read_data_type_as_variant_type()
            except (UaError, ValueError) as error:
                raise ConnectionError(f"{signal}: {tag.node}: {words(error)}") from None
            if is_told(signal):
                if node.nodeid not in self._signals:
                    told.append(node)
                self._signals.setdefault(node.nodeid, []).append(signal)
                self._say_range(signal, tag, kind)
            else:
                self._outputs[signal] = node, kind
        self._outputs = dict(sorted(self._outputs.items(), key=lambda output: output[0] in GO))
        return told

    def _say_range(self, signal: str, tag: Tag, kind: ua.VariantType) -> None:
        if kind in _INTEGERS and signal in (Signal.PIECES, Signal.BAD):
            moduli = tuple(int(2**bits / tag.scale) for bits in _INTEGERS[kind])
            self._tell("the link", self._listener.on_range, signal, moduli)


def sample_of(data: ua.DataValue) -> Sample:
    """A value of the controller."""
    status = data.StatusCode
    if status is not None and not status.is_good():
        quality = Quality.UNCERTAIN if status.is_uncertain() else Quality.BAD
        return Sample("", quality, status.name)
    value = None if data.Value is None else data.Value.Value
    if isinstance(value, ua.LocalizedText):
        value = value.Text or ""
    if value is None and data.Value is not None and data.Value.VariantType is ua.VariantType.String:
        value = ""  # The protocol has an empty text and none, and controllers use both.
    if isinstance(value, bool | int | float | str):
        return Sample(value)
    return Sample(
        "",
        Quality.BAD,
        "it is empty" if value is None else f"it is no single value but a {type(value).__name__}",
    )


def words(error: BaseException) -> str:
    """A library error as a text for people."""
    text = str(error).strip()
    name = type(error).__name__
    if isinstance(error, TimeoutError | asyncio.TimeoutError):
        return "it does not answer"
    return f"{name}: {text}"[:300] if text else name


def _as(value: Value, kind: ua.VariantType) -> Value:
    """Convert a value to its node's type; a number beyond its range becomes the nearest one in it.

    Raises:
        ValueError: conversion is impossible.
    """
    if kind is ua.VariantType.Boolean:
        return bool(value)
    if kind in _INTEGERS:
        bits = _INTEGERS[kind]
        lowest, highest = (0 if len(bits) == 1 else -(1 << bits[0])), (1 << bits[0]) - 1
        return min(max(round(float(value)), lowest), highest)
    if kind is ua.VariantType.Float:
        return min(max(float(value), -LARGEST_FLOAT), LARGEST_FLOAT)
    if kind is ua.VariantType.Double:
        return float(value)
    if kind is ua.VariantType.String:
        return str(value)
    raise ValueError(f"a node of type {kind.name} cannot be told {value!r}")


async def _leave(client: Client) -> None:
    """Close a session in any state."""
    with contextlib.suppress(Exception):
        async with asyncio.timeout(ANSWER_S):
            await client.disconnect()
    client.disconnect_socket()
