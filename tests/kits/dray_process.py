"""`dray up` in a process of its own, as people start it."""

from __future__ import annotations

import json
import os
import queue
import re
import select
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from http.cookiejar import CookieJar
from pathlib import Path
from typing import Any, TextIO

import pytest

READY_S = 180.0
"""Longest wait for the line that names the panel: a cold start on a slow machine takes some 5 s."""

STOP_S = 60.0
"""Longest wait for a clean stop: connections get 3 s, the simulation one instant."""


ANSWER_S = 60.0
"""Longest wait for one answer."""

KITS = Path(__file__).parent

STEPPED, STEPPED_SERVER = KITS / "stepped_up.py", KITS / "stepped_server.py"
"""`dray up` whose time passes only when it is told to; and who starts that without importing it anew."""

SESSION = "dray_session"
"""The cookie of a login."""


class _StayHere(urllib.request.HTTPRedirectHandler):
    """Asks for nothing more where an answer leads elsewhere."""

    def http_error_303(self, req: Any, fp: Any, code: int, msg: str, headers: Any) -> Any:
        return fp


class DrayProcess:
    """`dray up` in a process of its own.

    Args:
        python: runs it.
        options: of `dray up`.
        cwd: where it runs.
        stepped: whether its time stands until `advance`, `advance_until` or `going` let it pass.
        server: forks it where it is stepped; None to let it import everything itself.

    Attributes:
        url: where the panel is, without a slash at the end.
        token: the administrator's.
        links: per person without a secret, the address by which it logs in once.
        lines: what it has printed so far, stdout and stderr together.
    """

    def __init__(
        self,
        python: Path | str,
        *options: str,
        cwd: Path,
        stepped: bool = False,
        server: SteppedServer | None = None,
    ) -> None:
        self.process: subprocess.Popen[str] | Forked
        if stepped and server is not None:
            self.process = server.start(options, cwd)
        else:
            program = [str(STEPPED)] if stepped else ["-m", "dray", "up"]
            self.process = subprocess.Popen(
                [str(python), *program, *options],
                cwd=cwd,
                env=_environment(),
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
        self.lines: list[str] = []
        self._clock: _Clock | None = None
        self._sessions: dict[str, str] = {}
        self._arrived: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        try:
            greeting = self._await_greeting()
        except BaseException:
            self.process.kill()
            self.process.wait()
            self._close()
            raise
        if stepped:
            self._clock = _Clock(_found(r"^Clock (\S+)$", greeting))
        self.url = _found(r"Management panel\s+(\S+?)/?$", greeting)
        self.token = _found(r"Admin token\s+(\S+)$", greeting)
        self.links = dict(re.findall(r"^ +(\S+)\s+(http://\S+/login/\S+)$", greeting, re.MULTILINE))

    def ask(self, path: str, body: Any = None, **headers: str) -> Any:
        """Ask the API as the administrator: a GET, or a POST of a body."""
        data = None if body is None else json.dumps(body).encode()
        usual = {"Authorization": f"Bearer {self.token}", "Content-Type": "application/json"}
        request = urllib.request.Request(self.url + path, data, {**usual, **headers})
        with urllib.request.urlopen(request, timeout=ANSWER_S) as answer:
            return json.load(answer)

    def session(self, person: str = "manager") -> str:
        """The cookie of somebody who has logged in by the link that was printed, once for all who ask."""
        if person not in self._sessions:
            jar = CookieJar()
            opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(jar), _StayHere)
            opener.open(urllib.request.Request(self.links[person], b""), timeout=ANSWER_S).close()
            self._sessions[person] = next(cookie.value or "" for cookie in jar if cookie.name == SESSION)
        return self._sessions[person]

    @property
    def wall_s(self) -> float:
        """Its clock on the wall (stepped)."""
        return self.advance(0.0)

    def advance(self, span_s: float) -> float:
        """Let factory time pass (stepped), and return the clock on the wall then.

        What the gateway tells by REST is of then; panels are told within a tenth of a second.
        """
        assert self._clock is not None, "it was not started as stepped"
        return self._clock.say(advance_s=span_s)

    def advance_until(self, is_so: Callable[[], object], most_s: float = 3600.0, step_s: float = 2.0) -> None:
        """Let factory time pass (stepped) until it is so.

        Raises:
            AssertionError: it is not so after `most_s` factory seconds.
        """
        passed_s = 0.0
        while not is_so():
            assert passed_s < most_s, f"it is not so after {passed_s:g} s of the factory's time"
            self.advance(step_s)
            passed_s += step_s

    @contextmanager
    def going(self) -> Iterator[None]:
        """Let time pass (stepped) as it does at the factory's speed, meanwhile."""
        assert self._clock is not None, "it was not started as stepped"
        self._clock.say(goes=True)
        try:
            yield
        finally:
            self._clock.say(goes=False)

    def stop(self, by: signal.Signals = signal.SIGTERM) -> int:
        """Ask it to stop, as a terminal or a service manager does; its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(by)
        try:
            return self.process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            pytest.fail(f"dray up did not stop within {STOP_S} s:\n{self.output()}")
        finally:
            self._close()

    def kill(self) -> None:
        """End it as a power failure does."""
        self.process.kill()
        self.process.wait()
        self._close()

    def output(self) -> str:
        """Everything it has printed."""
        return "".join(self.lines)

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line)
            self._arrived.put(line)
        self._arrived.put(None)

    def _await_greeting(self) -> str:
        """All that it says until it answers."""
        ends_s = time.monotonic() + READY_S
        said = ""
        while "Ctrl-C" not in said:
            try:
                line = self._arrived.get(timeout=max(0.0, ends_s - time.monotonic()))
            except queue.Empty:
                pytest.fail(f"dray up was not ready within {READY_S} s:\n{self.output()}")
            if line is None:
                pytest.fail(f"dray up ended with {self.process.wait()}:\n{self.output()}")
            said += line
        return said

    def _close(self) -> None:
        if self._clock is not None:
            self._clock.close()
        self._reader.join(STOP_S)
        if self.process.stdout is not None:
            self.process.stdout.close()


class SteppedServer:
    """Starts `dray up` with a clock that stands as often as it is asked to, and imports it once (`stepped_server`)."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(STEPPED_SERVER)],
            env=_environment(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def start(self, options: Sequence[str], cwd: Path) -> Forked:
        """Start one in this folder."""
        reads, writes = os.pipe()
        try:
            pipe = f"/proc/{os.getpid()}/fd/{writes}"
            pid = self.ask(options=options, cwd=str(cwd), env=_environment(), output=pipe)
        except BaseException:
            os.close(reads)
            raise
        finally:
            os.close(writes)
        return Forked(self, pid, os.fdopen(reads, encoding="utf-8"))

    def ask(self, **asked: object) -> int:
        """Ask for something, and wait for the answer."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(asked) + "\n")
        self._process.stdin.flush()
        answer = self._process.stdout.readline()
        assert answer, f"the process that starts stepped factories has ended with {self._process.wait()}"
        return int(answer)

    @property
    def ended(self) -> bool:
        """Whether it starts nothing any more."""
        return self._process.poll() is not None

    def close(self) -> None:
        """End it; what it has started must have ended."""
        self._process.communicate()


class Forked:
    """What a `SteppedServer` has started, as `subprocess.Popen` has it.

    Attributes:
        pid: its number.
        stdout: what it says.
    """

    def __init__(self, server: SteppedServer, pid: int, stdout: TextIO) -> None:
        self.pid, self.stdout = pid, stdout
        self._server = server
        self._ends = os.pidfd_open(pid)
        self._code: int | None = None

    def poll(self) -> int | None:
        """Its exit code, once it has ended."""
        try:
            return self.wait(0.0)
        except subprocess.TimeoutExpired:
            return None

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended; its exit code."""
        if self._code is None:
            ends = select.poll()
            ends.register(self._ends, select.POLLIN)
            if not ends.poll(None if timeout is None else 1e3 * timeout):
                raise subprocess.TimeoutExpired("dray up", timeout or 0.0)
            self._code = self._server.ask(wait=self.pid)
            os.close(self._ends)
        return self._code

    def send_signal(self, by: signal.Signals) -> None:
        """Signal it, if it has not ended."""
        if self._code is None:
            signal.pidfd_send_signal(self._ends, by)

    def kill(self) -> None:
        """End it at once."""
        self.send_signal(signal.SIGKILL)


class _Clock:
    """Moves the clock of a stepped `dray up`."""

    def __init__(self, address: str) -> None:
        host, _, port = address.rpartition(":")
        self._socket = socket.create_connection((host, int(port)), ANSWER_S)
        # A plant of many vehicles may take its time for a long span.
        self._socket.settimeout(READY_S)
        self._lines = self._socket.makefile("rw", encoding="utf-8")

    def say(self, **asked: object) -> float:
        """Ask for something; the clock on the wall once it is done."""
        self._lines.write(json.dumps(asked) + "\n")
        self._lines.flush()
        answer = self._lines.readline()
        assert answer, "the factory has ended"
        return float(json.loads(answer)["wall_s"])

    def close(self) -> None:
        self._lines.close()
        self._socket.close()


def _environment() -> dict[str, str]:
    """Of every `dray up`."""
    inherited = {name: value for name, value in os.environ.items() if name != "DRAY_ADMIN_TOKEN"}
    return {**inherited, "PYTHONUNBUFFERED": "1", "COLUMNS": "200", "NO_COLOR": "1"}


def _found(pattern: str, text: str) -> str:
    found = re.search(pattern, text, re.MULTILINE)
    assert found is not None, text
    return found[1]
