"""Print the gateway's OpenAPI document, for `npm run types`: no gateway has to run for it."""

from __future__ import annotations

import json

from fastapi import FastAPI

from dray.gateway.routes.openapi import document
from dray.gateway.routes.table import add_routes


def main() -> None:
    app = FastAPI()
    add_routes(app)
    document.install(app)
    print(json.dumps(app.openapi()))


if __name__ == "__main__":
    main()
