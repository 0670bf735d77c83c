"""Print the JSON Schema of everything that the panels receive, for `npm run types`.

Every field is marked as required: msgspec calls a field with a default optional because a reader may
meet it missing, but the gateway, who writes, always sends it.
"""

from __future__ import annotations

import json

import msgspec

from dray.gateway.factory.figures import KpiHistory
from dray.gateway.live.frames import Delta, Snapshot
from dray.gateway.orders.feasibility import OrderPreview
from dray.plant.model import PlantFile


def main() -> None:
    _, components = msgspec.json.schema_components(
        [Snapshot, Delta, PlantFile, KpiHistory, OrderPreview], ref_template="#/definitions/{name}"
    )
    for component in components.values():
        if "properties" in component:
            component["required"] = list(component["properties"])
            component["additionalProperties"] = False
    root = {"title": "Wire", "type": "object", "definitions": components}
    print(json.dumps(root, sort_keys=True))


if __name__ == "__main__":
    main()
