"""Headless Chromium for tests of pages, with what its pages complained about or asked for."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from playwright.sync_api import Browser, Page, sync_playwright

from dolfingrip.report.page.pdf import chromium

LOCAL = ("file:", "data:", "blob:")


@contextmanager
def browser() -> Iterator[Browser]:
    """A browser that draws WebGL in software."""
    arguments = ["--no-sandbox", "--enable-unsafe-swiftshader"]
    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=chromium(), args=arguments)
        yield found
        found.close()


@dataclass
class Heard:
    """What a page said.

    Attributes:
        errors: on the console, and exceptions.
        requests: addresses that are no local file.
    """

    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)


def heard(page: Page) -> Heard:
    """Listen to a page."""
    found = Heard()
    page.on("console", lambda m: found.errors.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: found.errors.append(str(error)))
    page.on(
        "request",
        lambda asked: None if asked.url.startswith(LOCAL) else found.requests.append(asked.url),
    )
    return found


def state(page: Page, name: str) -> str:
    """What a page says about itself, in an attribute of its root."""
    return str(page.evaluate("name => document.documentElement.dataset[name] ?? ''", name))


def overflow_px(page: Page) -> int:
    """How much wider the page is than its window."""
    return int(page.evaluate("document.documentElement.scrollWidth - innerWidth"))
