"""Messages to JSON and back: the one conversion that every edge uses."""

from typing import Any, TypeVar, cast

from pydantic import TypeAdapter, ValidationError

from attune.core.errors import AttuneError

T = TypeVar("T")

_adapters: dict[Any, TypeAdapter[Any]] = {}


class MessageFormatError(AttuneError):
    """Data from outside does not fit the message type it should have."""

    def __init__(self, kind: str, errors: list[str]) -> None:
        super().__init__(f"this is no valid {kind}: {'; '.join(errors)}", "Correct the named fields")


def _adapter(type_: Any) -> TypeAdapter[Any]:
    if type_ not in _adapters:
        _adapters[type_] = TypeAdapter(type_)
    return _adapters[type_]


def describe(error: ValidationError) -> list[str]:
    """One line per error of a pydantic validation: field, what is wrong, and the value."""
    return [
        f"{'.'.join(str(part) for part in item['loc']) or 'value'}: {item['msg']} (got {item['input']!r:.80})"
        for item in error.errors()
    ]


def to_data(message: object) -> Any:
    """A message as plain dicts and lists that JSON can hold."""
    return _adapter(type(message)).dump_python(message, mode="json")


def to_json(message: object) -> str:
    """A message as one line of JSON."""
    return _adapter(type(message)).dump_json(message).decode()


def from_data(type_: type[T] | Any, data: object) -> T:
    """A message of `type_` (a message class, or the union `Command`) from plain data.

    Raises:
        MessageFormatError: The data does not fit; the message names each field.
    """
    try:
        return cast("T", _adapter(type_).validate_python(data))
    except ValidationError as error:
        raise MessageFormatError(getattr(type_, "__name__", "command"), describe(error)) from None


def from_json(type_: type[T] | Any, text: str | bytes) -> T:
    """A message of `type_` from JSON.

    Raises:
        MessageFormatError: The text is not JSON, or does not fit.
    """
    try:
        return cast("T", _adapter(type_).validate_json(text))
    except ValidationError as error:
        raise MessageFormatError(getattr(type_, "__name__", "command"), describe(error)) from None
