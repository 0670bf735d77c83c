"""Every error that Dray raises on purpose.

    DrayError
    ├── InputError            input from outside that we cannot use
    │   ├── PlantError        a plant file: names file, line, field and reason
    │   ├── WireError         bytes from the bus that are no message of ours
    │   │   ├── NewerVersion  a message of a wire version we do not know yet
    │   │   └── SealError     a message that its sender has not signed
    │   ├── SettingsError     an environment variable or command line option
    │   └── OrderError        an order or goal that no plant of ours can make
    ├── NoWay                 no lanes lead from one node of the plant to another
    ├── UnavailableError      something outside is not there: port in use, database not writable
    └── ProtocolViolation     our own bug: a state that the protocol excludes

A peer's fault (`WireError`) and our own (`ProtocolViolation`) are different things: the first is
counted and ignored, the second ends the agent. A late, doubled or stale message is neither: it is
normal, and ignored with a reason that is counted.

Errors carry typed fields and compose their own message: what was wrong, where, what to do.
"""

from __future__ import annotations

from collections.abc import Mapping


class DrayError(Exception):
    """The root: catch this to catch everything that Dray raises on purpose."""

    def __reduce__(self) -> tuple[object, ...]:
        # Unpickling an error from another process must not call its class: the arguments of `__init__` are in the message already.
        return _again, (type(self), self.args, self.__dict__)


def _again(kind: type[DrayError], args: tuple[object, ...], fields: Mapping[str, object]) -> DrayError:
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(fields)
    return error


class InputError(DrayError):
    """Input from outside that we cannot use."""


class PlantError(InputError):
    """A plant file that cannot be used.

    Attributes:
        file: the path as it was given.
        field: where in the file, as ``machines[3].node``; empty for the file as a whole.
        line: 1-based line in the file, or None where there is none.
        reason: what is wrong and what to do.
    """

    def __init__(self, file: str, field: str, reason: str, line: int | None = None) -> None:
        self.file, self.field, self.reason, self.line = file, field, reason, line
        place = f"{file}:{line}" if line is not None else file
        super().__init__(f"{place}: {field}: {reason}" if field else f"{place}: {reason}")


class PlantErrors(PlantError):
    """Several faults in one plant file, all of them named.

    Attributes:
        errors: the single faults, in file order; never empty.
    """

    def __init__(self, errors: tuple[PlantError, ...]) -> None:
        self.errors = errors
        first = errors[0]
        super().__init__(first.file, first.field, first.reason, first.line)
        self.args = ("\n".join(str(error) for error in errors),)


class WireError(InputError):
    """Bytes from the bus that are no message of ours.

    Attributes:
        reason: what did not fit.
        head: the first bytes, for the log.
    """

    HEAD_BYTES = 80
    """Enough to recognise a message by, little enough for a log line."""

    def __init__(self, reason: str, data: bytes) -> None:
        self.reason, self.head = reason, data[: self.HEAD_BYTES]
        super().__init__(f"not a message: {reason}; it begins {self.head!r}")


class NewerVersion(WireError):
    """A message of a wire version that we do not know yet: ignored and counted."""


class SealError(WireError):
    """A message without a signature of a known agent: ignored and counted."""


class SettingsError(InputError):
    """An environment variable or command line option that cannot be used."""

    def __init__(self, name: str, reason: str) -> None:
        self.name, self.reason = name, reason
        super().__init__(f"{name}: {reason}")


class OrderError(InputError):
    """An order that this plant cannot make."""

    def __init__(self, field: str, reason: str) -> None:
        self.field, self.reason = field, reason
        super().__init__(f"{field}: {reason}")


class NoWay(DrayError):
    """No lanes lead from one node of the plant to another, or one of them is no node of this plant.

    Attributes:
        start: the node where the way should begin.
        goal: where it should end.
    """

    def __init__(self, start: str, goal: str) -> None:
        self.start, self.goal = start, goal
        super().__init__(f"no way leads from {start} to {goal}")


class UnavailableError(DrayError):
    """Something outside is not there: a port in use, a database that cannot be written."""

    def __init__(self, what: str, reason: str, remedy: str) -> None:
        self.what, self.reason, self.remedy = what, reason, remedy
        super().__init__(f"{what}: {reason}; {remedy}")


class ProtocolViolation(DrayError):
    """Our own bug: a state that the protocol excludes."""
