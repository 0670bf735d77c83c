"""An OPC UA server on this computer for the machines, storages and gate of a simulated plant."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from dray.errors import UnavailableError
from dray.plant.model import Storage as StorageSpec

if TYPE_CHECKING:
    from dray_sim.controllers.opcua_server import ControllerServer


@contextmanager
def local_server(
    machines: Iterable[str], folder: Path, stores: Iterable[StorageSpec] = (), *, gate: bool = False
) -> Iterator[ControllerServer]:
    """A server on a free port of this machine, as long as the context lasts.

    Args:
        machines: ids of those that it has nodes for.
        folder: of their mapping files, as `M8.yaml`, which are written when there is a factory behind the server; it is
            made.
        stores: the storages and source warehouses that it has nodes for.
        gate: whether it has nodes for the gate.

    Raises:
        UnavailableError: asyncua is not installed, the server does not start, or the folder cannot be made.
    """
    if find_spec("asyncua") is None:
        raise UnavailableError("an OPC UA server", "asyncua is not installed", "install dray[opcua]")
    from dray_sim.controllers.opcua_server import ControllerServer  # noqa: PLC0415  It need not be installed.

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UnavailableError(str(folder), error.strerror or str(error), "choose another folder") from None
    with ControllerServer(machines, folder, stores, gate=gate) as server:
        yield server
