"""Declarative tables of the language, which every later stage reads."""
