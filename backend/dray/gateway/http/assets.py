"""Panels: the pages' templates, and the scripts and styles built by Vite.

Vite names files by their content and lists the names in a manifest, so that a browser may cache them forever
and never uses an old one.
"""

from __future__ import annotations

import mimetypes
from pathlib import Path
from typing import Any

import jinja2
import msgspec
from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from dray.gateway.http.compression import takes_gzip

PREFIX = "/static/"
"""Path prefix of the built files; Vite writes it into them too."""

_HERE = Path(__file__).resolve()

STATIC = _HERE.parents[1] / "static"
"""Folder of the built files."""

FOR_EVER = "public, max-age=31536000, immutable"
"""Cache lifetime of a year, for files whose names change with their content."""


class Chunk(msgspec.Struct, frozen=True, rename="camel"):
    """One entry of Vite's manifest."""

    file: str
    css: tuple[str, ...] = ()
    assets: tuple[str, ...] = ()
    """Files loaded by its style sheets: fonts."""
    imports: tuple[str, ...] = ()
    dynamic_imports: tuple[str, ...] = ()
    """Files that it may load later: languages."""


class NotBuilt(Exception):
    """The panels have not been built."""


class Panels:
    """Templates and built files.

    Args:
        static: the folder of the built files.
        templates: the folder of the templates.
    """

    def __init__(self, static: Path = STATIC, templates: Path | None = None) -> None:
        self._static = static
        self._read: tuple[tuple[int, int, int], dict[str, Chunk]] = ((0, 0, 0), {})
        self._templates = jinja2.Environment(
            loader=jinja2.FileSystemLoader(templates or templates_folder()),
            autoescape=True,
            undefined=jinja2.StrictUndefined,
        )
        self._templates.globals.update(asset=self.asset, styles=self.styles)

    @property
    def _manifest(self) -> dict[str, Chunk]:
        """The manifest; read again when a build has replaced it."""
        file = self._static / ".vite" / "manifest.json"
        try:
            status = file.stat()
            version = (status.st_ino, status.st_mtime_ns, status.st_size)
            if version != self._read[0]:
                self._read = version, msgspec.json.decode(file.read_bytes(), type=dict[str, Chunk])
        except OSError:
            raise NotBuilt(str(self._static)) from None
        return self._read[1]

    def render(self, template: str, **context: Any) -> str:
        """Render a page.

        Raises:
            NotBuilt: the panels are not built, or not this page.
        """
        try:
            return self._templates.get_template(template).render(context)
        except jinja2.TemplateNotFound as error:
            raise NotBuilt(str(error)) from None

    def asset(self, entry: str) -> str:
        """The address of an entry's script, as ``src/manager/main.tsx``.

        Raises:
            NotBuilt: the panels are not built, or not this entry.
        """
        return PREFIX + self._chunk(entry).file

    def styles(self, entry: str) -> list[str]:
        """The addresses of an entry's style sheets, imported ones first.

        Raises:
            NotBuilt: the panels are not built, or not this entry.
        """
        found: dict[str, None] = {}
        seen: set[str] = set()

        def gather(name: str) -> None:
            if name not in seen:
                seen.add(name)
                chunk = self._chunk(name)
                for imported in chunk.imports:
                    gather(imported)
                found.update(dict.fromkeys(chunk.css))

        gather(entry)
        return [PREFIX + name for name in found]

    def files(self, *entries: str) -> list[str]:
        """The addresses of these entries and of everything they may ever load.

        Raises:
            NotBuilt: the panels are not built, or not one of these entries.
        """
        found: dict[str, None] = {}
        left = list(entries)
        while left:
            chunk = self._chunk(left.pop())
            if chunk.file not in found:
                found.update(dict.fromkeys((chunk.file, *chunk.css, *chunk.assets)))
                left += (*chunk.imports, *chunk.dynamic_imports)
        return [PREFIX + name for name in found]

    def source(self, entry: str) -> str:
        """The source of an entry's script.

        Raises:
            NotBuilt: the panels are not built, or not this entry.
        """
        return (self._static / self._chunk(entry).file).read_text(encoding="utf-8")

    def _chunk(self, entry: str) -> Chunk:
        try:
            return self._manifest[entry]
        except KeyError:
            raise NotBuilt(entry) from None


class BuiltFiles(StaticFiles):
    """The built files; browsers cache those with hashed names forever.

    The build adds compressed versions of files that compress well; clients that accept gzip get these.
    """

    async def check_config(self) -> None:
        """Accept missing files: panels that are not built are just not found."""

    def file_response(
        self, full_path: Any, stat_result: Any, scope: Scope, status_code: int = 200
    ) -> Response:
        """One file with its cache lifetime."""
        compressed = Path(f"{full_path}.gz")
        response: Response
        if takes_gzip(scope) and compressed.is_file():
            response = FileResponse(
                compressed,
                status_code,
                {"Content-Encoding": "gzip"},
                mimetypes.guess_type(full_path)[0],
                stat_result=compressed.stat(),
            )
        else:
            response = super().file_response(full_path, stat_result, scope, status_code)
        hashed = Path(full_path).parent.name == "assets"
        response.headers["Cache-Control"] = FOR_EVER if hashed else "no-cache"
        return response


def templates_folder() -> Path:
    """The folder of the templates: at the top of a checkout, or inside the gateway's package in a wheel."""
    inside = _HERE.parents[1] / "templates"
    return inside if inside.is_dir() else _HERE.parents[4] / "frontend" / "templates"
