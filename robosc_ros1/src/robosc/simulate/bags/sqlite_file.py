"""Files of ROS 2 in the format of SQLite (``.db3``)."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

from robosc.simulate.bags.mcap_file import is_latched
from robosc.simulate.bags.storage import Channel, Contents, Damaged

_MAPPED = 1 << 40
"""Bytes of a file that need not be copied before they are read, as far as SQLite can do so."""
_ROWS = 10_000
"""Rows of the index that are taken together."""
_SCHEMAS = {"ros2msg": "ros2msg", "ros2idl": "ros2idl"}


class _Rows:
    """The rows with messages. One that follows the last is had without another query."""

    def __init__(self, cursor: sqlite3.Cursor) -> None:
        self._cursor = cursor
        self._next = -1

    def at(self, place: int) -> bytes:
        row = self._cursor.fetchone() if place == self._next else None
        if row is None or row[0] != place:
            query = "SELECT id, data FROM messages WHERE id >= ? ORDER BY id"
            row = self._cursor.execute(query, (place,)).fetchone()
        self._next = place + 1
        return bytes(row[1])


class SqliteFile:
    """A database of messages; a place is the number of a row."""

    def __init__(self, path: Path) -> None:
        self.contents = Contents()
        # What a recorder that died had not yet moved into the database lies in a file beside it.
        how = "mode=ro" if path.with_name(f"{path.name}-wal").exists() else "immutable=1"
        self._database = sqlite3.connect(f"{path.absolute().as_uri()}?{how}", uri=True)
        # SQLite opens no file that is shorter than it should be, but for this; nothing is written.
        self._database.execute("PRAGMA writable_schema = ON")
        self._database.execute(f"PRAGMA mmap_size = {_MAPPED}")
        try:
            self._describe()
            self._read_index()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        self._database.close()

    def load(self, chunk: int) -> _Rows:
        return _Rows(self._database.cursor())

    def message(self, chunk: _Rows, place: int) -> bytes:
        try:
            return chunk.at(place)
        except sqlite3.Error as error:
            raise Damaged(f"{error} at row {place:,}") from error

    def _columns(self, table: str) -> set[str]:
        return {row[1] for row in self._database.execute(f"PRAGMA table_info({table})")}

    def _describe(self) -> None:
        definitions: dict[str, tuple[str, str]] = {}
        if self._columns("message_definitions"):
            rows = self._database.execute(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            )
            definitions = {type_: (_SCHEMAS.get(form, ""), text) for type_, form, text in rows}
        profiles = "offered_qos_profiles" in self._columns("topics")
        columns = (
            f"id, name, type, serialization_format, {'offered_qos_profiles' if profiles else '0'}"
        )
        for number, topic, type_, form, qos in self._rows(f"SELECT {columns} FROM topics"):
            if form != "cdr":
                self.contents.left_out[topic] = form
                continue
            schema, text = definitions.get(type_, ("", ""))
            self.contents.channels[number] = Channel(
                topic, type_, text, schema, "cdr", is_latched(str(qos))
            )

    def _read_index(self) -> None:
        index = self.contents.index
        query = "SELECT id, topic_id, max(timestamp, 0) FROM messages ORDER BY id"
        try:
            cursor = self._rows(query)
            while rows := cursor.fetchmany(_ROWS):
                places, channels, times = map(partial(array, "Q"), zip(*rows, strict=True))
                index.extend(times, channels, places)
        except (sqlite3.DatabaseError, TypeError) as error:  # a row without time: its page is cut
            self._read_rows(query)

    def _rows(self, query: str) -> Any:
        return self._database.execute(query)
