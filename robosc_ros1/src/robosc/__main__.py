"""``python3 -m robosc VERB …``."""

try:
    from robosc.start import run
except KeyboardInterrupt:
    raise SystemExit(130) from None

if __name__ == "__main__":
    raise SystemExit(run())
