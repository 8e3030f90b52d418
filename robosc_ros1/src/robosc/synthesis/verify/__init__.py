"""An independent check of a supervisor against its plant."""
