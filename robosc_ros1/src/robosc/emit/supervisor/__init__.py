"""What packages need that guard the controller of somebody else."""
