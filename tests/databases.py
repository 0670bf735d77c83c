"""Databases for tests: empty ones that have all tables, on SQLite and on a PostgreSQL of the tests' own.

Making the tables takes longer than most tests, so it is done once per run: a database for one test is a copy,
of a file or by PostgreSQL's own template.
"""

from __future__ import annotations

import asyncio
import os
import pwd
import shutil
import socket
import subprocess
import tempfile
from itertools import count
from pathlib import Path

import asyncpg

from dray.store import open_store

USERS = ("postgres", "nobody")
"""Whom the server runs as when the tests run as root, which PostgreSQL refuses to do: the first there is."""

STARTS = 3
"""Attempts to start the server: somebody else may take the free port before it does."""

CONFIGURATION = {
    "listen_addresses": "127.0.0.1",
    "unix_socket_directories": "",
    # A test's data need not survive anything.
    "fsync": "off",
    "full_page_writes": "off",
    "max_connections": "50",
}

TEMPLATE = "empty"


class PostgresMissing(Exception):
    """There is no PostgreSQL on this machine."""


def make_tables(url: str) -> None:
    """Let a database have all tables and no rows."""

    async def make() -> None:
        await (await open_store(url)).close()

    asyncio.run(make())


class Files:
    """SQLite databases.

    Args:
        home: where the empty one is made.
    """

    def __init__(self, home: Path) -> None:
        self._empty = home / "empty.db"
        make_tables(_file_url(self._empty))

    def new(self, folder: Path) -> str:
        """The URL of an empty database, `dray.db` in this folder."""
        return _file_url(Path(shutil.copy(self._empty, folder / "dray.db")))


def _file_url(path: Path) -> str:
    return f"sqlite+aiosqlite:///{path}"


class Postgres:
    """A PostgreSQL server on a free port of 127.0.0.1, with a folder of its own.

    Raises:
        PostgresMissing: it is not installed.
    """

    def __init__(self) -> None:
        self._bin = _binaries()
        self._user = _server_user()
        self._home = Path(tempfile.mkdtemp(prefix="dray-postgres-"))
        self._numbers = count(1)
        self.port = 0
        if self._user is not None:
            os.chown(self._home, self._user.pw_uid, self._user.pw_gid)
        self._guard = self._keep_guard()
        try:
            data = str(self._home / "data")
            self._run("initdb", "-D", data, "-U", "dray", "-A", "trust", "-E", "UTF8", "--no-locale", "-N")
            self.start()
            self._administer(f"CREATE DATABASE {TEMPLATE}")
            make_tables(self.url(TEMPLATE))
        except BaseException:
            self.close()
            raise

    def url(self, database: str) -> str:
        return f"postgresql+asyncpg://dray@127.0.0.1:{self.port}/{database}"

    def new(self) -> str:
        """The URL of an empty database."""
        name = f"test_{next(self._numbers)}"
        self._administer(f"CREATE DATABASE {name} TEMPLATE {TEMPLATE}")
        return self.url(name)

    def drop(self, url: str) -> None:
        """Remove a database that `new` has made, whoever still uses it."""
        self._administer(f"DROP DATABASE {url.rpartition('/')[2]} WITH (FORCE)")

    def start(self) -> None:
        """Start the server, on the port that it had before if it had one."""
        for attempt in range(1, STARTS + 1):
            port = self.port or _free_port()
            options = " ".join(f"-c {name}='{value}'" for name, value in CONFIGURATION.items())
            log = str(self._home / "log")
            started = self._run("pg_ctl", "start", "-w", "-l", log, "-o", f"-p {port} {options}", check=False)
            if started.returncode == 0:
                self.port = port
                return
            if attempt == STARTS:
                raise RuntimeError(f"PostgreSQL does not start:\n{Path(log).read_text()}")

    def stop(self) -> None:
        """Stop the server as a restart of it does: all connections end."""
        self._run("pg_ctl", "stop", "-w", "-m", "fast")

    def close(self) -> None:
        """Stop the server and remove all that it has kept."""
        self._guard.communicate()

    def _keep_guard(self) -> subprocess.Popen[bytes]:
        """A process that cleans up when this one has ended, in whatever way: then the pipe between them ends."""
        script = 'cat; "$0" stop --mode=immediate --pgdata="$1/data"; rm -r "$1"'
        return subprocess.Popen(
            ["/bin/sh", "-c", script, str(self._bin / "pg_ctl"), str(self._home)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            user=None if self._user is None else self._user.pw_uid,
            group=None if self._user is None else self._user.pw_gid,
            extra_groups=None if self._user is None else [],
            # Not ended with us by the terminal.
            start_new_session=True,
        )

    def _run(self, program: str, *args: str, check: bool = True) -> subprocess.CompletedProcess[str]:
        user = self._user
        return subprocess.run(
            [str(self._bin / program), *args],
            env={**os.environ, "PGDATA": str(self._home / "data")},
            cwd=self._home,
            user=None if user is None else user.pw_uid,
            group=None if user is None else user.pw_gid,
            extra_groups=None if user is None else [],
            check=check,
            text=True,
            stdin=subprocess.DEVNULL,
            # Not a pipe: the server that is started inherits it, and would keep it open.
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def _administer(self, command: str) -> None:
        async def administer() -> None:
            connection = await asyncpg.connect(
                host="127.0.0.1", port=self.port, user="dray", database="postgres"
            )
            try:
                await connection.execute(command)
            finally:
                await connection.close()

        asyncio.run(administer())


def _binaries() -> Path:
    """Where the newest PostgreSQL is: Debian keeps it out of the PATH."""
    debian = sorted(
        Path("/usr/lib/postgresql").glob("*/bin/pg_ctl"), key=lambda path: float(path.parts[-3]), reverse=True
    )
    found = debian[0] if debian else shutil.which("pg_ctl")
    if found is None:
        raise PostgresMissing("no PostgreSQL; on Debian: apt-get install postgresql")
    return Path(found).resolve().parent


def _server_user() -> pwd.struct_passwd | None:
    if os.geteuid() != 0:
        return None
    known = {entry.pw_name: entry for entry in pwd.getpwall()}
    return next(known[name] for name in USERS if name in known)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
