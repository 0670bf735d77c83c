"""Small layouts as other systems write them."""

from __future__ import annotations

from typing import Any

import msgspec

Json = dict[str, Any]


def node(name: object, x: object, y: object, *, actions: tuple[str, ...] = (), **more: object) -> Json:
    properties: Json = {"vehicleTypeId": "kind"}
    if actions:
        properties["actions"] = [{"actionType": each, "blockingType": "HARD"} for each in actions]
    return {
        "nodeId": name,
        "mapId": "map",
        "nodePosition": {"x": x, "y": y},
        "vehicleTypeNodeProperties": [properties],
        **more,
    }


def edge(start: str, end: str, *, kind: object = "kind", **properties: object) -> Json:
    return {
        "edgeId": f"{start}-{end}",
        "startNodeId": start,
        "endNodeId": end,
        "vehicleTypeEdgeProperties": [{"vehicleTypeId": kind, "maxSpeed": 1.0, **properties}],
    }


def station(name: str, *nodes: str, **more: object) -> Json:
    return {"stationId": name, "interactionNodeIds": list(nodes), **more}


def layout(nodes: list[Json], edges: list[Json], stations: list[Json] | None = None, **more: object) -> Json:
    return {
        "layoutId": "L",
        "layoutVersion": "1",
        "nodes": nodes,
        "edges": edges,
        "stations": stations or [],
        **more,
    }


def lif(*layouts: Json, **more: object) -> bytes:
    meta = {
        "projectIdentification": "Hall",
        "creator": "test",
        "exportTimestamp": "2026-01-01T00:00:00Z",
        "lifVersion": "1.0.0",
    }
    return msgspec.json.encode({"metaInformation": meta, "layouts": list(layouts), **more})


MODEL = """\
<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<model version="7.0.0" name="Hall">
  <point name="Point 1" positionX="-1000" positionY="0" positionZ="0" vehicleOrientationAngle="NaN" type="HALT_POSITION">
    <outgoingPath name="Point 1 --- Point 2"/>
  </point>
  <point name="Point 2" positionX="9000" positionY="0" positionZ="0" vehicleOrientationAngle="NaN" type="HALT_POSITION"/>
  <point name="Point 3" positionX="9000" positionY="10000" positionZ="0" vehicleOrientationAngle="NaN" type="PARK_POSITION"/>
  <path name="Point 1 --- Point 2" sourcePoint="Point 1" destinationPoint="Point 2" length="10000" maxVelocity="1000"
        maxReverseVelocity="{reverse}" locked="false">
    <pathLayout connectionType="DIRECT" layerId="0"/>
  </path>
  <path name="Point 2 --- Point 3" sourcePoint="Point 2" destinationPoint="Point 3" length="10000" maxVelocity="500"
        maxReverseVelocity="0" locked="{locked}">
    <pathLayout connectionType="{drawn}" layerId="0">{points}</pathLayout>
  </path>
  <vehicle name="Truck 1" energyLevelCritical="20" energyLevelGood="70" energyLevelFullyRecharged="95"
           energyLevelSufficientlyRecharged="60" maxVelocity="1200" maxReverseVelocity="500" envelopeKey="e">
    <boundingBox length="1500" width="800" height="1000" referenceOffsetX="0" referenceOffsetY="0"/>
    <property name="loopback:initialPosition" value="Point 3"/>
  </vehicle>
  <locationType name="Charging"><allowedOperation name="CHARGE"/></locationType>
  <locationType name="Transfer"><allowedOperation name="Load"/></locationType>
  <location name="Outlet" positionX="-1000" positionY="2000" positionZ="0" locked="false" type="Charging">
    <link point="Point 1"/>
  </location>
  <location name="Rack --- A" positionX="9000" positionY="-2000" positionZ="0" locked="false" type="Transfer">
    <link point="Point 2"/><link point="Point 3"/>
  </location>
  <location name="Alone" positionX="0" positionY="0" positionZ="0" locked="false" type="Transfer"/>
  <block name="Block" type="SINGLE_VEHICLE_ONLY"><member name="Point 1"/></block>
  <visualLayout name="VLayout" scaleX="50.0" scaleY="50.0"/>
</model>
"""


def model(*, reverse: str = "0", locked: str = "false", drawn: str = "DIRECT", points: str = "") -> bytes:
    return MODEL.format(reverse=reverse, locked=locked, drawn=drawn, points=points).encode()
