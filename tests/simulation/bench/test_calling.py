"""The figures of the benchmark `calls`: what was not brought once and whole is counted as missing."""

from __future__ import annotations

from dray.messages import Event, TransportState, TransportWait
from dray.messages.fact import TransportProgressed
from dray_sim.bench.losses.calling import Called, rows_of
from dray_sim.bench.rest_work.calls import PIECES, Callers

HOW = ("once", "twice", "in part", "called off", "not told", "recurring")


def told(transport: str, number: int, at_s: float, state: TransportState, quantity: int = PIECES) -> Event:
    fact = TransportProgressed(
        transport=transport,
        state=state,
        item="shaft",
        quantity=quantity,
        source="S1",
        destination="M1",
        wait=TransportWait.UNDECIDED if state is TransportState.WAITING else None,
        carrier="ATV1" if state is TransportState.ASSIGNED else "",
    )
    return Event(agent="M1", incarnation=1, number=number, at_s=at_s, fact=fact)


def history() -> list[Event]:
    events: list[Event] = []
    for name in HOW:
        events.append(told(name, len(events) + 1, 12.0, TransportState.ASSIGNED))
        end = TransportState.CANCELLED if name == "called off" else TransportState.DELIVERED
        pieces = PIECES - 1 if name == "in part" else PIECES
        for _ in range(2 if name == "twice" else 1):
            events.append(told(name, len(events) + 1, 40.0, end, pieces))
    return events


def test_only_what_was_brought_once_and_whole_counts() -> None:
    called = Called(5, 1, Callers({"a program": [*HOW[:5]]}, [0.5], []), ["R-1"])
    called.found = [
        {"id": name, "status": "waiting" if name == "not told" else "delivered"}
        for name in (*HOW, "nobody's")
    ]
    called.runs = [{"id": "R-1", "last": {"transport": "recurring"}}]
    rows = {
        row.name: row for row in rows_of(called, history(), dict.fromkeys(HOW, 10.0), "killed: 1 x gateway")
    }
    figures = [
        rows[f"calls: {name}"] for name in ("answered with 201, brought once", "recurring, brought once")
    ]
    assert [(row.figure, row.met) for row in figures] == [(1, False), (1, True)]
    assert "killed: 1 x gateway" in figures[0].note
    assert rows["calls: transports that nobody has called"].figure == 1
    won, done = (rows[f"calls: from call to {what}, p95"] for what in ("bid won", "delivery"))
    assert (won.figure, done.figure) == (2.0, 30.0)
