"""A model to begin with: a small one with comments, or one made from what runs in a ROS graph."""
