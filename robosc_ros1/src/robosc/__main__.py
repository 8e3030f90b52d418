"""``python3 -m robosc VERB …``."""

from robosc.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
