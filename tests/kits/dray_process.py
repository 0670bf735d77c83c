"""`dray up` in a process of its own, as people start it."""

from __future__ import annotations

import json
import os
import queue
import re
import signal
import subprocess
import threading
import time
import urllib.request
from http.cookiejar import CookieJar
from pathlib import Path
from typing import Any

import pytest

READY_S = 180.0
"""Longest wait for the line that names the panel: a cold start on a slow machine takes some 5 s."""

STOP_S = 60.0
"""Longest wait for a clean stop: connections get 3 s, the simulation one instant."""


ANSWER_S = 60.0
"""Longest wait for one answer."""

SESSION = "dray_session"
"""The cookie of a login."""


class _StayHere(urllib.request.HTTPRedirectHandler):
    """Asks for nothing more where an answer leads elsewhere."""

    def http_error_303(self, req: Any, fp: Any, code: int, msg: str, headers: Any) -> Any:
        return fp


class DrayProcess:
    """`dray up` in a process of its own.

    Attributes:
        url: where the panel is, without a slash at the end.
        token: the administrator's.
        links: per person without a secret, the address by which it logs in once.
        lines: what it has printed so far, stdout and stderr together.
    """

    def __init__(self, python: Path | str, *options: str, cwd: Path) -> None:
        command = [str(python), "-m", "dray", "up", *options]
        inherited = {name: value for name, value in os.environ.items() if name != "DRAY_ADMIN_TOKEN"}
        env = {**inherited, "PYTHONUNBUFFERED": "1", "COLUMNS": "200", "NO_COLOR": "1"}
        self.process = subprocess.Popen(
            command, cwd=cwd, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self.lines: list[str] = []
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
        self._reader.join(STOP_S)
        if self.process.stdout is not None:
            self.process.stdout.close()


def _found(pattern: str, text: str) -> str:
    found = re.search(pattern, text, re.MULTILINE)
    assert found is not None, text
    return found[1]
