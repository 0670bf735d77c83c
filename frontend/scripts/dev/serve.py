"""Serves the built panels with a pretended factory behind them, for work on the panels alone.

    .venv/bin/python frontend/scripts/dev/serve.py --speed 5

Together with `npm run dev`, which builds anew on every change. The content policy is the strict one
of the gateway, so that what would be refused there is refused here.
"""

from __future__ import annotations

import argparse
import asyncio
import datetime as dt
import json
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import msgspec
import uvicorn
import yaml
from crowd import crowd
from fastapi import FastAPI, Request, Response, WebSocket
from fastapi.staticfiles import StaticFiles
from jinja2 import Environment, FileSystemLoader
from pretend import Pretend

from dray.plant.model import PlantFile

ROOT = Path(__file__).resolve().parents[3]
STATIC = ROOT / "backend/dray/gateway/static"
POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; font-src 'self'; img-src 'self'; connect-src 'self'"
FRAMES_PER_S = 10


def manifest() -> dict[str, Any]:
    return json.loads((STATIC / ".vite/manifest.json").read_text())


def page() -> str:
    env = Environment(loader=FileSystemLoader(ROOT / "frontend/templates"), autoescape=True)
    env.globals["asset"] = lambda name: f"/static/{manifest()[name]['file']}"
    env.globals["styles"] = lambda name: [f"/static/{css}" for css in manifest()[name].get("css", [])]
    return env.get_template("manager.html").render()


def problem(status: int, title: str, errors: list[dict[str, str]] | None = None) -> Response:
    body = {"type": "about:blank", "title": title, "status": status, "detail": title, "errors": errors or []}
    return Response(json.dumps(body), status, media_type="application/problem+json")


def make_app(factory: Pretend) -> FastAPI:
    listeners: set[asyncio.Queue[bytes]] = set()
    state: dict[str, Any] = {"mute": False}

    async def run() -> None:
        while True:
            await asyncio.sleep(1 / FRAMES_PER_S)
            factory.run_until((time.time() - factory.began_at_s) * factory.speed)
            frame = msgspec.json.encode(factory.delta())
            for queue in listeners:
                if not state["mute"]:
                    queue.put_nowait(frame)

    @asynccontextmanager
    async def life(_: FastAPI) -> AsyncIterator[None]:
        running = asyncio.create_task(run())
        yield
        running.cancel()

    app = FastAPI(lifespan=life)

    @app.get("/")
    async def manager() -> Response:
        return Response(page(), media_type="text/html", headers={"Content-Security-Policy": POLICY})

    @app.get("/api/plant")
    async def plant() -> Response:
        return Response(msgspec.json.encode(factory.plant), media_type="application/json")

    @app.get("/dev/mute")
    async def mute(on: bool) -> dict[str, bool]:
        """Silence without a broken connection, to see how the panels age."""
        state["mute"] = on
        return {"mute": on}

    @app.websocket("/api/stream")
    async def stream(socket: WebSocket) -> None:
        await socket.accept()
        queue: asyncio.Queue[bytes] = asyncio.Queue()
        await socket.send_text(msgspec.json.encode(factory.snapshot()).decode())
        listeners.add(queue)
        try:
            while True:
                await socket.send_text((await queue.get()).decode())
        finally:
            listeners.discard(queue)

    add_orders(app, factory)
    app.mount("/static", StaticFiles(directory=STATIC), name="static")
    return app


def add_orders(app: FastAPI, factory: Pretend) -> None:
    @app.post("/api/orders")
    async def order(request: Request) -> Response:
        body = await request.json()
        item = body["items"][0]
        if item["quantity"] > 5000:
            return problem(
                422, "The order is not valid", [{"field": "items.0.quantity", "reason": "at most 5,000"}]
            )
        due = body.get("due_at")
        placed = factory.add_order(
            body["customer"], body.get("reference"), item["product"], item["quantity"],
            due=dt.datetime.fromisoformat(due).timestamp() if due else None,
            status="released" if body.get("release", True) else "stored",
        )  # fmt: skip
        return Response(msgspec.json.encode(placed), 201, media_type="application/json")

    @app.post("/api/orders/{order}/{verb}")
    async def change(order: str, verb: str) -> Response:
        if order not in factory.orders:
            return problem(404, "There is no such order")
        factory.orders[order].status = "released" if verb == "release" else "cancelled"
        factory.changed["order"].add(order)
        return Response(msgspec.json.encode(factory.orders[order]), media_type="application/json")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plant", type=Path, default=ROOT / "backend/dray/plant/default.yaml")
    parser.add_argument("--port", type=int, default=8100)
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--vehicles", type=int, default=0, help="a made-up plant for this many")
    parser.add_argument("--faults", action="store_true")
    given = parser.parse_args()
    plant = msgspec.convert(yaml.safe_load(given.plant.read_text()), PlantFile)
    if given.vehicles:
        plant = crowd(plant, given.vehicles)
    factory = Pretend(plant, given.speed, given.seed, faults=given.faults)
    factory.began_at_s -= 600 / given.speed
    factory.run_until(600)
    uvicorn.run(make_app(factory), host="127.0.0.1", port=given.port, log_level="warning")


if __name__ == "__main__":
    main()
