"""The files of a generated package."""
