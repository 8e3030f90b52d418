"""The script language: lines for a machine, and what is told of them."""
