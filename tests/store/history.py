"""What a small factory tells in one day, for the tests of the store."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from makings import making

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Event,
    EventsAsked,
    Message,
    Pose,
    Role,
    Transport,
)
from dray.messages.fact import (
    AnyFact,
    GoalContracted,
    GoodsDelivered,
    OrderAccepted,
    OrderFulfilled,
    PieceMade,
    TaskClosed,
    TaskOpened,
)
from dray.plant.model import BillLine, Product
from dray.ports import Receive
from dray.store import Store
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus

GEAR = Product(id="P1", name="Gear unit", lot=4, bill=(BillLine("steel", 1),))
PUMP = Product(id="P2", name="Pump", lot=4, bill=(BillLine("steel", 2),))

PRODUCTS = ("P1", "P2")
"""Of the items of every order here, in turn: all facts about one goal must name the same product."""


class Line:
    """A session and a bus for one listener: what the test says is heard at once.

    Attributes:
        keys: what the listener has subscribed to.
        asked: what it has asked, and whom.
        answer: what an agent answers when it is asked.
    """

    def __init__(self) -> None:
        self.heard_by: Receive | None = None
        self.keys: list[str] = []
        self.asked: list[tuple[str, EventsAsked]] = []
        self.answer: Callable[[str, EventsAsked], Iterable[Message]] = lambda _agent, _question: ()

    def join(self, agent: str, receive: Receive, life: int = 0) -> Line:
        self.heard_by = receive
        return self

    def subscribe(self, key: str) -> None:
        self.keys.append(key)

    def unsubscribe(self, key: str) -> None:
        self.keys.remove(key)

    def publish(self, key: str, message: Message) -> None:
        raise AssertionError("the historian says nothing to all")

    def send(self, to: str, message: Message) -> None:
        assert isinstance(message, EventsAsked)
        self.asked.append((to, message))
        for said in self.answer(to, message):
            self.say([said], by=to)

    def leave(self) -> None:
        self.heard_by = None

    def say(self, messages: Iterable[Message], by: str = "somebody") -> None:
        assert self.heard_by is not None
        for message in messages:
            self.heard_by(by, message)


def same_clock(plant_s: float) -> float:
    return plant_s


def order(number: int = 1, *quantities: int, status: OrderStatus = OrderStatus.RELEASED) -> Order:
    return Order(
        id=f"O-{number}",
        status=status,
        customer="Customer",
        token=f"token-{number}",
        items=tuple(Item(PRODUCTS[i % 2], quantity) for i, quantity in enumerate(quantities or (4,))),
        created_at_s=1000.0 + number,
        due_at_s=5000.0,
        releases=int(status is not OrderStatus.STORED),
        updated_at_s=1000.0 + number,
    )


async def keep(store: Store, *orders: Order) -> None:
    async with store.write() as work:
        await work.products.replace([GEAR, PUMP])
        for one in orders:
            await work.orders.add(one)


def tell(agent: str, *facts: AnyFact, life: int = 1, first: int = 1, at_s: float = 100.0) -> list[Event]:
    return [
        Event(agent=agent, incarnation=life, number=number, at_s=at_s + number, fact=fact)
        for number, fact in enumerate(facts, first)
    ]


def contracted(goal: str, item: int, quantity: int, order: str = "O-1", held: int = 0) -> GoalContracted:
    return GoalContracted(
        goal=goal,
        order=order,
        item=item,
        product=PRODUCTS[item],
        quantity=quantity,
        machine="M1",
        finish_s=900.0,
        held=held,
    )


def made(goal: str, count: int, item: int = 0) -> PieceMade:
    return PieceMade(goal=goal, product=PRODUCTS[item], made=count)


def delivered(goal: str, item: int, count: int, order: str = "O-1", quantity: int = 2) -> GoodsDelivered:
    return GoodsDelivered(
        goal=goal, order=order, item=item, product=PRODUCTS[item], quantity=quantity, delivered=count
    )


def accepted(*goals: str, order: str = "O-1", held: int = 0) -> OrderAccepted:
    return OrderAccepted(order=order, goals=goals, held=held)


def a_day() -> list[Event]:
    """Order O-1 with 4 and 2 pieces is made and delivered."""
    fetch = Transport(item="P1", quantity=2, sources=("M1",), destination="W", ability="tote", goal="G1")
    return [
        *tell(
            "strategist",
            accepted("G1", "G2"),
            TaskOpened(
                task="G1",
                epoch=1,
                role=Role.PRIMARY,
                round=1,
                work=making("P1", 4, "O-1"),
                radius_m=0.0,
                deadline_s=900.0,
                bids_until_s=101.0,
            ),
            contracted("G1", 0, 4),
            contracted("G2", 1, 2),
            OrderFulfilled(order="O-1"),
        ),
        *tell(
            "M1",
            made("G1", 1),
            made("G1", 2),
            TaskOpened(
                task="M1-1",
                epoch=1,
                role=Role.PRIMARY,
                round=1,
                work=fetch,
                radius_m=20.0,
                deadline_s=900.0,
                bids_until_s=105.0,
            ),
            made("G1", 3),
            TaskClosed(task="M1-1", epoch=1, outcome="delivered", carrier="ATV-1"),
            delivered("G1", 0, 2),
            made("G1", 4),
            delivered("G1", 0, 4),
            at_s=200.0,
        ),
        *tell("M2", made("G2", 1, item=1), made("G2", 2, item=1), delivered("G2", 1, 2), at_s=300.0),
    ]


def heartbeat(seq: int, at_s: float, atv: str = "ATV-1") -> AtvHeartbeat:
    return AtvHeartbeat(
        atv=atv,
        incarnation=1,
        seq=seq,
        at_s=at_s,
        status=AtvStatus.IDLE,
        pose=Pose(1.0, 2.0, 0.0),
        node="n1",
        speed_mps=0.0,
        battery_frac=0.8,
    )
