"""A fleet whose bodies are as in a plant: machines behind OPC UA, vehicles behind a broker, and people at the gate, who say over REST what has come."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
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


@dataclass
class Word:
    """What a person at the gate says of the pieces of one goal, until it was answered often enough.

    Attributes:
        told: the request. It bears a name, so the gate counts it once however often it comes.
        to_answer: how often it is still to be answered.
        counted: whether an answer has said that it counts.
    """

    told: dict[str, Any]
    to_answer: int
    counted: bool = False


class Gatekeeper:
    """A person at the gate: sees what lies there, and says it to the gate as the tablet does.

    A word has a name of its own, and is said again under it until it is answered. Every other word, and the first, is said until
    it was answered twice. The gate refuses pieces that it no longer admits: those of a goal that was given to another machine
    while they were on their way. They are surplus, and the goal's new machine makes them once more.

    Args:
        fleet: whose gate.

    Attributes:
        said: pieces by goal, by answered words.
        surplus: pieces by goal that the gate has refused.
        again: answers to words that had been answered before.
        unanswered: why the last word that was not answered was not; empty for none.
    """

    def __init__(self, fleet: Fleet) -> None:
        self._fleet = fleet
        self.said: Counter[str] = Counter()
        self.surplus: Counter[str] = Counter()
        self._words = self.again = 0
        self.unanswered = ""
        self._open: dict[str, Word] = {}
        """By goal, the word that is not answered yet."""

    def has_said(self, lies_there: Mapping[str, int]) -> bool:
        """Whether the gate has answered for every piece that lies there."""
        return not self._open and +Counter(lies_there) == self.said + self.surplus

    def look(self, lies_there: Mapping[str, int]) -> None:
        """Say what has come; what is not answered is said again when this is called next."""
        for goal, pieces in lies_there.items():
            new = pieces - self.said[goal] - self.surplus[goal]
            if goal not in self._open and new > 0:
                self._words += 1
                told = {
                    "kind": "arrived",
                    "item": goal,
                    "quantity": new,
                    "command": f"gatekeeper-{self._words}",
                    "sure": True,
                }
                self._open[goal] = Word(told, 1 + self._words % 2)
        for goal, word in tuple(self._open.items()):
            while word.to_answer and (answer := self._say(word.told)) is not None:
                self._take(goal, word, answer)
            if not word.to_answer:
                del self._open[goal]

    def _take(self, goal: str, word: Word, answer: dict[str, Any]) -> None:
        word.to_answer -= 1
        if not answer["done"]:
            assert answer["reason"] == "not_admitted", (word, answer)
            assert not word.counted, f"a word that had counted is refused: {word}, {answer}"
            # The detail is the number that is admitted; the rest is said with another word.
            self.surplus[goal] += word.told["quantity"] - int(answer["detail"] or 0)
            word.to_answer = 0
        elif word.counted:
            self.again += 1
        else:
            word.counted = True
            self.said[goal] += word.told["quantity"]

    def _say(self, told: dict[str, Any]) -> dict[str, Any] | None:
        """Say it, and wait for the answer; None when none has come, and the gate may have heard it or not."""
        try:
            with self._fleet.gateway() as client:
                answer = client.post(f"/api/stations/{GATE}/commands", json=told)
        except httpx.TransportError as error:
            self.unanswered = repr(error)
            return None
        if answer.status_code in (502, 503, 504):
            self.unanswered = answer.text
            return None
        assert answer.status_code == 200, answer.text
        taken: dict[str, Any] = answer.json()
        return taken


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
