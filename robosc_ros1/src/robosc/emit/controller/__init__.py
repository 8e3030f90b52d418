"""The module ``controller.py`` of a generated package."""
