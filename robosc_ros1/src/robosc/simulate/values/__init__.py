"""Values of events: as one types them, as logs have them, and drawn at random."""
