"""The command line: what is around the verbs, and how a command ends, whatever happens."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TextIO

from robosc import __version__, errors, progress, resources
from robosc.console import complain, tell
from robosc.verbs import VERBS, Arguments, Verb

_INTERRUPTED = 130


def main(words: Sequence[str] | None = None) -> int:
    """Run a command line; the exit code is robosc.errors'. Raises SystemExit on wrong usage."""
    _prepare_streams()
    _add_extras()
    try:
        try:
            words = sys.argv[1:] if words is None else words
            if "_ARGCOMPLETE" in os.environ:  # a shell asks what may follow
                import argcomplete

                argcomplete.autocomplete(_parser(VERBS))
            _know_verb(words)
            asked = [verb for verb in VERBS if words[:1] == [verb.name]]
            args, unknown = _parser(asked or VERBS).parse_known_args(words)
            if unknown:  # argparse itself would show the usage of robosc, which names no options
                args.parser.error(f"unrecognized arguments: {' '.join(unknown)}")
            return _guarded(args)
        finally:
            sys.stdout.flush()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return _INTERRUPTED
    except BrokenPipeError:
        # The reader has seen enough (robosc explore … | head): nothing to report.
        _drop_output(sys.stdout)
        return 0
    except OSError as error:
        _drop_output(sys.stdout)
        try:
            complain(f"cannot write the result: {error.strerror or error}")
        except OSError:
            _drop_output(sys.stderr)
        return errors.UsageError.exit_code


def _guarded(args: Arguments) -> int:
    args.progress = progress.ProgressLine(sys.stderr)
    try:
        if not _stands_somewhere():
            raise errors.UsageError(
                "the current folder is gone, or another one took its place: cd $PWD"
            )
        verb: Verb = args.verb
        return verb.run(args)
    except (errors.ModelError, errors.EmptySupervisorError) as error:
        tell(error.diagnostics)
        return error.exit_code
    except errors.RoboscError as error:
        complain(str(error))
        return error.exit_code
    except MemoryError:
        complain(errors.OUT_OF_MEMORY)
        return errors.StateSpaceError.exit_code
    except ModuleNotFoundError as error:
        if error.name is None or error.name.split(".")[0] == "robosc":
            raise
        # Most often a python3 of pyenv or conda that stands before the system's on PATH.
        complain(f"{sys.executable} has no module {error.name!r}; see Install in the README")
        return errors.UsageError.exit_code
    finally:
        args.progress.clear()


def _know_verb(words: Sequence[str]) -> None:
    """Raises SystemExit with a suggestion where the first word is like a verb, but none."""
    names = [verb.name for verb in VERBS]
    if words and words[0] not in names and (similar := get_close_matches(words[0], names, 1)):
        complain(f"there is no verb {words[0]!r}; did you mean 'robosc {similar[0]}'?")
        raise SystemExit(errors.UsageError.exit_code)


def _parser(known: Iterable[Verb]) -> argparse.ArgumentParser:
    """Return what reads a command line with one of some verbs: all of them take as long as the
    start of Python."""
    parser = argparse.ArgumentParser(
        prog="robosc",
        description="From a model of a robot to a controller that is proven to keep it safe.",
        epilog="example: robosc check line_follower.rscd",
    )
    parser.add_argument("--version", action="version", version=f"robosc {__version__}")
    verbs = parser.add_subparsers(metavar="VERB", required=True)
    for verb in known:
        sub = verbs.add_parser(
            verb.name,
            help=verb.summary,
            description=f"{verb.summary[0].upper()}{verb.summary[1:]}.",
            epilog=f"example: robosc {verb.name} {verb.example}",
        )
        verb.add_arguments(sub)
        sub.set_defaults(verb=verb, parser=sub)
    return parser


def _stands_somewhere() -> bool:
    """A shell in a package that is generated anew stands in the folder that was replaced."""
    try:
        return bool(Path.cwd())
    except FileNotFoundError:
        return False


def _add_extras() -> None:
    """Libraries that ./dev setup has fetched are found where no others are installed."""
    extras = resources.extras_folder()
    if extras is not None and str(extras) not in sys.path:
        sys.path.append(str(extras))


def _prepare_streams() -> None:
    """Streams that can be written to, whatever the user did with them.

    A terminal that cannot show a character of the model gets an escape, and a count is shown with
    all its digits.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:  # closed: no other file shall get its number
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115, PTH123 - as long as it runs
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")
    sys.set_int_max_str_digits(0)


def _drop_output(stream: TextIO) -> None:
    """What is still to be written goes nowhere, so that ending does not fail on it again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
