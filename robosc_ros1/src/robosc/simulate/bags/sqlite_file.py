"""Files of ROS 2 in the format of SQLite (``.db3``)."""

from __future__ import annotations

import sqlite3
from array import array
from pathlib import Path
from typing import Any

from robosc.simulate.bags import mcap_file, storage

_MAPPED = 1 << 40
"""Bytes of a file that need not be copied before they are read, as far as SQLite can do so."""
_DAMAGES = (sqlite3.DatabaseError, TypeError)
"""What is raised by a page that is damaged or cut off: it may have rows without times."""
_ROWS = 500
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
        self.contents = storage.Contents()
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
            raise storage.Damaged(f"{error} at row {place:,}") from error

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
            self.contents.channels[number] = storage.Channel(
                topic, type_, text, schema, "cdr", mcap_file.is_latched(str(qos))
            )

    def _read_index(self) -> None:
        try:
            self._take_rows(_ROWS)
        except _DAMAGES:
            try:
                self._take_rows(1)  # those before what is damaged
            except _DAMAGES as error:
                places = self.contents.index.places
                if not places:
                    raise sqlite3.DatabaseError(str(error)) from error
                self.contents.cut = f"it is damaged behind row {places[-1]:,}: {error}"

    def _take_rows(self, count: int) -> None:
        """Take the index of the rows behind the last one, so many at a time."""
        places = self.contents.index.places
        cursor = self._database.execute(
            "SELECT id, topic_id, max(timestamp, 0) FROM messages WHERE id > ? ORDER BY id",
            (places[-1] if places else -1,),
        )
        while rows := cursor.fetchmany(count):
            numbers, channels, times = (array("Q", column) for column in zip(*rows, strict=True))
            self.contents.index.extend(times, channels, numbers)

    def _rows(self, query: str) -> Any:
        return self._database.execute(query)
