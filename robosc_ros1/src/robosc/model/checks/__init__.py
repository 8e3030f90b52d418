"""Checks of a resolved model."""
