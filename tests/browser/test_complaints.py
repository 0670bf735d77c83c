"""The watch over all browser tests' pages: it complains of what it should, and of nothing else."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from complaints import Complaints
from playwright.sync_api import Page, Route

OpenPage = Callable[..., Page]

SOUND = '<!doctype html><html lang="en"><title>Page</title><main><h1>Page</h1>{}</main></html>'


def served(page: Page, content: str) -> None:
    """Show this content, as if a server had sent it; nothing else on the network answers either."""

    def answer(route: Route) -> None:
        html = route.request.is_navigation_request()
        route.fulfill(
            body=SOUND.format(content) if html else "", content_type="text/html" if html else "image/png"
        )

    page.route("**/*", answer)
    page.goto("http://page.test/")


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ("<input>", "label"),
        ('<p style="color: #aaa; background: #fff">pale</p>', "color-contrast"),
        ("<button>a</button><button style='height: 9px; width: 9px'></button>", "button-name"),
        ("<script>console.error('broken')</script>", "console error: broken"),
        ("<script>throw new Error('broken')</script>", "exception: broken"),
        ('<img src="http://other.test/picture.png" alt="">', "asked another host: http://other.test"),
    ],
)
def test_a_fault_of_a_page_is_complained_of(
    open_page: OpenPage, complaints: Complaints, content: str, complaint: str
) -> None:
    page = open_page("about:blank")
    served(page, content)
    complaints.audit(page)
    assert [line for line in complaints if complaint in line]
    page.goto("about:blank")
    complaints.clear()


def test_a_sound_page_is_not_complained_of(open_page: OpenPage, complaints: Complaints) -> None:
    page = open_page("about:blank")
    served(page, '<p>text</p><img src="/picture.png" alt="">')
    complaints.audit(page)
    assert complaints == []
