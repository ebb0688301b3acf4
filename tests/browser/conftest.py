"""Headless Chromium and Firefox for tests of pages; the tests of a browser are skipped where there is none."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest

#: software drawing, and nothing that asks the network by itself
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
]
#: the names of each browser's program
PROGRAMS = {"chromium": ("chromium", "chromium-browser", "google-chrome"), "firefox": ("firefox-esr", "firefox")}


@pytest.fixture(scope="session")
def screen() -> Iterator[dict[str, str]]:
    """The environment of a program that needs a screen: WebGL of Firefox does, without a window as well."""
    if "DISPLAY" in os.environ or shutil.which("Xvfb") is None:
        yield dict(os.environ)
        return
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1400x1000x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, pass_fds=(write,), stderr=subprocess.DEVNULL) as process:
        os.close(write)
        with os.fdopen(read) as told:
            number = told.readline().strip()
        yield {**os.environ, "DISPLAY": f":{number}"}
        process.terminate()


@pytest.fixture(scope="module", params=["chromium", pytest.param("firefox", marks=pytest.mark.slow)])
def browser(request: pytest.FixtureRequest, screen: dict[str, str]) -> Iterator[Any]:
    """A browser, driven by playwright."""
    if _program(request.param) is None:
        pytest.skip(f"no {request.param} here: `apt install {PROGRAMS[request.param][0]} xvfb` installs one")
    driver = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: it is in the extra `test`")
    with driver.sync_playwright() as playwright:
        opened = _launch(getattr(playwright, request.param), screen)
        yield opened
        opened.close()


def _program(name: str) -> str | None:
    return next(filter(None, map(shutil.which, PROGRAMS[name])), None)


def _launch(kind: Any, screen: dict[str, str], **prefs: Any) -> Any:
    program = _program(kind.name)
    if kind.name == "chromium":
        return kind.launch(executable_path=program, args=FLAGS)
    # That channel is Firefox as it is, by the protocol of the W3C, and not playwright's own build.
    prefs = {"webgl.force-enabled": True, **prefs}
    return kind.launch(channel="moz-firefox", executable_path=program, env=screen, firefox_user_prefs=prefs)


@pytest.fixture
def dark(browser: Any, screen: dict[str, str]) -> Iterator[Any]:
    """A new page of someone who has asked for dark colours; Firefox takes that at its start alone."""
    if browser.browser_type.name == "chromium":
        context = browser.new_context(color_scheme="dark")
    else:
        context = _launch(browser.browser_type, screen, **{"layout.css.prefers-color-scheme.content-override": 0})
    yield context.new_page()
    context.close()


def note_errors(page: Any, errors: list[str]) -> None:
    """Collect what a page complains of.

    Firefox also reports the style that playwright adds for a screenshot, and that the policy of the page refuses.
    """

    def note(text: str) -> None:
        if "blocked an inline style" not in text:
            errors.append(text)

    page.on("console", lambda message: note(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: note(str(error)))


@pytest.fixture
def errors() -> list[str]:
    """What pages complain of; a test ends with none."""
    return []


@pytest.fixture
def page(browser: Any, errors: list[str]) -> Iterator[Any]:
    """A new page whose network is off."""
    context = browser.new_context(viewport={"width": 1000, "height": 900}, offline=browser.browser_type.name == "chromium")
    page = context.new_page()
    note_errors(page, errors)
    yield page
    context.close()
