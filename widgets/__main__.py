"""``leafscope-gui [FILE …] [--demo]``: the window."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from app import __version__


def main(arguments: Sequence[str] | None = None) -> int:
    """Open the window and stay until it is closed; give the exit code."""
    asked = parse_arguments(arguments)
    from widgets.application import Interrupts, make_application
    from widgets.faults import Faults
    from widgets.main_window import MainWindow
    from widgets.theme import ThemeSwitch

    application = make_application(sys.argv[:1])
    faults = Faults(application)
    faults.watch()
    Interrupts(application)
    window = MainWindow(ThemeSwitch(application), faults)
    window.show()
    if asked.demo:
        window.desk.files.open_demo()
    elif asked.files:
        window.documents.open([Path(name) for name in asked.files])
    code = application.exec()
    window.put_away()
    return code


def parse_arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line; ends the program on --help and on mistakes."""
    parser = argparse.ArgumentParser("leafscope-gui", description="Laser scans of leaves.")
    parser.add_argument("files", nargs="*", metavar="FILE", help="scans, or a session")
    parser.add_argument("--demo", action="store_true", help="open the demo scan")
    parser.add_argument("--version", action="version", version=f"Leafscope {__version__}")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
