"""Versions of what people change: nobody writes over what he has not read (RFC 9110, 13.1.1).

`ETag` of an answer to GET names two things, `"version/digest"`: the version that a change asks for, and a digest of all that the
answer tells, by which `http.conditional` sees whether anything has changed. `If-Match` takes it whole, or the version alone, which
is in the bodies and in the answers to changes.
"""

from __future__ import annotations

from http import HTTPStatus

from dray.gateway.http.problems import Problem


def version_tag(version: object) -> str:
    """The `ETag` of a version.

    Args:
        version: without quotes and slashes.
    """
    return f'"{version}"'


def tag_with_digest(tag: str, digest: str) -> str:
    """The `ETag` of an answer that tells a version.

    Args:
        tag: of the version; empty for an answer that has none.
        digest: of the body, in hexadecimal digits.
    """
    return f'{tag.removesuffix(chr(34))}/{digest}"' if tag else f'"{digest}"'


def tags_of(given: str) -> frozenset[str]:
    """The tags of a line of `If-Match` or `If-None-Match`, compared weakly (13.1.2): `W/` makes no difference."""
    return frozenset(tag.strip().removeprefix("W/") for tag in given.split(","))


def check_version(version: object, if_match: str | None, otherwise: Problem) -> None:
    """Refuse a change of a version that the caller has not read.

    Args:
        version: what it has now; None where there is nothing yet.
        if_match: the header of the call.
        otherwise: refuses another version.

    Raises:
        Problem: `otherwise`; 428 for none.
    """
    if if_match is None:
        raise no_version("send If-Match with the ETag with which you have read it")
    known = {version_tag(version), "*"}
    if version is None or not any(_version_of(tag) in known for tag in tags_of(if_match)):
        raise otherwise


def no_version(advice: str) -> Problem:
    """Refuses a change that names no version."""
    return Problem(HTTPStatus.PRECONDITION_REQUIRED, "no-version", "It is not said what is changed", advice)


def changed_since(noun: str, name: str) -> Problem:
    """Refuses a change of what somebody else has changed.

    Args:
        noun: what it is, as `order`.
        name: which.
    """
    return Problem(
        HTTPStatus.PRECONDITION_FAILED,
        "changed-since",
        f"The {noun} is not as you have read it",
        f"read {name} again, and send If-Match with its ETag",
    )


def _version_of(tag: str) -> str:
    version, slash, _ = tag.partition("/")
    return f'{version}"' if slash else tag
