"""The test of a generated package: runs that show what the model demands, written as scripts."""
