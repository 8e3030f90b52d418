"""Evidence about a model, requirement by requirement, for those who have to be convinced."""
