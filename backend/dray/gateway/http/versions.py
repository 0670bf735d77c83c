"""Versions of what people change: nobody overwrites a state they have not read (RFC 9110, 13.1.1).

The `ETag` of an answer to GET has two parts, `"version/digest"`: the version needed for a change, and a
digest of the whole answer, by which `http.conditional` detects changes. `If-Match` takes the whole tag, or
the version alone, which is in bodies and in answers to changes.
"""

from __future__ import annotations

from http import HTTPStatus

from dray.gateway.http.problems import Problem


def version_tag(version: object) -> str:
    """The `ETag` of a version.

    Args:
        version: the version, without quotes and slashes.
    """
    return f'"{version}"'


def tag_with_digest(tag: str, digest: str) -> str:
    """The `ETag` of an answer with a version.

    Args:
        tag: the version's tag; empty if it has none.
        digest: digest of the body, in hexadecimal digits.
    """
    return f'{tag.removesuffix(chr(34))}/{digest}"' if tag else f'"{digest}"'


def tags_of(given: str) -> frozenset[str]:
    """The tags in `If-Match` or `If-None-Match`, compared weakly (13.1.2): `W/` is ignored."""
    return frozenset(tag.strip().removeprefix("W/") for tag in given.split(","))


def check_version(version: object, if_match: str | None, otherwise: Problem) -> None:
    """Refuse a change of a version that the caller has not read.

    Args:
        version: the present version; None if there is nothing yet.
        if_match: the request's header.
        otherwise: the problem for another version.

    Raises:
        Problem: `otherwise`; 428 without a version.
    """
    if if_match is None:
        raise no_version("send If-Match with the ETag with which you have read it")
    known = {version_tag(version), "*"}
    if version is None or not any(_version_of(tag) in known for tag in tags_of(if_match)):
        raise otherwise


def no_version(advice: str) -> Problem:
    """The problem of a change without a version."""
    return Problem(HTTPStatus.PRECONDITION_REQUIRED, "no-version", "It is not said what is changed", advice)


def changed_since(noun: str, name: str) -> Problem:
    """The problem of a change of something that somebody else has changed.

    Args:
        noun: the kind of thing, such as `order`.
        name: its id.
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
