"""Types that several threads read are made ready while there is one thread: else msgspec ends the process."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from typing import cast

import msgspec
import pytest
from fake_bus import PLANT, FakeBus
from gateway_kit import AUTHORITY

from dray.gateway.app import create_app
from dray.gateway.live.timescale import TimeScale
from dray.settings import Settings
from dray.store import Store
from dray_sim.clock.loop import JUMP
from dray_sim.network.bridge import SimThread

THREADS = """
import sys, threading
import msgspec
from dray.shapes import prepare_shapes

sys.setswitchinterval(1e-6)
shapes = []
for number in range(40):
    shape = msgspec.defstruct(f"S{number}", [(f"f{field}", int, 0) for field in range(60)])
    for level in range(6):
        shape = msgspec.defstruct(f"S{number}_{level}", [("inner", shape | None, None), ("many", list[shape], [])])
    shapes.append(shape)
prepare_shapes()
for shape in shapes:
    begin = threading.Barrier(4)
    def read():
        begin.wait()
        msgspec.json.decode(b'{"inner": {"inner": {}}, "many": [{}]}', type=shape)
    threads = [threading.Thread(target=read) for _ in range(4)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
print("read")
"""


def test_four_threads_that_are_the_first_to_read_a_type_read_it() -> None:
    ended = subprocess.run([sys.executable, "-c", THREADS], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout.strip()) == (0, "read"), ended.stderr[-500:]


async def _ends(ready: Callable[[None], None]) -> None:
    ready(None)


def _begin_gateway() -> None:
    create_app(
        settings=Settings(),
        plant=PLANT,
        bus=FakeBus(),
        store=cast(Store, None),
        time=TimeScale(0.0, 0.0),
        authority=AUTHORITY,
    )


def _begin_factory() -> None:
    factory = SimThread(_ends, JUMP)
    factory.start()
    factory.stop()


@pytest.mark.parametrize("begin", [_begin_gateway, _begin_factory])
def test_who_is_about_to_begin_threads_makes_all_types_ready(
    begin: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []

    def tell() -> type:
        made.append("Told")
        return int

    # A type's annotations are evaluated when its table is made.
    monkeypatch.setitem(globals(), "tell", tell)

    class Told(msgspec.Struct):
        count: tell()  # type: ignore[valid-type]

    begin()
    assert made == [Told.__name__]
