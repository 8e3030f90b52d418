"""What plays a robot: one event of the supervised system at a time, or the generated code."""
