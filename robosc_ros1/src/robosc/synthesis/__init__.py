"""Supervisory control synthesis: from a plant to its supervisor, and the explicit state space."""

from robosc.synthesis.compute import DEFAULT_MAX_STATES, synthesize
from robosc.synthesis.explore import Graph, Transition, explore

__all__ = ["DEFAULT_MAX_STATES", "Graph", "Transition", "explore", "synthesize"]
