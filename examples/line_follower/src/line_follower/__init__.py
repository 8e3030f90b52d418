"""The world of the line follower example."""
