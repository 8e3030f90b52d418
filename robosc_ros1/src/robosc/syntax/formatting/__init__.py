"""The layout of a model's text."""
