"""What an operator does with the page of ``robosc view --operate``."""

from __future__ import annotations

from view.browser import Browser

__all__ = ["TOLD", "click", "send"]

TOLD = "document.getElementById('told').textContent"
"""What the page says of what was asked last; empty if it was done."""


def click(browser: Browser, button: str) -> None:
    browser.sees(f"!document.getElementById('{button}').disabled")
    browser.run(f"document.getElementById('{button}').click()")


def send(browser: Browser, message: str, text: str) -> None:
    form = f"document.querySelector('[data-message={message}]')"
    browser.sees(f"{form} !== null")
    browser.run(f"{form}.querySelector('input').value = arguments[0]", text)
    browser.run(f"{form}.querySelector('button').click()")
