"""Declarations and statements of a model, resolved."""
