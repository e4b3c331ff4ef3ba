"""The command line. `main` is the program; nothing heavy is loaded until a command runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from app.core.errors import BadInput, Cancelled, LeafscopeError, WrongUse


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command and leave with its exit code: 0, 2 wrong use, 3 bad input, 4 cancelled.

    141, as of every program, where nobody reads the output any more.
    """
    from app.cli.console import cancel_on_signals

    words = list(sys.argv[1:] if arguments is None else arguments)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")  # type: ignore[union-attr]
    debug = "--debug" in words
    try:
        cancel_on_signals()
        code = run([word for word in words if word != "--debug"], debug)
    except Cancelled as error:  # between two steps, where `run` does not catch it
        code = _fail(error, debug)
    sys.exit(code)


def run(words: Sequence[str], debug: bool = False) -> int:
    """Run a command and give its exit code; errors are one sentence on the error stream."""
    from cyclopts import CycloptsError

    from app.cli.commands import leafscope
    from app.cli.console import STOP

    try:
        leafscope(words, exit_on_error=False, print_error=False, result_action="return_value")
        sys.stdout.flush()
    except CycloptsError as error:
        return _fail(WrongUse(" ".join(str(error).split()), "See leafscope --help."), debug)
    except LeafscopeError as error:
        return _fail(error, debug)
    except KeyboardInterrupt:
        return _fail(Cancelled(), debug)
    except MemoryError:
        return _fail(BadInput("There is not enough memory.", "Try --every-nth 10."), debug)
    except BrokenPipeError:
        return _leave_quietly()
    except OSError as error:
        return _fail(BadInput(f"{error.filename or 'A file'}: {error.strerror or error}."), debug)
    except Exception as error:  # noqa: BLE001 - a fault of ours: told in a sentence, never lost
        if STOP.asked():  # the compiler, stopped in the middle, ends in faults of its own
            return _fail(Cancelled(), debug)
        what = f"Leafscope failed: {type(error).__name__}: {error}."
        return _fail(LeafscopeError(" ".join(what.split()), "Run it with --debug."), debug)
    return 0


def _leave_quietly() -> int:
    """End as the shell expects it where nobody reads the output any more (`| head`)."""
    # Python writes what is left when it ends, and would complain then.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 128 + 13  # SIGPIPE, which Windows does not know


def _fail(error: LeafscopeError, debug: bool) -> int:
    if debug:
        import traceback

        traceback.print_exc()
    from app.cli.console import LINE

    LINE.wipe()
    print(f"leafscope: {error}", file=sys.stderr)
    return error.exit_code
