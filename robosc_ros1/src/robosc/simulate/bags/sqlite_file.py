"""Files of ROS 2 in the format of SQLite (``.db3``)."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

from robosc.simulate.bags.mcap_file import is_latched
from robosc.simulate.bags.storage import Channel, Contents, Damaged

_SCHEMAS = {"ros2msg": "ros2msg", "ros2idl": "ros2idl"}


class SqliteFile:
    """A database of messages; a place is the number of a row."""

    def __init__(self, path: Path) -> None:
        self.contents = Contents()
        # What a recorder that died had not yet moved into the database lies in a file beside it.
        how = "mode=ro" if path.with_name(f"{path.name}-wal").exists() else "immutable=1"
        self._database = sqlite3.connect(f"{path.absolute().as_uri()}?{how}", uri=True)
        # SQLite opens no file that is shorter than it should be, but for this; nothing is written.
        self._database.execute("PRAGMA writable_schema = ON")
        try:
            self._describe()
            self._read_index()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        self._database.close()

    def load(self, chunk: int) -> sqlite3.Cursor:
        return self._database.cursor()

    def message(self, chunk: sqlite3.Cursor, place: int) -> bytes:
        try:
            row = chunk.execute("SELECT data FROM messages WHERE id = ?", (place,)).fetchone()
        except sqlite3.Error as error:
            raise Damaged(f"{error} at row {place:,}") from error
        return bytes(row[0])

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
        add = self.contents.index.add
        place = 0
        try:
            for row in self._rows("SELECT id, topic_id, timestamp FROM messages ORDER BY id"):
                if not all(isinstance(value, int) for value in row):
                    raise sqlite3.DatabaseError("a row has no time")  # of a page that is cut off
                place, channel, time = row
                add(max(time, 0), channel, 0, place)
        except sqlite3.DatabaseError as error:
            if not place:
                raise
            self.contents.cut = f"it is damaged behind row {place:,}: {error}"

    def _rows(self, query: str) -> Any:
        return self._database.execute(query)
