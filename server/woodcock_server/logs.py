"""Logs on standard error, for people or as JSON: this service's through structlog, others through its formatter."""

from __future__ import annotations

import logging
import logging.config
import sys
from typing import Literal

import structlog


def configure(format: Literal["console", "json"]) -> None:
    """console: for people; json: an object a line."""
    shared: list[structlog.typing.Processor] = [
        structlog.contextvars.merge_contextvars,  # the job that is rendered
        structlog.stdlib.add_log_level,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
    ]
    structlog.configure(
        processors=[*shared, structlog.stdlib.ProcessorFormatter.wrap_for_formatter],
        logger_factory=structlog.stdlib.LoggerFactory(),
        cache_logger_on_first_use=True,
    )
    renderers: list[structlog.typing.Processor] = [
        structlog.processors.format_exc_info,
        structlog.processors.JSONRenderer(),
    ]
    if format == "console":
        renderers = [
            structlog.dev.ConsoleRenderer(
                colors=sys.stderr.isatty(), pad_event_to=28, exception_formatter=structlog.dev.plain_traceback
            )
        ]
    formatter = {
        "()": structlog.stdlib.ProcessorFormatter,
        "foreign_pre_chain": shared,
        "processors": [
            structlog.stdlib.ProcessorFormatter.remove_processors_meta,
            *renderers,
        ],
    }
    logging.config.dictConfig(
        {
            "version": 1,
            "disable_existing_loggers": False,
            "formatters": {"console": formatter},
            "handlers": {"console": {"class": "logging.StreamHandler", "formatter": "console"}},
            "root": {"handlers": ["console"], "level": "INFO"},
            "loggers": {
                # Libraries that tell their own story at INFO, or bring handlers of their own.
                name: {"level": "WARNING", "handlers": [], "propagate": True}
                for name in ("alembic", "distributed", "distributed.client", "tornado", "uvicorn.error")
            },
        }
    )
