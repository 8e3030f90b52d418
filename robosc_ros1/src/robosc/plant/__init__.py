"""The plant: automata and requirements, and what an event does."""
