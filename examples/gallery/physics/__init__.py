"""Robots in MuJoCo, driven over ROS: worlds, the bridge to ROS 1 and 2, observer, film."""
