"""The dense engine: sets of states as bit arrays, one bit per state of the product."""
