"""A server of the Model Context Protocol: an agent's tools are a model's commands.

:mod:`.tools` says what an agent may ask, :mod:`.simulated` and :mod:`.running` carry it out, in a
simulator or through a running node, and :mod:`.server` speaks the protocol.
"""
