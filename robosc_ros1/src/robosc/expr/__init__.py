"""Typed expressions: what the model, the plant, guards and generated code share."""
