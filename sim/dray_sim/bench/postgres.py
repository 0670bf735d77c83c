"""A PostgreSQL server of one's own, on a free port of 127.0.0.1, from the binaries that are installed.

The benchmark and the tests that kill a database use it, and benchmarks that compare PostgreSQL with SQLite.
"""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path

from dray.adapters.addresses import free_addresses
from dray.adapters.processes import PROC, Process
from dray.errors import UnavailableError

MISSING = "no PostgreSQL; on Debian: apt-get install postgresql"

USERS = ("postgres", "nobody")
"""Users to run the server as when we run as root, which PostgreSQL refuses; the first that exists is taken."""

STARTS = 3
"""Attempts to start the server: somebody else may take the free port before it does."""

PARENT = 1
"""Index of the parent's id in `/proc/PID/stat`, counted after the name of the program (proc(5), field 4)."""


def installed() -> Path | None:
    """The folder of the newest PostgreSQL's programs, if there is one: Debian keeps it out of the PATH."""
    debian = sorted(
        Path("/usr/lib/postgresql").glob("*/bin/pg_ctl"), key=lambda path: float(path.parts[-3]), reverse=True
    )
    found = debian[0] if debian else shutil.which("pg_ctl")
    return None if found is None else Path(found).resolve().parent


class PostgresServer:
    """A server with a folder of its own; both go when it is closed, or with our process.

    Args:
        programs: where `installed` has found them.
        configuration: settings that differ from PostgreSQL's defaults, by name.

    Attributes:
        port: the same for all of its lives.

    Raises:
        UnavailableError: it does not start.
    """

    def __init__(self, programs: Path, configuration: Mapping[str, str] | None = None) -> None:
        self._programs = programs
        self._configuration = {
            "listen_addresses": "127.0.0.1",
            "unix_socket_directories": "",
            **(configuration or {}),
        }
        self._user = _server_user()
        self._home = Path(tempfile.mkdtemp(prefix="dray-postgres-"))
        self._data = self._home / "data"
        self.port = 0
        if self._user is not None:
            os.chown(self._home, self._user.pw_uid, self._user.pw_gid)
        self._guard = self._keep_guard()
        try:
            self._run("initdb", "-U", "dray", "-A", "trust", "-E", "UTF8", "--no-locale", "-N")
            self.start()
        except BaseException:
            self.close()
            raise

    def url(self, database: str = "postgres") -> str:
        """The URL of one of its databases; the default one exists from the beginning."""
        return f"postgresql+asyncpg://dray@127.0.0.1:{self.port}/{database}"

    def start(self) -> None:
        """Start the server, on the port that it had before if it had one; returns when it answers.

        Raises:
            UnavailableError: it does not start.
        """
        options = " ".join(f"-c {name}='{value}'" for name, value in self._configuration.items())
        log = self._home / "log"
        for _ in range(STARTS):
            port = self.port or int(free_addresses(1)[0].rpartition(":")[2])
            started = self._run(
                "pg_ctl", "start", "-w", "-l", str(log), "-o", f"-p {port} {options}", check=False
            )
            if started.returncode == 0:
                self.port = port
                return
        raise UnavailableError("PostgreSQL", "does not start", f"it has said:\n{log.read_text()}")

    def create(self, database: str) -> None:
        """Make a database."""
        self._run("createdb", "-h", "127.0.0.1", "-p", str(self.port), "-U", "dray", database)

    def stop(self) -> None:
        """Stop the server as a restart of it does: all connections end."""
        self._run("pg_ctl", "stop", "-w", "-m", "fast")

    async def kill(self) -> None:
        """End all of its processes at once, as a power failure does; returns when they are gone."""
        lock = self._data / "postmaster.pid"
        first = Process.of(int(lock.read_text().split()[0]))
        # Stop it, so that it starts no child while its children are listed.
        first.signal(signal.SIGSTOP)
        processes = (first, *map(Process.of, _children(first.pid)))
        for process in processes:
            process.signal(signal.SIGKILL)
        for process in processes:
            await process.gone()
        # After a power failure, no process has its id. Here the id stays taken until its parent has read its exit
        # status.
        lock.unlink()

    def dump(self, file: Path) -> None:
        """Copy the database that is there from the beginning into a file, for `pg_restore`."""
        address = ("-h", "127.0.0.1", "-p", str(self.port), "-U", "dray")
        dumped = ("--format=custom", f"--file={file}", "postgres")
        subprocess.run(  # noqa: S603 (no shell, and no word of a stranger's)
            [str(self._programs / "pg_dump"), *address, *dumped], check=True
        )

    def close(self) -> None:
        """Stop the server and remove all that it has kept."""
        self._guard.communicate()

    def _keep_guard(self) -> subprocess.Popen[bytes]:
        """A process that cleans up when this one has ended in any way: then the pipe between them closes."""
        script = 'cat; "$0" stop --mode=immediate --pgdata="$1/data"; rm -r "$1"'
        return subprocess.Popen(  # noqa: S603 (no shell expands what is ours alone)
            ["/bin/sh", "-c", script, str(self._programs / "pg_ctl"), str(self._home)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            user=None if self._user is None else self._user.pw_uid,
            group=None if self._user is None else self._user.pw_gid,
            extra_groups=None if self._user is None else [],
            # The terminal must not end it together with us.
            start_new_session=True,
        )

    def _run(self, program: str, *args: str, check: bool = True) -> subprocess.CompletedProcess[str]:
        user = self._user
        return subprocess.run(  # noqa: S603 (no shell, and no word of a stranger's)
            [str(self._programs / program), *args],
            env={**os.environ, "PGDATA": str(self._data)},
            cwd=self._home,
            user=None if user is None else user.pw_uid,
            group=None if user is None else user.pw_gid,
            extra_groups=None if user is None else [],
            check=check,
            text=True,
            stdin=subprocess.DEVNULL,
            # Not a pipe: the server inherits it, and would keep it open.
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )


@contextmanager
def databases() -> Iterator[Mapping[str, str]]:
    """New databases by the name of their kind, as URLs: SQLite's, and PostgreSQL's where it is installed."""
    with tempfile.TemporaryDirectory() as folder:
        found = {"SQLite": f"sqlite+aiosqlite:///{Path(folder) / 'bench.db'}"}
        programs = installed()
        if programs is None:
            yield found
            return
        with closing(PostgresServer(programs)) as server:
            yield found | {"PostgreSQL": server.url()}


def _children(parent: int) -> Iterator[int]:
    for stat in PROC.glob("[0-9]*/stat"):
        try:
            told = stat.read_text(encoding="utf-8", errors="replace")
        except (FileNotFoundError, ProcessLookupError):
            continue
        # The program's name stands in brackets, and may hold brackets itself.
        if int(told.rpartition(")")[2].split()[PARENT]) == parent:
            yield int(stat.parent.name)


def _server_user() -> pwd.struct_passwd | None:
    if os.geteuid() != 0:
        return None
    known = {entry.pw_name: entry for entry in pwd.getpwall()}
    return next(known[name] for name in USERS if name in known)
