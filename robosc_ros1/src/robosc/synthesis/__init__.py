"""Supervisory control synthesis: plant to supervisor, and what can be asked about the result."""

from robosc.synthesis.compute import DEFAULT_MAX_STATES, synthesize
from robosc.synthesis.explore import Graph, Transition, explore

__all__ = ["DEFAULT_MAX_STATES", "Graph", "Transition", "explore", "synthesize"]
