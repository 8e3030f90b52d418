"""Independent verification of a supervisor against its plant."""
