"""Logs: to stderr, as text for people or as JSON for programs."""

from __future__ import annotations

import logging
from datetime import UTC, datetime
from typing import Any

import msgspec

from dray.settings import Settings

FIELDS = ("agent", "fact", "task", "epoch", "role", "goal", "order", "reason")
"""Optional fields of a record beside its text, for searching a structured log."""

_encoder = msgspec.json.Encoder(enc_hook=str)


class JsonFormatter(logging.Formatter):
    """One JSON object in a line: `at` (ISO 8601, UTC), `level`, `logger`, `message`, and `FIELDS` if there are any."""

    def format(self, record: logging.LogRecord) -> str:
        """Write one record."""
        told: dict[str, Any] = {
            "at": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        told |= {name: getattr(record, name) for name in FIELDS if hasattr(record, name)}
        if record.exc_info:
            told["error"] = self.formatException(record.exc_info)
        return _encoder.encode(told).decode()


def prepare_logs(settings: Settings) -> None:
    """Log to stderr from now on, in the form of the settings."""
    handler = logging.StreamHandler()
    if settings.log_format == "json":
        handler.setFormatter(JsonFormatter())
    else:
        handler.setFormatter(logging.Formatter("%(levelname)s %(name)s: %(message)s"))
    logging.basicConfig(level=settings.log_level.upper(), handlers=(handler,))
    quieten(settings)


def quieten(settings: Settings) -> None:
    """Hide other packages' messages about their start."""
    if settings.log_level == "info":
        for name in ("alembic", "uvicorn.error"):
            logging.getLogger(name).setLevel(logging.WARNING)
