"""A REST client of a running gateway, for the command line."""

from __future__ import annotations

import http.client
from email.utils import parsedate_to_datetime
from http import HTTPStatus
from typing import NoReturn, TypeVar
from urllib.error import HTTPError, URLError
from urllib.parse import urlsplit
from urllib.request import ProxyHandler, Request, build_opener

import msgspec

from dray.cli.runtime.options import load_settings
from dray.errors import InputError, SettingsError, UnavailableError

T = TypeVar("T")

PATIENCE_S = 15.0
"""Timeout in seconds: longer than a gateway's own for its factory."""

REMEDY = "start one with `dray up`, or say with --url where it is"


class FieldError(msgspec.Struct, frozen=True):
    """A fault of one field of a request."""

    field: str
    reason: str


class ProblemAnswer(msgspec.Struct, frozen=True):
    """A gateway's refusal or error (RFC 9457)."""

    detail: str
    errors: tuple[FieldError, ...] = ()


class RestClient:
    """A client of one gateway.

    Args:
        url: its panel's address; None for the default of `dray up`.
        token: the caller's; None for the administrator's of the environment.
        otherwise: the advice for a refusal with another reason.

    Raises:
        SettingsError: the URL is invalid.
    """

    def __init__(self, url: str | None, token: str | None, otherwise: str) -> None:
        settings = load_settings(admin_token=token)
        self._token = "" if settings.admin_token is None else settings.admin_token.get_secret_value()
        self._url = (url or f"http://{settings.host}:{settings.port}").rstrip("/")
        self._otherwise = otherwise
        try:
            parts = urlsplit(self._url)
            usable = parts.scheme in {"http", "https"} and bool(parts.hostname) and parts.port != 0
        except ValueError:
            usable = False
        if not usable:
            raise SettingsError("--url", f"{self._url!r} is no address as http://127.0.0.1:8000")
        # No proxy: the gateway is on this machine or in this plant.
        self._opener = build_opener(ProxyHandler({}))

    def ask(self, method: str, path: str, shape: type[T], body: object = None) -> T:
        """Send one request.

        Raises:
            InputError: the gateway refuses it; contains the gateway's reason.
            UnavailableError: nobody answers there, or another server.
        """
        answer, _ = self._exchange(method, path, body)
        try:
            return msgspec.json.decode(answer, type=shape)
        except msgspec.MsgspecError as error:
            raise UnavailableError(self._url, f"does not answer as Dray does: {error}", REMEDY) from None

    def date_s(self) -> float | None:
        """The gateway's wall clock (unix time) in whole seconds, up to a second old; None without a date in its answers.

        Raises:
            UnavailableError: nobody answers there.
        """
        _, told = self._exchange("GET", "/healthz")
        try:
            return parsedate_to_datetime(told).timestamp()
        except ValueError:
            return None

    @property
    def url(self) -> str:
        """The gateway's address."""
        return self._url

    @property
    def has_token(self) -> bool:
        """Whether requests carry a token."""
        return bool(self._token)

    def _exchange(self, method: str, path: str, body: object = None) -> tuple[bytes, str]:
        """The body of an answer, and its date."""
        data = None if body is None else msgspec.json.encode(body)
        headers = {"Accept": "application/json"}
        if data is not None:
            headers["Content-Type"] = "application/json"
        if self._token:
            headers["Authorization"] = f"Bearer {self._token}"
        request = Request(self._url + path, data, headers, method=method)  # noqa: S310 - http or https, see above
        try:
            with self._opener.open(request, timeout=PATIENCE_S) as answer:
                return answer.read(), answer.headers.get("Date", "")
        except HTTPError as error:
            with error:
                self._refuse(error.code, error.read())
        except (URLError, OSError, http.client.HTTPException) as error:
            cause = getattr(error, "reason", error)
            reason = getattr(cause, "strerror", None) or str(cause)
            raise UnavailableError(f"no Dray at {self._url}", reason.lower(), REMEDY) from None

    def _refuse(self, status: int, body: bytes) -> NoReturn:
        try:
            problem = msgspec.json.decode(body, type=ProblemAnswer)
        except msgspec.MsgspecError:
            raise UnavailableError(
                self._url, f"answers with HTTP {status}, not as Dray does", REMEDY
            ) from None
        said = "; ".join(f"{each.field}: {each.reason}" for each in problem.errors) or problem.detail
        if status in {HTTPStatus.UNAUTHORIZED, HTTPStatus.FORBIDDEN}:
            raise SettingsError(
                "--token", f"{said}; `dray up` prints one that may, and DRAY_ADMIN_TOKEN sets it"
            )
        if status in {HTTPStatus.NOT_FOUND, HTTPStatus.UNPROCESSABLE_ENTITY}:
            raise InputError(said)
        raise UnavailableError(self._url, said, self._otherwise)
