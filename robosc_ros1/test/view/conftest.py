"""Fixtures of the tests of the live picture."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from view.browser import Browser, headless, missing_browser


@pytest.fixture(scope="session")
def shared_browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    reason = missing_browser()
    if reason is not None:
        pytest.skip(reason)
    with headless(tmp_path_factory.mktemp("browser")) as running:
        yield running


@pytest.fixture
def browser(shared_browser: Browser) -> Iterator[Browser]:
    """A headless browser. A test in which the page complains has failed."""
    shared_browser.look()
    shared_browser.complaints()
    yield shared_browser
    complaints = shared_browser.complaints()
    shared_browser.open("about:blank")
    assert not complaints
