"""The explicit engine: one state after the other, as textbooks do."""
