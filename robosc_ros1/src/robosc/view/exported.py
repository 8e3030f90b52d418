"""A recording as one HTML file that needs no server: to attach to a report, to keep with a log.

The page is the one that is served. All events and states are in it, compressed: the states as the
values that change from one event to the next.
"""

from __future__ import annotations

import base64
import gzip
import json
import re
from collections.abc import Iterator
from typing import Any

from robosc.view import hub, recorded, server

Json = Any

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
_NONE = object()
"""Differs from every value."""
_SCRIPT = re.compile(r'<script src="([\w.]+)" defer></script>\n')
_STYLE = re.compile(r'<link rel="stylesheet" href="([\w.]+)">\n')


def html_of(recording: recorded.Recording) -> str:
    """Return the page of a recording with everything that it needs."""
    page = _read("index.html")
    scripts = [_read(name) for name in _SCRIPT.findall(page)]
    page = _SCRIPT.sub("", page)
    head = f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
    styles = "\n".join(_read(name) for name in _STYLE.findall(page))
    page = _STYLE.sub("", page).replace("</head>", f"{head}<style>\n{styles}</style>\n</head>")
    text = "\n".join(hub.compact(part) for part in _documents(recording))
    packed = gzip.compress(hub.utf8(text), mtime=0)
    data = f'<script id="recorded" type="text/plain">{base64.b64encode(packed).decode()}</script>\n'
    program = f"<script>\n{''.join(scripts)}</script>\n"
    return page.replace("</body>", f"{data}{program}</body>")


def _read(name: str) -> str:
    return (server.PAGE / name).read_text(encoding="utf-8")


def _documents(recording: recorded.Recording) -> tuple[Json, Json]:
    """What ``exported.js`` reads: all that may have numbers that are no doubles, and the rest.

    ``first`` is a state, ``paths`` lead to what changes in it. Each step has pairs: the place of a
    path, and of the value that it takes, in ``values``. A step that is null has no known state.
    """
    values: dict[str, int] = {}
    paths: list[list[str | int]] = []
    first = None
    before: list[Json] = []
    steps: list[list[int] | None] = []
    for state in recording.states():
        if state is None:
            steps.append(None)
            continue
        if first is None:
            first = state
            paths = [path for path, _ in _leaves(state)]
            before = [_NONE] * len(paths)
        step = []
        after = [value for _, value in _leaves(state)]
        for place, (old, new) in enumerate(zip(before, after, strict=True)):
            if old != new:
                step += [place, values.setdefault(hub.compact(new), len(values))]
        steps.append(step)
        before = after
    told = {
        "model": recording.model,
        "events": recording.documents,
        "first": first,
        "values": [json.loads(text) for text in values],
    }
    computed = {
        "hello": recording.hello,
        "overview": recording.overview({}),
        "paths": paths,
        "steps": steps,
    }
    return told, computed


def _leaves(state: Json) -> Iterator[tuple[list[str | int], Json]]:
    """The parts of a state that change, always in the same order; its time and number are those of
    the event."""
    for name in ("components", "variables", "communications", "counters"):
        for key, value in state[name].items():
            yield [name, key], value
    for place, command in enumerate(state["commands"]):
        for key in ("enabled", "blocked_by", "waits_for", "count"):
            yield ["commands", place, key], command[key]
    yield ["stopped"], state["stopped"]
