"""The verbs of the command line, each a small function from parsed arguments to an exit code.

The stages that it needs are loaded when it runs, so that ``robosc --help`` starts at once.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robosc import __version__, arguments, codes, console, errors, model_files, names, pipeline
from robosc.lazy_dataclasses import dataclass
from robosc.resources import diagnostics_page, section
from robosc.source import MODEL_SUFFIXES

if TYPE_CHECKING:
    from robosc.model.entities import Robot
    from robosc.supervisor import Supervisor

Arguments = argparse.Namespace


@dataclass(frozen=True)
class Verb:
    """One verb: its help, with arguments as an example, its own arguments, what it does."""

    name: str
    summary: str
    example: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[Arguments], int]


def _check(args: Arguments) -> int:
    if not args.watch:
        return _check_once(args)
    for _ in model_files.saved([*args.models, *args.library_path]):
        try:
            _check_once(args)
        except errors.UsageError as error:  # it may be mended meanwhile
            console.complain(str(error))
        sys.stdout.flush()
        print(f"checked at {time.strftime('%H:%M:%S')}; Ctrl-C ends it", file=sys.stderr)
    return 0


def _check_once(args: Arguments) -> int:
    from robosc import report

    results: list[pipeline.Checked] = []
    unreadable: list[errors.UsageError] = []
    for path in {os.path.realpath(path): path for path in model_files.models(args.models)}.values():
        try:
            results.append(pipeline.check(path, _options(args)))
        except errors.UsageError as error:
            unreadable.append(error)
    args.progress.clear()
    if not results:
        raise errors.UsageError("\n".join(str(problem) for problem in unreadable))
    diagnostics = errors.sort_diagnostics(d for result in results for d in result.diagnostics)
    if args.json or args.format == "json":
        _print_json(report.diagnostics(diagnostics))
    elif args.format == "sarif":
        _print_json(report.sarif(diagnostics, __version__))
    elif args.format == "github":
        print(report.github_text(diagnostics), end="")
    else:
        console.tell(diagnostics)
        count = {s: sum(d.severity is s for d in diagnostics) for s in errors.Severity}
        print(
            f"{errors.counted(len(results), 'file')}:"
            f" {errors.counted(count[errors.Severity.ERROR], 'error')},"
            f" {errors.counted(count[errors.Severity.WARNING], 'warning')}"
        )
    for problem in unreadable:
        console.complain(str(problem))
    if unreadable:
        return errors.UsageError.exit_code
    return next((r.exit_code for r in results if r.exit_code), 0)


def _new(args: Arguments) -> int:
    from robosc.new.skeleton import small
    from robosc.new.start import recorded, running

    name = args.name
    if not names.is_identifier(name):
        raise errors.UsageError(
            f"{name!r} is not a name for a robot: letters, digits and _, as in Rover"
        )
    file = Path(f"{names.snake_case(name)}.rscd")
    if file.exists():
        raise errors.UsageError(f"{file} is there already: take another name, or remove it")
    if args.from_ros:
        text = running(name, os.environ)
    elif args.from_bag:
        text = recorded(name, args.from_bag)
    else:
        text = small(name)
    args.progress.clear()
    model_files.write_text(file, text)
    model_files.format_file(file)
    print(f"{file}: written; next:\n    {console.command('new', 'check')} {file}")
    return 0


def _explain(args: Arguments) -> int:
    page = diagnostics_page()
    if page is None:
        raise errors.UsageError("the page about diagnostics is missing: install robosc again")
    text = section(page.read_text(encoding="utf-8"), args.code)
    if text is None:
        similar = get_close_matches(args.code, codes.CODES, 1)
        hint = f"did you mean {similar[0]!r}?" if similar else "messages show it in brackets"
        raise errors.UsageError(f"no diagnostic has the code {args.code!r}; {hint}")
    print(text)
    return 0


def _synthesize(args: Arguments) -> int:
    from robosc import report
    from robosc.synthesis.documents import synthesize_document

    loaded = pipeline.load(args.model, _options(args))
    console.tell(loaded.diagnostics)
    found: list[Supervisor] = []

    def show(solved: Supervisor) -> None:
        args.progress.clear()
        found.append(solved)
        if not args.json:
            print(report.guards_text(solved), end="", flush=True)

    try:
        supervisor = pipeline.synthesize(
            loaded.robot, args.engine, args.max_states, args.progress, args.explain_seconds, show
        )
    except KeyboardInterrupt:
        if found and args.json:
            _print_json(synthesize_document(found[0]))
        raise
    args.progress.clear()
    # The explanations are part of the result; they are not printed twice.
    explained = {explanation.diagnostic for explanation in supervisor.explanations}
    console.tell(d for d in supervisor.diagnostics if d not in explained)
    _show(args, synthesize_document, report.reasons_text, supervisor)
    if supervisor.empty:
        console.complain(f"no controller can satisfy the requirements of {loaded.robot.name}")
        return errors.EmptySupervisorError.exit_code
    return errors.ModelError.exit_code if errors.has_errors(supervisor.diagnostics) else 0


def _explore(args: Arguments) -> int:
    from robosc import report
    from robosc.synthesis.documents import explore_json

    robot = _load(args)
    graph = pipeline.explore(robot, plant=args.plant, limit=args.limit, progress=args.progress)
    if args.json:
        sys.stdout.writelines(explore_json(graph))
    else:
        print(report.graph_text(graph), end="")
    return 0


def _verify(args: Arguments) -> int:
    from robosc import report
    from robosc.synthesis.documents import step_document
    from robosc.synthesis.verify.verify_report import verify_document

    verified = pipeline.verify(_load(args), args.progress)
    _show(args, lambda r: verify_document(r, step_document), report.verify_text, verified)
    return 0 if verified.verified else 1


def _generate(args: Arguments) -> int:
    from robosc import report

    target, reason = _target(args)
    output = pipeline.Output(target, args.output, args.package, args.force, args.config, args.mode)
    if args.diff:
        text, diagnostics = pipeline.difference(args.model, _options(args), output)
        args.progress.clear()
        console.tell(diagnostics)
        print(text, end="")
        return 1 if text else 0

    def show(solved: Supervisor) -> None:
        args.progress.clear()
        if not solved.empty:
            print(report.sizes(solved), flush=True)

    result = pipeline.generate(args.model, replace(_options(args), solved=show), output)
    args.progress.clear()
    console.tell(result.diagnostics)
    for warning in result.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    print(report.generated_text(result, reason, args.verbose), end="")
    return 0


def _target(args: Arguments) -> tuple[pipeline.Target, str]:
    """The version of ROS to generate for, and why it is this one."""
    if args.target is not None:
        return args.target, "--target"
    if version := os.environ.get("ROS_VERSION"):
        return ("ros2" if version == "2" else "ros1"), f"ROS_VERSION is {version}"
    return "ros1", "ROS_VERSION is not set; --target ros2 for ROS 2"


def _export(args: Arguments) -> int:
    text = pipeline.export(_load(args), args.format, with_supervisor=args.supervisor)
    if args.output is None:
        print(text, end="")
    else:
        model_files.write_text(args.output, text)
    return 0


def _format(args: Arguments) -> int:
    worst = 0
    for path in args.files:
        try:
            if path == "-" or Path(path).is_fifo():
                before, text = model_files.formatted(path)
                changed = before != text
                if not args.check:
                    sys.stdout.buffer.write(text)
                    continue
            else:
                changed = model_files.format_file(path, check=args.check)
        except errors.ModelError as error:
            console.tell(error.diagnostics)
            worst = error.exit_code
            continue
        if changed:
            print(f"{path}: {'would be changed' if args.check else 'changed'}")
            worst = max(worst, int(args.check))
    return worst


def _simulate(args: Arguments) -> int:
    from robosc.simulate.faults import InvalidLine
    from robosc.simulate.script.junit import junit_text
    from robosc.simulate.script.render import Style
    from robosc.simulate.script.run import follow_documents, follow_script, follow_typing
    from robosc.simulate.script.session import Session, read_lines
    from robosc.simulate.script.terminal import line_reader
    from robosc.simulate.start import machine_maker, parameters

    if args.junit is not None and args.script is None:
        raise errors.UsageError(
            "--junit reports the outcome of a script: give it with --script FILE"
        )
    supervisor = _supervise(args)
    try:
        given = parameters(args.parameter)
        session = Session(machine_maker(supervisor, execute=args.execute), given)
        lines = None if args.script is None else read_lines(args.script)
    except InvalidLine as fault:
        raise errors.UsageError(str(fault)) from None
    if lines is not None:
        done = follow_script(session, lines, args.script, sys.stdout, sys.stderr, args.json)
        if args.junit is not None:
            text = junit_text(args.script, supervisor.plant.robot.name, done.cases)
            model_files.write_text(args.junit, text)
        return done.exit_code
    if args.json:
        return follow_documents(session, sys.stdin, sys.stdout)
    next_line = line_reader(session, sys.stdin)
    return follow_typing(session, next_line, sys.stdout, Style(console.in_color(sys.stdout)))


def _replay(args: Arguments) -> int:
    from robosc.simulate.bags.bag_files import is_bag
    from robosc.simulate.replay import replay, replay_document, replay_text

    if Path(args.log).suffix in MODEL_SUFFIXES and Path(args.model).suffix not in MODEL_SUFFIXES:
        args.model, args.log = args.log, args.model  # this order was the only one at first
    if is_bag(args.log):
        return _judge(args)
    if args.junit is not None or args.parameter or args.start or args.remap:
        only = "--junit, --parameter, --start and --remap are for bags: .bag, .mcap, .db3"
        raise errors.UsageError(only)
    replayed = replay(_supervise(args), args.log)
    _show(args, replay_document, replay_text, replayed)
    return replayed.exit_code


def _judge(args: Arguments) -> int:
    from robosc.simulate.bags import judgement_report as told
    from robosc.simulate.bags.bag_files import target_of
    from robosc.simulate.bags.judgement import judge
    from robosc.simulate.start import started

    supervisor = started(_supervise(args, target_of(args.log)), args.start)
    judgement = judge(supervisor, Path(args.log), args.parameter, args.progress, args.remap)
    args.progress.clear()
    if args.junit is not None:
        model_files.write_text(args.junit, told.judgement_junit(judgement))
    _show(args, told.judgement_document, told.judgement_text, judgement)
    return judgement.exit_code


def _report(args: Arguments) -> int:
    from robosc.evidence.document import evidence, format_of, rendered
    from robosc.evidence.runs import recorded_runs
    from robosc.simulate.bags.bag_files import target_of
    from robosc.traces.scripts import chosen, requirement_rows

    suffix = format_of("" if args.output is None else args.output.suffix)
    loaded = pipeline.load(args.model, _options(args))
    supervisor = pipeline.supervise(loaded.robot, args.progress)
    verified = pipeline.verify(supervisor, args.progress)

    @cache
    def judging(target: pipeline.Target | None) -> Supervisor:
        """Judges a bag as replay does: the commands in it may be those of any controller."""
        robot = pipeline.load(args.model, _options(args, of_others=True), target).robot
        return pipeline.supervise(robot, args.progress)

    bags = ((bag, judging(target_of(str(bag)))) for bag in args.bags)
    runs = recorded_runs(supervisor, args.logs, bags, args.progress)
    tests = requirement_rows(supervisor, chosen(supervisor, args.model))
    args.progress.clear()
    warnings = errors.sort_diagnostics(loaded.diagnostics + supervisor.diagnostics)
    text = rendered(evidence(supervisor, verified, runs, tests, warnings, __version__), suffix)
    if args.output is None:
        print(text, end="")
    else:
        model_files.write_text(args.output, text)
    return runs.exit_code if verified.verified else 1


def _lsp(args: Arguments) -> int:
    try:
        import pygls.lsp.server  # noqa: F401
    except ModuleNotFoundError as error:
        raise errors.UsageError(
            f"the language server needs pygls 2, and {sys.executable} has no module"
            f" {error.name!r}: pip install 'pygls>=2,<3', or robosc with its extra, robosc[lsp]"
        ) from error
    from robosc.lsp.server import serve

    serve(__version__, [str(folder) for folder in args.library_path], args.strict)
    return 0


def _mcp(args: Arguments) -> int:
    try:
        import jsonschema  # noqa: F401  # the SDK needs it, too
        import mcp.server.lowlevel  # noqa: F401
    except ModuleNotFoundError as error:
        raise errors.UsageError(
            f"the server for agents needs the official SDK, mcp 2, and {sys.executable} has no"
            f" module {error.name!r}: pip install 'mcp>=2.3,<3', or robosc with its extra,"
            " robosc[mcp]"
        ) from error
    from robosc.agents.start import serve
    from robosc.simulate.faults import InvalidLine
    from robosc.simulate.start import parameters

    supervisor = _supervise(args)
    how = {"port": args.http, "read_only": args.read_only, "log": args.log}
    try:
        serve(supervisor, args.ros, os.environ, parameters(args.parameter), __version__, **how)
    except InvalidLine as fault:
        raise errors.UsageError(str(fault)) from None
    return 0


def _view(args: Arguments) -> int:
    from robosc.view.server import Where

    where = Where(args.host, args.port)
    if args.export is not None and args.log is None:
        raise errors.UsageError("--export writes a recording: give its log with --log FILE")
    if args.ros is not None:
        if args.model is not None:
            raise errors.UsageError("a running node publishes its model itself: leave MODEL out")
        from robosc.view.node import view_node

        view_node(args.ros, where, os.environ, args.operate)
        return 0
    if args.operate is not None or args.model is None:
        raise errors.UsageError(
            "what is to be viewed? Give a MODEL, or --ros NODE (needed by --operate)"
        )
    from robosc.simulate.bags.bag_files import target_of
    from robosc.view.start import export_log, view_log, view_model

    supervisor = _supervise(args, target_of(args.log))
    if args.export is not None:
        model_files.write_text(args.export, export_log(supervisor, args.log))
    elif args.log is not None:
        view_log(supervisor, args.log, where)
    else:
        view_model(supervisor, where, execute=args.execute, given=args.parameter)
    return 0


def _load(args: Arguments, target: pipeline.Target | None = None) -> Robot:
    """The robot of the model; its warnings are shown. ``target``: that of a bag."""
    loaded = pipeline.load(args.model, _options(args, target is not None), target)
    console.tell(loaded.diagnostics)
    return loaded.robot


def _supervise(args: Arguments, target: pipeline.Target | None = None) -> Supervisor:
    supervisor = pipeline.supervise(_load(args, target), args.progress)
    args.progress.clear()
    return supervisor


def _options(args: Arguments, of_others: bool = False) -> pipeline.Options:
    guards = of_others or args.mode == "supervisor"  # commands of any controller
    seconds = getattr(args, "explain_seconds", None)
    return pipeline.Options(tuple(args.library_path), args.strict, guards, args.progress, seconds)


def _show(
    args: Arguments, document: Callable[[Any], Any], text: Callable[[Any], str], result: object
) -> None:
    """Print a result as JSON or as text."""
    _print_json(document(result)) if args.json else print(text(result), end="")


def _print_json(document: object) -> None:
    json.dump(document, sys.stdout, indent=2)
    print()


VERBS = (
    Verb("check", "report all errors and warnings of a model",
         "line_follower.rscd", arguments.check, _check),
    Verb("generate", "write a ROS package with the controller",
         "line_follower.rscd --output ~/catkin_ws/src", arguments.generate, _generate),
    Verb("synthesize", "compute the supervisor: guards, sizes, explanations",
         "line_follower.rscd --json", arguments.synthesize, _synthesize),
    Verb("new", "write a model to begin with: a small one, or one of what runs or was recorded",
         "Rover --from-ros", arguments.new, _new),
    Verb("explain", "tell what the code of a diagnostic means, with an example and the remedy",
         "never-allowed", arguments.explain, _explain),
    Verb("explore", "list the controlled (or uncontrolled) transition system",
         "line_follower.rscd --plant --limit 1000", arguments.explore, _explore),
    Verb("verify", "prove a computed supervisor by independent means",
         "line_follower.rscd", arguments.verify, _verify),
    Verb("export", "write the model for other tools: CIF, a picture, JSON",
         "line_follower.rscd --format svg --output line_follower.svg", arguments.export, _export),
    Verb("format", "give model files their canonical layout",
         "--check *.rscd", arguments.format, _format),
    Verb("simulate", "play the controlled system by hand, by script or at random",
         "line_follower.rscd --execute", arguments.simulate, _simulate),
    Verb("view", "show a robot live in a browser: a model, a running node, an event log",
         "--ros /line_follower_controller", arguments.view, _view),
    Verb("mcp", "let an agent command a robot through its supervisor: a server of the Model Context"
         " Protocol",
         "line_follower.rscd --simulate", arguments.mcp, _mcp),
    Verb("replay", "judge a recorded bag, or the event log of a controller's node, by its model",
         "line_follower.rscd run.bag", arguments.replay, _replay),
    Verb("report", "write evidence: of each requirement what was proved, and what runs show",
         "line_follower.rscd --logs run.jsonl --output evidence.html", arguments.report, _report),
    Verb("lsp", "serve an editor: the language server, on standard input and output",
         "--library-path ~/models/libraries", arguments.lsp, _lsp),
)  # fmt: skip
