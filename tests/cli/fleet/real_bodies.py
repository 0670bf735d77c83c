"""A fleet whose bodies are as in a plant: machines behind OPC UA, vehicles behind a broker, and people at the gate, who say over REST what has come."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import httpx
from fleets import START_S, Fleet

from dray.messages.keys import GATE

BROKER = """
import signal, sys
from iotcore import Broker
broker = Broker(port=int(sys.argv[1]), listen="127.0.0.1", max_payload_size=2**20).start()
print("ready", flush=True)
signal.pause()
"""


class BrokerProcess:
    """An MQTT broker that is ended and started again at one address.

    Attributes:
        url: its address.
    """

    def __init__(self) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self._port = str(probe.getsockname()[1])
        self.url = f"mqtt://127.0.0.1:{self._port}"
        self.start()

    def start(self) -> None:
        """It is ready at the return."""
        self._process = subprocess.Popen(
            [sys.executable, "-c", BROKER, self._port],
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        assert self._process.stdout is not None
        with self._process.stdout as told:
            assert told.readline() == "ready\n"

    def kill(self) -> None:
        """All connections break, without a word."""
        # The broker is a child of that process.
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait(START_S)


class Gatekeeper:
    """A person at the gate: sees what lies there, and says it to the gate as the tablet does.

    A word has a name of its own, and is said again under it until it is answered; half of all words are said once more after that.

    Args:
        fleet: whose gate.
    """

    def __init__(self, fleet: Fleet) -> None:
        self._fleet = fleet
        self.said: dict[str, int] = {}
        """Pieces by goal, by answered words."""
        self._words = self.again = 0
        self._open: dict[str, dict[str, Any]] = {}
        """By goal, the word that is not answered yet."""

    def look(self, lies_there: dict[str, int]) -> None:
        """Say what has come; what is not answered is said again when this is called next."""
        for goal, pieces in lies_there.items():
            word = self._open.get(goal)
            if word is None and pieces > self.said.get(goal, 0):
                self._words += 1
                quantity = pieces - self.said.get(goal, 0)
                word = {
                    "kind": "arrived",
                    "item": goal,
                    "quantity": quantity,
                    "command": f"gatekeeper-{self._words}",
                    "sure": True,
                }
                self._open[goal] = word
            if word is not None and self._say(word):
                del self._open[goal]
                self.said[goal] = self.said.get(goal, 0) + word["quantity"]
                if self._words % 2:
                    self.again += self._say(word)

    def _say(self, word: dict[str, Any]) -> bool:
        """Whether it was answered that it counts."""
        try:
            with self._fleet.gateway() as client:
                answer = client.post(f"/api/stations/{GATE}/commands", json=word)
        except httpx.TransportError:
            return False
        if answer.status_code in (502, 503, 504):
            return False
        assert answer.status_code == 200, answer.text
        told = answer.json()
        assert told["done"], told
        return True


NOTES = """
import os, sys
class Notes:
    @staticmethod
    def find_spec(name, path=None, target=None):
        if name.partition(".")[0] == "dray_sim":
            file = os.open({file!r}, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
            os.write(file, " ".join([*sys.orig_argv, "\\n"]).encode())
            os.close(file)
        return None
sys.meta_path.insert(0, Notes)
"""


class Imports:
    """Which processes look for a module of the simulator, from now on and in all of their lives: Python notes it as it does so.

    Args:
        folder: for the notes.

    Attributes:
        path: what is to stand first in the `PYTHONPATH` of the processes.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / "notes"
        self.path.mkdir()
        self._file = self.path / "imports.txt"
        (self.path / "sitecustomize.py").write_text(NOTES.format(file=str(self._file)))

    def processes(self) -> set[str]:
        """What `dray` was told to run, of each process that has looked for one: `floor`, `agent atv`."""
        lines = self._file.read_text().splitlines() if self._file.exists() else []
        told = (line.partition(" -m dray ")[2].split() for line in lines)
        return {" ".join(words[:2] if words[0] == "agent" else words[:1]) for words in told}
