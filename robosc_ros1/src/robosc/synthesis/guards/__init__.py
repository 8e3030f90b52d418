"""Guards as short expressions of the language."""
