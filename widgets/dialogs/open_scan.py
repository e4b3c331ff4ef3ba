"""File dialogs: which files, and where to; the last folder is remembered."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QWidget

from app.formats.session import SUFFIX

FAMILIES = (
    ("LAS, LAZ", ("las", "laz")),
    ("E57", ("e57",)),
    ("PTX", ("ptx",)),
    ("PLY", ("ply",)),
    ("PCD", ("pcd",)),
    ("Text", ("xyz", "txt", "csv", "asc", "pts")),
)
Mode = QFileDialog.FileMode


class FileDialogs(QObject):
    """Asks for files; `folder` is where the last one was."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self.folder = Path.home()

    def ask_open(self, then: Callable[[list[Path]], object], parent: QWidget | None = None) -> None:
        """Ask for scans or a session."""
        dialog = self._dialog(self.tr("Open scans"), list_filters(), parent)
        dialog.setFileMode(Mode.ExistingFiles)

        def take(names: list[str]) -> None:
            paths = [Path(name) for name in names]
            self.folder = paths[0].parent
            then(paths)

        dialog.filesSelected.connect(take)
        dialog.open()

    def ask_scene(self, then: Callable[[Path], object], parent: QWidget | None = None) -> None:
        """Ask for a scene to simulate."""
        self.ask_file(self.tr("A scene to simulate"), ".toml", then, parent)

    def ask_file(
        self,
        title: str,
        suffix: str,
        then: Callable[[Path], object],
        parent: QWidget | None = None,
    ) -> None:
        """Ask for one file that exists."""
        dialog = self._dialog(title, [f"{suffix[1:].upper()} (*{suffix})"], parent)
        dialog.setFileMode(Mode.ExistingFile)

        def take(name: str) -> None:
            self.folder = Path(name).parent
            then(Path(name))

        dialog.fileSelected.connect(take)
        dialog.open()

    def ask_folder(
        self, title: str, then: Callable[[Path], object], parent: QWidget | None = None
    ) -> None:
        """Ask for a folder that exists."""
        dialog = self._dialog(title, [], parent)
        dialog.setFileMode(Mode.Directory)
        dialog.setOption(QFileDialog.Option.ShowDirsOnly)

        def take(name: str) -> None:
            self.folder = Path(name)
            then(self.folder)

        dialog.fileSelected.connect(take)
        dialog.open()

    def ask_save(
        self, suggested: Path, then: Callable[[Path], object], parent: QWidget | None = None
    ) -> None:
        """Ask where to save; the dialog asks about an existing file."""
        suffix = suggested.suffix
        dialog = self._dialog(self.tr("Save"), [f"{suffix[1:].upper()} (*{suffix})"], parent)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setFileMode(Mode.AnyFile)
        dialog.setDefaultSuffix(suffix[1:])
        dialog.selectFile(str(suggested))

        def take(name: str) -> None:
            self.folder = Path(name).parent
            then(Path(name))

        dialog.fileSelected.connect(take)
        dialog.open()

    def _dialog(self, title: str, filters: list[str], parent: QWidget | None = None) -> QFileDialog:
        dialog = QFileDialog(parent or self._window, title, str(self.folder))
        dialog.setObjectName("files")
        dialog.setOption(QFileDialog.Option.HideNameFilterDetails)
        dialog.setNameFilters(filters)
        dialog.finished.connect(dialog.deleteLater)
        return dialog


def list_filters() -> list[str]:
    """Filters of the open dialog, all scans first."""
    suffixes = [suffix for _, family in FAMILIES for suffix in family]
    session = SUFFIX[1:]
    return [
        f"All scans and sessions ({_globs((*suffixes, session))})",
        *(f"{name} ({_globs(family)})" for name, family in FAMILIES),
        f"Leafscope session ({_globs((session,))})",
        "All files (*)",
    ]


def _globs(suffixes: tuple[str, ...]) -> str:
    # Linux tells large from small letters, and instruments write both.
    return " ".join(f"*.{s} *.{s.upper()}" for s in suffixes)
