"""What a syntax error may mean, and where the parser goes on behind it."""
