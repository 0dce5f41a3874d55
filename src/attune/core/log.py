"""Structured logging: one JSON object per line, to a file or to standard error.

What people said goes only into the field `speech`, and only if asked: speech is personal data.
"""

import logging
import sys
from pathlib import Path
from typing import Any

import structlog
from structlog.typing import EventDict, WrappedLogger


def _without_speech(_logger: WrappedLogger, _method: str, event: EventDict) -> EventDict:
    event.pop("speech", None)
    return event


def configure_logging(*, level: str = "warning", file: Path | None = None, keep_speech: bool = False) -> None:
    """Set up logging for the process.

    Args:
        level: debug, info, warning or error.
        file: Where to append; None is standard error.
        keep_speech: Whether the field `speech` (transcripts) is written.
    """
    stream = file.open("a", encoding="utf-8") if file else sys.stderr
    privacy: list[Any] = [] if keep_speech else [_without_speech]
    structlog.configure(
        processors=[
            structlog.contextvars.merge_contextvars,
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso", utc=True),
            *privacy,
            structlog.processors.format_exc_info,
            structlog.processors.JSONRenderer(),
        ],
        wrapper_class=structlog.make_filtering_bound_logger(logging.getLevelNamesMapping()[level.upper()]),
        logger_factory=structlog.WriteLoggerFactory(file=stream),
        cache_logger_on_first_use=False,
    )


def get_logger(module: str) -> structlog.typing.FilteringBoundLogger:
    """The logger of a module; `log.info("what_happened", key=value)`. Unconfigured, only warnings are written."""
    if not structlog.is_configured():
        configure_logging()
    return structlog.get_logger(module=module)  # type: ignore[no-any-return]
