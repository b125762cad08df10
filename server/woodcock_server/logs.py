"""Logs for people, on standard error: this service's through structlog, everyone else's through the same formatter."""

from __future__ import annotations

import logging
import logging.config
import sys

import structlog


def configure() -> None:
    shared: list[structlog.typing.Processor] = [
        structlog.stdlib.add_log_level,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
    ]
    structlog.configure(
        processors=[*shared, structlog.stdlib.ProcessorFormatter.wrap_for_formatter],
        logger_factory=structlog.stdlib.LoggerFactory(),
        cache_logger_on_first_use=True,
    )
    formatter = {
        "()": structlog.stdlib.ProcessorFormatter,
        "foreign_pre_chain": shared,
        "processors": [
            structlog.stdlib.ProcessorFormatter.remove_processors_meta,
            structlog.dev.ConsoleRenderer(
                colors=sys.stderr.isatty(), pad_event_to=28, exception_formatter=structlog.dev.plain_traceback
            ),
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
