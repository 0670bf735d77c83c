"""The API's documentation as a page: no scripts and no external content, so it works offline."""

from __future__ import annotations

import base64
import hashlib
import json
from typing import Any

import jinja2
from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from dray.gateway.http.middleware import CONTENT_POLICY

router = APIRouter(include_in_schema=False)

STYLE = """
:root{color-scheme:light dark;font:16px/1.5 system-ui,sans-serif}
body{overflow-wrap:anywhere;max-width:60rem;margin:2rem auto;padding:0 1rem}
pre{white-space:pre-wrap;overflow-wrap:anywhere;padding:.75rem;border:1px solid #8888;border-radius:.5rem;font-size:.875rem}
section{border-top:1px solid #8888;margin-top:2rem}
table{border-collapse:collapse}td,th{text-align:left;padding:.25rem 1rem .25rem 0;vertical-align:top}
""".strip()

PAGE = """\
<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>{{ info.title }} API</title><style>{{ style | safe }}</style></head>
<body><main><h1>{{ info.title }} API, {{ info.version }}</h1>
<pre>{{ info.description }}</pre>
<p>As a document for programs: <a href="openapi.json">openapi.json</a></p>
<nav aria-label="Operations"><ul>{% for op in operations %}<li><a href="#{{ op.operationId }}"><code>{{ op.method }} {{ op.path }}</code></a>
{{ op.summary }}</li>{% endfor %}</ul></nav>
{% for op in operations %}<section id="{{ op.operationId }}">
<h2><code>{{ op.method }} {{ op.path }}</code></h2><p>{{ op.description }}</p>
{% if op.parameters %}<h3>Parameters</h3><table>{% for p in op.parameters %}<tr><th><code>{{ p.name }}</code></th>
<td>{{ p.in }}</td><td>{{ p.description or "" }}</td></tr>{% endfor %}</table>{% endif %}
{% for name, body in op.bodies %}<h3>Body: {{ name }}</h3><pre>{{ body }}</pre>{% endfor %}
<h3>Answers</h3><table>{% for status, text in op.answers %}<tr><th>{{ status }}</th><td>{{ text }}</td></tr>{% endfor %}
</table>{% if op.example %}<pre>{{ op.example }}</pre>{% endif %}</section>{% endfor %}
<h2>Shapes</h2>{% for name, shape in shapes %}<details id="{{ name }}"><summary>{{ name }}</summary>
<pre>{{ shape }}</pre></details>{% endfor %}</main></body></html>
"""

STYLE_HASH = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()

HEADERS = {"Content-Security-Policy": f"{CONTENT_POLICY}; style-src 'sha256-{STYLE_HASH}'"}
"""Headers that allow the style of this page, and no other."""


@router.get("/docs")
async def docs(request: Request) -> HTMLResponse:
    """The documentation."""
    state = request.app.state
    if not hasattr(state, "docs"):
        state.docs = _rendered(request.app.openapi())
    return HTMLResponse(state.docs, headers=HEADERS)


def _rendered(api: dict[str, Any]) -> str:
    operations = [
        _operation(method.upper(), path, operation)
        for path, methods in api["paths"].items()
        for method, operation in methods.items()
    ]
    shapes = [(name, _pretty(shape)) for name, shape in sorted(api["components"]["schemas"].items())]
    template = jinja2.Environment(autoescape=True).from_string(PAGE)
    return template.render(info=api["info"], style=STYLE, operations=operations, shapes=shapes)


def _operation(method: str, path: str, operation: dict[str, Any]) -> dict[str, Any]:
    body = operation.get("requestBody", {}).get("content", {}).get("application/json", {})
    bodies = [(one["summary"], _pretty(one["value"])) for one in body.get("examples", {}).values()]
    if body and not bodies:
        bodies = [(body["schema"]["$ref"].rpartition("/")[2], _pretty(body["schema"]))]
    answers = sorted((status, answer["description"]) for status, answer in operation["responses"].items())
    good = next(answer for status, answer in operation["responses"].items() if status.startswith("2"))
    example = good.get("content", {}).get("application/json", {}).get("example")
    return operation | {
        "method": method,
        "path": path,
        "bodies": bodies,
        "answers": answers,
        "example": None if example is None else _pretty(example),
    }


def _pretty(value: object) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False)
