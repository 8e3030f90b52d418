"""Recordings of runs: read, and judged."""
