"""``python3 -m robosc VERB …``."""

from robosc.start import run

if __name__ == "__main__":
    raise SystemExit(run())
