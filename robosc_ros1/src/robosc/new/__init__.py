"""A model to begin with: a small one with comments, or one of what runs or was recorded."""
