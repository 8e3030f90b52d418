"""``controller-config.json``, the options of the original RoboSC, as that takes them.

The file is found beside the model or, failing that, in any folder below. Keys that the original
does not know mean nothing to it; here they are a warning, since most are misspelt.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from robosc.emit.package.config import EVENT_LOG, OWN, Config, key_hint, read_own, read_text
from robosc.errors import UsageError

ORIGINAL = "controller-config.json"

_LOCATIONS = {
    "ros1ControllerNodeLocation": ("ros1", "controller"),
    "ros2ControllerNodeLocation": ("ros2", "controller"),
    "ros2SupervisorNodeLocation": ("ros2", "supervisor"),
}
"""Keys below ``output`` with target and mode."""

_RUN = {
    "packageName": "package",
    "namespace": "namespace",
    "executable": "executable",
    "name": "name",
}
_LAUNCH = {"packageName": "package", "file": "launch_file"}
"""Keys below ``supervisor.controller`` with those of the section ``supervisor`` of our own."""


def load_config(model: Path, file: Path | None = None) -> Config:
    """The options for a model: from ``file``, or from the files that belong to the model.

    Raises:
        UsageError: a file cannot be read, is no YAML or JSON, or has a value that is not allowed or
            (``robosc.yaml``) a key that is not known; the message names file and key.
    """
    if file is not None:
        read = _read_original if file.suffix == ".json" else read_own
        return read(file, Config())
    original = _original_of(model.parent)
    config = Config() if original is None else _read_found(original, model.parent)
    own = model.parent / OWN
    return read_own(own, config) if own.is_file() else config


def _original_of(folder: Path) -> Path | None:
    """The first file of that name: here, else further down. Hidden folders are passed over."""
    for place, below, files in os.walk(folder):
        if ORIGINAL in files:
            return Path(place, ORIGINAL)
        below[:] = sorted(name for name in below if not name.startswith("."))
    return None


def _read_found(file: Path, base: Path) -> Config:
    """The options in a file that was found for a model in the folder ``base``.

    A faulty one further down may belong to something else: it is a warning.
    """
    try:
        return _read_original(file, Config(), base)
    except UsageError as error:
        if file.parent == base:
            raise
        return Config(warnings=(f"{error}; this file is ignored",))


def _read_original(file: Path, config: Config, base: Path | None = None) -> Config:
    """``base`` is the folder of the model (by default that of the file)."""
    reader = _Reader(file)
    options = reader.section(
        _parsed(file), "", ("publishStateInformation", "writeEventsToLog", "output", "supervisor")
    )
    shows = reader.switch(options, "publishStateInformation", True)
    logs = reader.switch(options, "writeEventsToLog", False)
    parameters = {
        "legacy_state_topic": "/state" if shows else "",
        "event_log": EVENT_LOG if logs else "",
    }
    places = reader.texts(options.get("output"), "output", _LOCATIONS)
    return replace(
        config,
        parameters={**config.parameters, **parameters},
        locations={_LOCATIONS[key]: (base or file.parent) / p for key, p in places.items()},
        supervisor=reader.guarded(options.get("supervisor")),
        warnings=(*config.warnings, *reader.warnings),
    )


def _parsed(file: Path) -> Any:
    try:
        return json.loads(read_text(file))
    except json.JSONDecodeError as error:
        raise UsageError(f"{file}:{error.lineno}:{error.colno}: {error.msg}") from error
    except RecursionError as error:
        raise UsageError(f"{file} is nested too deeply") from error


class _Reader:
    """Takes the file apart, and collects warnings about what means nothing."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self.warnings: list[str] = []

    def section(self, value: Any, name: str, known: tuple[str, ...]) -> Mapping[str, Any]:
        """The known keys of an object; None, where there is none, has no keys."""
        if value is None and name:
            return {}
        if not isinstance(value, dict):
            raise self._fault(name, "hold keys and values" if not name else "be an object", value)
        for key in value:
            if key not in known:
                inside = f" in {name}" if name else ""
                hint = key_hint(key, known)
                self.warnings.append(f"{self._file}: unknown key {key!r}{inside}; {hint}")
        return {key: part for key, part in value.items() if key in known}

    def switch(self, options: Mapping[str, Any], key: str, default: bool) -> bool:
        value = options.get(key, default)
        if not isinstance(value, bool):
            raise self._fault(key, "be true or false", value)
        return value

    def texts(self, value: Any, name: str, known: Mapping[str, Any]) -> dict[str, str]:
        """The texts of an object; empty ones, and null, are as good as none."""
        found = {k: v for k, v in self.section(value, name, tuple(known)).items() if v is not None}
        for key, part in found.items():
            if not isinstance(part, str):
                raise self._fault(f"{name}.{key}", "be a text", part)
        return {key: part for key, part in found.items() if part}

    def guarded(self, value: Any) -> dict[str, str]:
        """The controller that a supervisor guards, with the keys of our own section."""
        name = "supervisor.controller"
        controller = self.section(value, "supervisor", ("controller",)).get("controller")
        parts = self.section(controller, name, ("run", "launch"))
        run = self.texts(parts.get("run"), f"{name}.run", _RUN)
        launch = self.texts(parts.get("launch"), f"{name}.launch", _LAUNCH)
        if launch:
            return {_LAUNCH[key]: text for key, text in launch.items()}
        return {_RUN[key]: text for key, text in run.items()}

    def _fault(self, name: str, what: str, value: Any) -> UsageError:
        told = f"{self._file}: {name}" if name else str(self._file)
        return UsageError(f"{told} must {what}, not {value!r}"[:300])
