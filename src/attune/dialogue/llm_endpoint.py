"""One request to an OpenAI-compatible endpoint: streamed, repeated where that helps, never longer than its deadline."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import anyio

from attune.core.clock import Clock
from attune.core.config import LlmConfig
from attune.core.errors import AttuneError, MissingDependencyError
from attune.dialogue.llm_answer import InvalidAnswerError, ModelAnswer, is_truncated, parse_answer, parse_decision

if TYPE_CHECKING:
    import openai

MOST_TRIES = 3
PAUSE = 0.2
"""Before a request is repeated after an error of the server [s]; doubled each time."""

Role = Literal["system", "user", "assistant"]
Message = Mapping[Literal["role", "content"], str]


class NoAnswerError(AttuneError):
    """The endpoint gave no usable answer. The message is for logs; the person hears the embedded interpreter."""

    def __init__(self, why: str) -> None:
        super().__init__(f"the language model gave no answer: {why}", "See `attune doctor`")


class NoEndpointError(AttuneError):
    """No language model is configured."""

    def __init__(self) -> None:
        super().__init__(
            "no language model is configured",
            "Give llm.base_url and llm.model in attune.toml, or ATTUNE_LLM__BASE_URL and ATTUNE_LLM__MODEL",
        )


class Endpoint:
    """A language model behind OpenAI's protocol.

    Times are real: under a virtual clock a deadline would pass before the network can answer.

    Args:
        config: Where it is, and how long it may take.
        clock: For the pauses between tries.

    Raises:
        NoEndpointError: The configuration names no base URL or no model.
        MissingDependencyError: The `openai` package is not installed.
    """

    def __init__(self, config: LlmConfig, clock: Clock) -> None:
        if not (config.base_url and config.model):
            raise NoEndpointError
        try:
            import openai
        except ImportError:
            raise MissingDependencyError(
                "the openai package", "the language model", "pip install 'attune-hri[llm]'"
            ) from None
        self.name = config.model
        self._config = config
        self._clock = clock
        # An explicit key, so that one for another service in the environment is never sent here.
        key = config.api_key.get_secret_value() or "none"
        self._client = openai.AsyncOpenAI(base_url=config.base_url, api_key=key, max_retries=0, timeout=config.deadline)
        self._options: dict[str, Any] = {
            "response_format": "json_schema",
            "temperature": config.temperature,
            "max_tokens": config.max_tokens,
        }

    async def close(self) -> None:
        """Close the connections."""
        await self._client.close()

    async def ask(self, messages: Sequence[Message], schema: Mapping[str, Any]) -> ModelAnswer:
        """Ask for an answer that keeps to a JSON schema.

        If the deadline comes while only the reply is still being written, the decision counts, without a reply.

        Raises:
            NoAnswerError: There is no valid answer within the deadline.
        """
        received: list[str] = []
        with anyio.move_on_after(self._config.deadline):
            return await self._try(messages, schema, received)
        decision = parse_decision("".join(received))
        if decision is None:
            raise NoAnswerError(f"nothing within {self._config.deadline:g} s")
        return decision

    async def _try(self, messages: Sequence[Message], schema: Mapping[str, Any], received: list[str]) -> ModelAnswer:
        import openai

        started = self._clock.now()
        truncated = False
        for attempt in range(MOST_TRIES):
            received.clear()
            try:
                await self._stream(messages, schema, received.append)
                return parse_answer("".join(received))
            except InvalidAnswerError as error:
                if decision := parse_decision("".join(received)):
                    return decision
                if truncated or not is_truncated("".join(received)):
                    raise NoAnswerError(error.problem) from None
                truncated = True
                continue
            except openai.RateLimitError as error:
                pause = _retry_after(error)
                why = "too many requests"
            except openai.InternalServerError as error:
                pause = PAUSE * 2**attempt
                why = f"error {error.status_code} of the server"
            except openai.BadRequestError as error:
                if not self._drop_refused(str(error)):
                    raise NoAnswerError(_explain(error)) from None
                continue
            except openai.OpenAIError as error:
                raise NoAnswerError(_explain(error)) from None
            left = self._config.deadline - (self._clock.now() - started)
            if pause is None or pause >= left or attempt == MOST_TRIES - 1:
                raise NoAnswerError(why)
            await self._clock.sleep(pause)
        raise NoAnswerError("its answers are cut off or its options refused")

    def _drop_refused(self, complaint: str) -> bool:
        """Leave out the option that the endpoint complains about: not every model takes every option."""
        refused = next((name for name in self._options if name in complaint), "")
        value = self._options.pop(refused, None)
        if refused == "max_tokens":
            self._options["max_completion_tokens"] = value
        return bool(refused)

    async def _stream(
        self, messages: Sequence[Message], schema: Mapping[str, Any], receive: Callable[[str], None]
    ) -> None:
        options = dict(self._options)
        if "response_format" in options:
            asked = {"name": "answer", "strict": True, "schema": schema}
            options["response_format"] = {"type": "json_schema", "json_schema": asked}
        create: Any = self._client.chat.completions.create
        stream = await create(model=self.name, messages=list(messages), stream=True, **options)
        async with stream:
            async for chunk in stream:
                if chunk.choices and chunk.choices[0].delta.content:
                    receive(chunk.choices[0].delta.content)


def _retry_after(error: "openai.APIStatusError") -> float | None:
    try:
        return max(0.0, float(error.response.headers["retry-after"]))
    except (KeyError, ValueError):
        return None


def _explain(error: "openai.OpenAIError") -> str:
    import openai

    if isinstance(error, openai.APITimeoutError):
        return "it took too long"
    if isinstance(error, openai.APIConnectionError):
        return "it cannot be reached"
    if isinstance(error, openai.AuthenticationError | openai.PermissionDeniedError):
        return f"it refuses the key (status {error.status_code}); the key is ATTUNE_LLM__API_KEY in the environment"
    if isinstance(error, openai.NotFoundError):
        return "the address or the model does not exist there (status 404)"
    if isinstance(error, openai.APIStatusError):
        return f"it refuses the request (status {error.status_code})"
    return f"{type(error).__name__}"
