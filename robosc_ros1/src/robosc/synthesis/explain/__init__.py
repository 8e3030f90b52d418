"""Reasons for restrictions, and diagnostics that need the state space."""
