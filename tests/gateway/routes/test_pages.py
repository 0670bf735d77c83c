"""Pages, the files that they need, and what browsers may do with them."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import pytest
from answers import problem
from fake_bus import PLANT
from gateway_kit import House, gateway

from dray.gateway.http.assets import FOR_EVER, NotBuilt, Panels

pytestmark = pytest.mark.anyio

MANIFEST = {
    "src/theme/init.ts": {"file": "assets/init-1.js"},
    "src/manager/main.tsx": {
        "file": "assets/main-1.js",
        "css": ["assets/main-1.css"],
        "imports": ["_shared.js"],
    },
    "src/operator/main.tsx": {
        "file": "assets/main-2.js",
        "css": ["assets/main-2.css"],
        "assets": ["assets/font-1.woff2"],
        "imports": ["_shared.js"],
        "dynamicImports": ["src/text/operator/en.ts"],
    },
    "src/text/operator/en.ts": {"file": "assets/en-1.js", "imports": ["_shared.js"]},
    "src/login/main.ts": {"file": "assets/login-1.js", "css": ["assets/login-1.css"]},
    "src/operator/shell/worker.ts": {"file": "assets/worker-1.js"},
    "_shared.js": {"file": "assets/shared-1.js", "css": ["assets/shared-1.css"], "imports": ["_shared.js"]},
}


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder as Vite leaves it; the gateway serves its files."""
    folder = tmp_path / "static"
    (folder / ".vite").mkdir(parents=True)
    (folder / ".vite" / "manifest.json").write_bytes(msgspec.json.encode(MANIFEST))
    (folder / "assets").mkdir()
    (folder / "assets" / "main-1.js").write_text("export {};")
    (folder / "assets" / "worker-1.js").write_text("self.SHELL;")
    (folder / "icon.svg").write_text("<svg/>")
    monkeypatch.setattr("dray.gateway.app.STATIC", folder)
    return folder


async def test_the_panel_names_its_own_scripts_and_styles_and_no_others(url: str, built: Path) -> None:
    async with gateway(url, panels=Panels(built)) as house:
        answer = await house.client.get("/")
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    assert answer.headers["cache-control"] == "no-store"
    named = re.findall(r'(?:src|href)="([^"]*)"', answer.text)
    assert "/static/assets/main-1.js" in named
    # What is shared comes first: a panel's own style may overrule it.
    styles = [name for name in named if name.endswith(".css")]
    assert styles == ["/static/assets/shared-1.css", "/static/assets/main-1.css"]
    assert all(name.startswith("/static/") for name in named)
    assert not re.search(r"<script(?![^>]*\bsrc=)|<style|\son\w+=|\bstyle=", answer.text)


async def test_the_operators_shell_is_kept_with_all_its_files_and_nobodys_data(url: str, built: Path) -> None:
    async with gateway(url, panels=Panels(built)) as house:
        house.client.headers.pop("Authorization", None)
        worker = await house.client.get("/operator/worker.js")
        shell = await house.client.get("/operator/shell")
    assert worker.headers["content-type"].startswith("text/javascript")
    assert worker.headers["service-worker-allowed"] == "/operator"
    assert worker.headers["cache-control"] == "no-cache"
    told, source = worker.text.split(";\n")
    kept = msgspec.json.decode(told.removeprefix("self.SHELL = "))
    assert source == "self.SHELL;"
    assert kept["page"] == "/operator/shell"
    assert sorted(kept["files"]) == [
        "/static/assets/en-1.js",
        "/static/assets/font-1.woff2",
        "/static/assets/init-1.js",
        "/static/assets/main-2.css",
        "/static/assets/main-2.js",
        "/static/assets/shared-1.css",
        "/static/assets/shared-1.js",
        "/static/icon.svg",
    ]
    needed = re.findall(r'(?:src|href)="(/static/assets/[^"]*)"', shell.text)
    assert needed
    assert set(needed) <= set(kept["files"])


async def test_another_build_is_another_service_worker(url: str, built: Path) -> None:
    async with gateway(url, panels=Panels(built)) as house:
        before = await house.client.get("/operator/worker.js")
    manifest = built / ".vite" / "manifest.json"
    manifest.write_bytes(manifest.read_bytes().replace(b"main-2.js", b"main-3.js"))
    async with gateway(url, panels=Panels(built)) as house:
        after = await house.client.get("/operator/worker.js")
    assert before.text != after.text


async def test_the_panel_is_in_the_language_that_was_chosen_anywhere(url: str, built: Path) -> None:
    async with gateway(url, panels=Panels(built)) as house:
        wanted = await house.client.get("/", headers={"Accept-Language": "fr, es;q=0.8"})
        house.client.cookies.set("dray_language", "de")
        chosen = await house.client.get("/", headers={"Accept-Language": "fr, es;q=0.8"})
    assert '<html lang="es">' in wanted.text
    assert '<html lang="de">' in chosen.text


@pytest.mark.parametrize("folder", ["nothing", "no such entry"])
async def test_panels_that_are_not_built_say_how_to_build_them(url: str, built: Path, folder: str) -> None:
    if folder == "nothing":
        static = built / "nowhere"
    else:
        static = built
        (built / ".vite" / "manifest.json").write_text("{}")
    async with gateway(url, panels=Panels(static)) as house:
        answer = await house.client.get("/")
        assert (await house.client.get("/api/products")).status_code == 200
    assert answer.status_code == 503
    assert "make panels" in answer.text
    assert "/api/docs" in answer.text
    assert str(built) not in answer.text


async def test_files_of_panels_that_are_not_built_are_not_found(
    url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.gateway.app.STATIC", tmp_path / "nowhere")
    async with gateway(url) as house:
        problem(await house.client.get("/static/icon.svg"), 404, "not-found")


def test_a_template_that_is_not_there_is_no_panel(built: Path) -> None:
    with pytest.raises(NotBuilt):
        Panels(built).render("no-such-page.html", plant=PLANT)


async def test_files_whose_name_tells_their_content_are_kept_for_ever_and_no_others(
    url: str, built: Path
) -> None:
    async with gateway(url) as house:
        hashed = await house.client.get("/static/assets/main-1.js")
        icon = await house.client.get("/static/icon.svg")
        again = await house.client.get("/static/icon.svg", headers={"If-None-Match": icon.headers["etag"]})
    assert hashed.headers["cache-control"] == FOR_EVER
    assert "javascript" in hashed.headers["content-type"]
    assert icon.headers["cache-control"] == "no-cache"
    assert icon.headers["content-type"].startswith("image/svg+xml")
    assert again.status_code == 304


@pytest.mark.parametrize(
    "path",
    [
        "/static/../app.py",
        "/static/%2e%2e/dray.db",
        "/static/..%2fdray.db",
        "/static//etc/passwd",
        "/static/",
    ],
)
async def test_no_other_file_can_be_read(url: str, built: Path, path: str) -> None:
    async with gateway(url) as house:
        problem(await house.client.get(path), 404, "not-found")


@pytest.mark.parametrize("token", ["guess", "%2e%2e", "a?b#c", "%0d%0aX-Evil:1", "%5c%5cevil.test"])
async def test_a_guessed_customers_page_leads_nowhere_else(house: House, token: str) -> None:
    answer = await house.client.get(f"/track/{token}")
    assert "x-evil" not in answer.headers
    assert answer.status_code == 404
    assert not answer.has_redirect_location


async def test_the_documentation_is_one_page_that_needs_no_script_and_no_other_host(house: House) -> None:
    answer = await house.client.get("/api/docs")
    assert answer.status_code == 200
    assert "<script" not in answer.text
    assert not re.search(r'(?:src|href)="(?:https?:)?//', answer.text)
    assert "style-src 'sha256-" in answer.headers["content-security-policy"]
    for path in ("/api/orders", "/api/atvs/{atv}/commands", "/api/events"):
        assert path in answer.text


BROWSER = {"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"}


@pytest.mark.parametrize(
    ("language", "heading"),
    [
        ("en", "There is no page here"),
        ("de", "Hier gibt es keine Seite"),
        ("es-MX,es;q=0.9", "Aquí no hay ninguna página"),
    ],
)
async def test_a_person_at_an_unknown_address_gets_a_page_that_leads_back(
    url: str, built: Path, language: str, heading: str
) -> None:
    async with gateway(url, panels=Panels(built)) as house:
        answer = await house.client.get("/nonsense", headers=BROWSER | {"Accept-Language": language})
        stranger = await house.client.get(
            "/nonsense", headers=BROWSER | {"Accept-Language": language, "Authorization": "Bearer nobody"}
        )
        posted = await house.client.get("/logout", headers=BROWSER | {"Accept-Language": language})
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    assert f"<h1>{heading}</h1>" in answer.text
    assert '<a href="/">' in answer.text
    assert "nonsense" not in answer.text
    assert stranger.text == answer.text, "it is the same for everybody"
    assert (posted.status_code, posted.headers["allow"]) == (405, "POST")
    assert heading in posted.text


@pytest.mark.parametrize(
    ("path", "accept"),
    [
        ("/nonsense", "application/json"),
        ("/nonsense", "*/*"),
        ("/api/nonsense", BROWSER["Accept"]),
        ("/api", BROWSER["Accept"]),
    ],
)
async def test_a_program_at_an_unknown_address_gets_the_problem(
    url: str, built: Path, path: str, accept: str
) -> None:
    async with gateway(url, panels=Panels(built)) as house:
        problem(await house.client.get(path, headers={"Accept": accept}), 404, "not-found")


async def test_without_built_panels_an_unknown_address_is_a_problem_for_everybody(
    url: str, tmp_path: Path
) -> None:
    async with gateway(url, panels=Panels(tmp_path)) as house:
        problem(await house.client.get("/nonsense", headers=BROWSER), 404, "not-found")
