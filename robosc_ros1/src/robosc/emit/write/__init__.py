"""Files of a package: lines broken, written without harm to what is there."""
