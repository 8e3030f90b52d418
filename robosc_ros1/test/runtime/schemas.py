"""Validation of documents against the schemas in ``docs/schemas``."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import pytest
from ros_support import REPOSITORY

__all__ = ["validate"]

FOLDER = REPOSITORY / "docs" / "schemas"


def validate(document: Any, name: str) -> None:
    """Fail if the document does not follow ``<name>.schema.json``; skip without jsonschema."""
    _validator(name).validate(document)


@cache
def _validator(name: str) -> Any:
    jsonschema = pytest.importorskip("jsonschema")
    schemas = {path.name: json.loads(path.read_text("utf-8")) for path in FOLDER.glob("*.json")}
    schema = schemas[f"{name}.schema.json"]
    jsonschema.Draft7Validator.check_schema(schema)
    base = f"{FOLDER.as_uri()}/"
    resolver = jsonschema.RefResolver(
        f"{base}{name}.schema.json",
        schema,
        store={base + key: content for key, content in schemas.items()},
    )
    return jsonschema.Draft7Validator(schema, resolver=resolver)
