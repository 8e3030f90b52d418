"""The symbolic engine: sets of states as binary decision diagrams (BDDs)."""
