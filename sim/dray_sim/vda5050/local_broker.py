"""A broker on this computer, for demonstrations, benchmarks and experiments."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from dray.adapters.vda5050.link import BrokerAddress
from dray.errors import UnavailableError

PAYLOAD_BYTES = 2**20
"""The longest message that the broker takes: far longer than a state."""


@contextmanager
def local_broker() -> Iterator[BrokerAddress]:
    """A broker on a free port of this machine, as long as the context lasts.

    Raises:
        UnavailableError: none is installed, or it does not start.
    """
    if find_spec("iotcore") is None:
        raise UnavailableError(
            "an MQTT broker", "iotcore is not installed", "install dray[demo], or give --broker URL"
        )
    from iotcore import Broker  # noqa: PLC0415  It need not be installed.

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    try:
        broker = Broker(port=port, listen="127.0.0.1", max_payload_size=PAYLOAD_BYTES).start()
    except (OSError, RuntimeError) as error:
        raise UnavailableError("an MQTT broker", str(error), "try again, or give --broker URL") from None
    try:
        yield BrokerAddress("127.0.0.1", port, tls=False)
    finally:
        broker.stop()
