"""Fixtures of the tests of the server for agents."""

from agents.agent_support import sdk, start_agent

__all__ = ["sdk", "start_agent"]
