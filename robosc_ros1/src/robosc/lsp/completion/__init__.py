"""What can stand at a place in an unfinished model."""
