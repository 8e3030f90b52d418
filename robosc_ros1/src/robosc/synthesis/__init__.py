"""Supervisory control synthesis: from a plant to its supervisor, and the explicit state space."""

from robosc.synthesis.compute import synthesize
from robosc.synthesis.explore import Graph, GraphTransition, explore

__all__ = ["Graph", "GraphTransition", "explore", "synthesize"]
