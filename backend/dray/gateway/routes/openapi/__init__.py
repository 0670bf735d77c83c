"""The OpenAPI document: FastAPI's description of the routers (`document`), with `examples`."""
