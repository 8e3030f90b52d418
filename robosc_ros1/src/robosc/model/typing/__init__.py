"""The types of expressions and data."""
