"""Examples for the OpenAPI document: one consistent moment of a small factory."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import msgspec

from dray.gateway.factory.figures import KpiHistory, KpiPoint
from dray.gateway.factory.promises import ON_TIME_S, PromiseLedger, PromiseLine
from dray.gateway.http.csv_rows import RowFault
from dray.gateway.live.reasons import REMOVAL_REFUSALS
from dray.gateway.live.views import (
    AtvView,
    BidView,
    BriefView,
    BufferView,
    CarrierView,
    FactoryView,
    GoalView,
    MachineView,
    OpenTaskView,
    RefusalView,
    RemovalRefusalView,
    RemovalView,
    SilenceView,
    TaskView,
    UseView,
)
from dray.gateway.orders.feasibility import MachineOffer, MaterialNeed, OrderPreview, StorageShare
from dray.gateway.routes.factory.agents import EXAMPLE as EXCLUSION
from dray.gateway.routes.factory.alerts import EXAMPLE as ALERT
from dray.gateway.routes.factory.floor.closures import EXAMPLE as CLOSURE
from dray.gateway.routes.factory.floor.obstacles import EXAMPLE as OBSTACLE
from dray.gateway.routes.factory.floor.waits import EXAMPLE as WAIT
from dray.gateway.routes.factory.inventory import InventoryLine, MaterialAnswer, StorageAnswer, StoredMaterial
from dray.gateway.routes.factory.plant_draft_bodies import EXAMPLE as DRAFT
from dray.gateway.routes.factory.plant_draft_bodies import PLAY_EXAMPLE
from dray.gateway.routes.factory.plant_drafts import LINE_EXAMPLE
from dray.gateway.routes.history.alerts import EXAMPLE as ALERT_RECORD
from dray.gateway.routes.history.audit import AuditLine
from dray.gateway.routes.history.events import EventAnswer
from dray.gateway.routes.history.kept import EXAMPLE as KEPT
from dray.gateway.routes.history.replay import EXAMPLES as REPLAY
from dray.gateway.routes.history.reports import EXAMPLES as REPORTS
from dray.gateway.routes.history.tasks import EXAMPLE as TASK_RECORD
from dray.gateway.routes.keys import EXAMPLE as KEY
from dray.gateway.routes.keys import NEW_EXAMPLE as NEW_KEY
from dray.gateway.routes.orders.imports import ImportAnswer, ImportedOrder
from dray.gateway.routes.orders.links import LinksRevoked, NewLink
from dray.gateway.routes.orders.orders import EXAMPLE as ORDER
from dray.gateway.routes.orders.schedules import EXAMPLES as SCHEDULES
from dray.gateway.routes.orders.timeline import EXAMPLE as STORY
from dray.gateway.routes.orders.transports import EXAMPLE as TRANSPORT
from dray.gateway.routes.people import EXAMPLE as PERSON
from dray.gateway.routes.people import LINK_EXAMPLE as LOGIN_LINK
from dray.gateway.routes.products.imports import ImportedProduct, ProductsAnswer
from dray.gateway.routes.products.products import EXAMPLE as PRODUCT
from dray.gateway.routes.products.removal import DEFINITION, REMOVED
from dray.gateway.tracking.answer import TrackAnswer, TrackEta, TrackStage
from dray.gateway.tracking.track import StageName, TrackedItem
from dray.messages import RemovalRefusal
from dray.plant import default_plant

NOW_S = ORDER.created_at_s + 60.0
"""A minute after the example's order was placed."""

SHOWN = 2
"""Maximum entries per section of the plant: the whole file is too long for an example."""

PARTS_S = {"empty_way": 14.0, "loaded_way": 31.5, "energy": 2.5, "suitability": 0.0}

PROMISES = PromiseLine(
    atv="",
    delivered=40,
    on_time=38,
    on_time_frac=0.95,
    median_s=-1.2,
    p95_s=4.1,
    worst_s=21.5,
    worst_task="M1.1-7",
    lost=1,
    last_at_s=NOW_S - 5,
)

_STRUCTS = (
    *REPLAY,
    *REPORTS,
    KEPT,
    ORDER,
    ALERT,
    ALERT_RECORD,
    EXCLUSION,
    CLOSURE,
    DRAFT,
    LINE_EXAMPLE,
    PLAY_EXAMPLE,
    DRAFT.findings[0],
    OBSTACLE,
    *SCHEDULES,
    TRANSPORT,
    WAIT,
    TrackAnswer(
        status=ORDER.status,
        reference=ORDER.reference,
        items=tuple(
            TrackedItem(i.product, "Gear unit", i.quantity, i.made, i.delivered) for i in ORDER.items
        ),
        stages=tuple(
            TrackStage(stage.value, index < 1, ORDER.created_at if index < 1 else None)
            for index, stage in enumerate(StageName)
        ),
        eta=TrackEta("2030-01-01T01:25:00Z", "2030-01-01T01:45:00Z"),
        late="",
        reasons=(),
        materials=(),
        created_at=ORDER.created_at,
        due_at=ORDER.due_at,
        delivered_at=None,
    ),
    RemovalView(
        number=1,
        by="Early shift",
        at_s=NOW_S,
        believed_at_s=NOW_S + 12,
        freed=("b3", "c3"),
        refused=(
            RemovalRefusalView(
                agent="M4",
                reason=RemovalRefusal.HEARD_SINCE,
                text=REMOVAL_REFUSALS[RemovalRefusal.HEARD_SINCE],
            ),
        ),
    ),
    InventoryLine(item="P1", place="M1", kind="goods", quantity=3, capacity=8, spare=1, seen_at_s=NOW_S),
    StorageAnswer(id="S1", name="North", node="n4", stocks=(StoredMaterial("shaft", 200),)),
    MaterialAnswer(
        id="shaft", name="Shaft", lot=20, storages=("S1",), at_machines=8, on_board=20, on_order=20
    ),
    PRODUCT,
    MachineView(
        id="M1",
        name="Lathe",
        status="producing",
        product="P1",
        goals=(GoalView(goal="strategist.1-1", product="P1", quantity=5, made=1, to_begin=4, delivered=0),),
        tasks=(
            OpenTaskView(
                task="M1.1-1",
                epoch=1,
                item="shaft",
                quantity=20,
                source="S1",
                destination="M1",
                deadline_at_s=NOW_S + 300,
                primary="ATV2",
                secondary="ATV1",
            ),
        ),
        buffers=(BufferView(item="shaft", level=8, capacity=60, reorder_point=10, on_order=20),),
        goods=(BufferView(item="P1", level=1, capacity=8),),
        seen_at_s=NOW_S,
        silence=SilenceView(beat_s=1.0, overdue_after_s=1.5, lost_after_s=3.5),
    ),
    AtvView(
        id="ATV2",
        type="light",
        status="working",
        x_m=17.0,
        y_m=5.0,
        heading_rad=0.0,
        speed_mps=1.2,
        node="b1",
        way=("c1", "d1"),
        battery_frac=0.82,
        task=BriefView(
            task="M1.1-1",
            epoch=1,
            role="primary",
            coordinator="M1",
            phase="approaching",
            item="shaft",
            quantity=20,
            due_at_s=NOW_S + 48,
        ),
        seen_at_s=NOW_S,
        silence=SilenceView(beat_s=1.0, overdue_after_s=1.5, lost_after_s=3.5),
    ),
    TaskView(
        id="M1.1-1",
        kind="transport",
        coordinator="M1",
        item="shaft",
        quantity=20,
        sources=("S1", "S2"),
        source="S1",
        destination="M1",
        radius_m=20.0,
        state="contracted",
        phase="approaching",
        primary="ATV2",
        secondary="ATV1",
        opened_at_s=NOW_S - 3,
        contracted_at_s=NOW_S - 1,
        promised_at_s=NOW_S + 48,
        deadline_at_s=NOW_S + 300,
        carriers=(CarrierView(carrier="ATV2", epoch=1, since_at_s=NOW_S - 1),),
        bids=(
            BidView(
                bidder="ATV2",
                role="primary",
                round=1,
                total_s=sum(PARTS_S.values()),
                parts_s=PARTS_S,
                finish_at_s=NOW_S + 48,
                source="S1",
                answer="accepted",
            ),
        ),
        refusals=(RefusalView(agent="ATV3", role="primary", round=1, reason="busy"),),
    ),
    PromiseLedger(
        on_time_within_s=ON_TIME_S,
        fleet=PROMISES,
        items=(msgspec.structs.replace(PROMISES, atv="ATV2"),),
    ),
    STORY,
    NewLink(ORDER.tracking_url, NOW_S + 30 * 86_400.0),
    LinksRevoked(2),
    PERSON,
    LOGIN_LINK,
    KEY,
    NEW_KEY,
    ImportAnswer(
        orders=(
            ImportedOrder(id=ORDER.id, customer=ORDER.customer, reference=ORDER.reference, items=1, pieces=5),
        ),
        faults=(),
        hints=(
            RowFault.of(
                2,
                "reference",
                "placed_already",
                customer=ORDER.customer,
                order="O-1M9K3WZ7P-2TQA",
                minutes=12,
            ),
        ),
    ),
    DEFINITION,
    REMOVED,
    ProductsAnswer(
        products=(ImportedProduct(id="P1", name="Gear unit", becomes="changed", revision=2),),
        faults=(),
        hints=(),
    ),
    OrderPreview(
        materials=(
            MaterialNeed(
                material="shaft",
                needed=40,
                loads=2,
                wanted=80,
                at_machines=35,
                storages=(StorageShare("S1", 400),),
                refills=False,
            ),
        ),
        machines=(
            MachineOffer(machine="M1", status="producing", available=True, queue_s=540.0, pieces=20),
            MachineOffer(machine="M2", status="idle", available=True, queue_s=0.0, pieces=20),
        ),
        cannot=(),
        earliest_at_s=NOW_S + 1500.0,
        latest_at_s=NOW_S + 2400.0,
        late="maybe",
    ),
    KpiHistory(
        since_at_s=NOW_S - 660.0,
        until_at_s=NOW_S - 60.0,
        step_s=300.0,
        items=tuple(
            KpiPoint(
                at_s=at_s,
                span_s=300.0,
                orders_delivered=2,
                on_time_frac=1.0,
                starved_frac=0.02,
                transports=3,
                transports_per_hour=36.0,
                transport_p50_s=84.0,
                transport_p95_s=162.0,
                empty_frac=0.46,
                moving_frac=0.42,
                waiting_frac=0.13,
                charging_frac=0.15,
                blocked_frac=0.01,
                idle_frac=0.29,
                silent_frac=0.0,
                out_of_service_frac=0.0,
                atv_available_frac=0.99,
                machine_available_frac=0.97,
                commands=1,
                helps=0,
                energy_wh=118.0,
            )
            for at_s in (NOW_S - 660.0, NOW_S - 360.0)
        ),
    ),
    TASK_RECORD,
    EventAnswer(
        position=1042,
        agent="M1",
        incarnation=1,
        number=17,
        at_s=NOW_S - 1,
        plant_s=3599.0,
        kind="AwardAnswered",
        task="M1.1-1",
        goal=None,
        order=None,
        fact={
            "kind": "AwardAnswered",
            "task": "M1.1-1",
            "epoch": 1,
            "role": "primary",
            "bidder": "ATV2",
            "answer": "accepted",
        },
    ),
    AuditLine(
        position=311,
        at_s=NOW_S,
        who="operator-area1",
        who_kind="person",
        from_ip="192.0.2.7",
        session="1f0c5e2a9b7d",
        action="vehicle.command",
        target="ATV2",
        result="done",
        detail={"kind": "stop"},
    ),
    FactoryView(
        orders_open=1,
        orders_delivered=40,
        on_time_frac=0.975,
        starved_frac=0.02,
        transport_p50_s=84.0,
        transport_p95_s=162.0,
        empty_frac=0.46,
        use=UseView(moving=0.42, waiting=0.13, charging=0.15, blocked=0.01, idle=0.29, silent=0.0),
        atv_available_frac=0.99,
        machine_available_frac=0.97,
        commands=4,
        helps=1,
        deliveries_per_hour=(12.0, 24.0, 36.0),
        atvs_by_status={"idle": 3, "working": 4, "charging": 1},
        machines_by_status={"idle": 9, "producing": 3},
        plant_at_s=1_900_000_000.0,
    ),
)


@lru_cache(maxsize=1)
def examples() -> dict[str, Any]:
    """Name of a shape -> its example."""
    plant: dict[str, Any] = msgspec.to_builtins(default_plant().file)
    some = {name: value[:SHOWN] if isinstance(value, list) else value for name, value in plant.items()}
    return {type(one).__name__: msgspec.to_builtins(one) for one in _STRUCTS} | {"PlantFile": some}
