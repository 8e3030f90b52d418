"""Explanations of restrictions, and diagnostics that need the state space."""
