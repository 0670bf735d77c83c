"""The OpenAPI document: what FastAPI knows of the routers (`document`), with examples that fit together (`examples`)."""
