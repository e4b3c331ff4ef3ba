"""The rows of the table of actions, menu by menu."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication

from widgets.actions import Row
from widgets.desk import Desk


def has_scan(desk: Desk) -> bool:
    """There is a scan to work on."""
    return desk.has_scan


def list_rows() -> tuple[Row, ...]:
    """Every action of the window."""
    return (
        *_file_rows(),
        *_edit_rows(),
        *_scan_rows(),
        *_tool_rows(),
        *_view_rows(),
        *_theme_rows(),
        *_help_rows(),
    )


def tr(text: str) -> str:
    """The text in the user's language."""
    return QCoreApplication.translate("Actions", text)


def _file_rows() -> tuple[Row, ...]:
    return (
        Row("file.new", tr("&New session"), lambda desk, _: desk.files.new(), "file",
            ("Ctrl+N",), "ph.file-plus"),
        Row("file.open", tr("&Open…"), lambda desk, _: desk.files.open(), "file",
            ("Ctrl+O",), "ph.folder-open", bar="file", tip=tr("Open scans or a session")),
        Row("file.series", tr("Open a &folder as series…"),
            lambda desk, _: desk.series.open_folder(), "file", icon="ph.stack",
            tip=tr("Scans of the same leaves at other angles or times, from one folder")),
        Row("file.demo", tr("Open the &demo"), lambda desk, _: desk.files.open_demo(), "file",
            icon="ph.tree", tip=tr("A simulated branch of leaves to try things on")),
        Row("file.simulate", tr("S&imulate a scan…"), lambda desk, _: desk.files.simulate(), "file",
            icon="ph.broadcast", tip=tr("Scan a made-up scene, of which everything is known")),
        Row("file.save", tr("&Save session"), lambda desk, _: desk.files.save(), "file",
            ("Ctrl+S",), "ph.floppy-disk", section=1, bar="file", enabled=has_scan),
        Row("file.save_as", tr("Save session &as…"), lambda desk, _: desk.files.save_as(), "file",
            ("Ctrl+Shift+S",), section=1, enabled=has_scan),
        Row("file.export", tr("&Export points…"), lambda desk, _: desk.files.export(), "file",
            ("Ctrl+E",), "ph.export", section=1, enabled=has_scan,
            tip=tr("Write points and fields of the current scan")),
        Row("file.export_mesh", tr("Export leaf &mesh…"), lambda desk, _: desk.scans.export_mesh(),
            "file", section=1, enabled=lambda d: d.has_leaves,
            tip=tr("Write the triangles of the chosen leaves, or of all, as PLY, OBJ or STL")),
        Row("file.close_scan", tr("&Close scan"), lambda desk, _: desk.files.close_scan(), "file",
            ("Ctrl+W",), section=2, enabled=has_scan),
        Row("file.quit", tr("&Quit"), lambda desk, _: desk.files.quit(), "file",
            ("Ctrl+Q",), section=2),
    )  # fmt: skip


def _edit_rows() -> tuple[Row, ...]:
    def selected(desk: Desk) -> bool:
        return desk.has_selection

    return (
        Row("edit.undo", tr("&Undo"), lambda desk, _: desk.controller.undo(), "edit",
            ("Ctrl+Z",), "ph.arrow-u-up-left", bar="history", enabled=lambda d: d.can_undo),
        Row("edit.redo", tr("&Redo"), lambda desk, _: desk.controller.redo(), "edit",
            ("Ctrl+Shift+Z", "Ctrl+Y"), "ph.arrow-u-up-right", bar="history",
            enabled=lambda d: d.can_redo),
        Row("edit.invert", tr("&Invert selection"), lambda desk, _: desk.scans.invert_selection(),
            "edit", ("Ctrl+I",), "ph.selection-inverse", section=1, enabled=has_scan),
        Row("edit.clear", tr("&Clear selection"), lambda desk, _: desk.scans.clear_selection(),
            "edit", ("Ctrl+D",), "ph.selection-slash", section=1, enabled=selected),
        Row("edit.delete", tr("&Delete selected points"),
            lambda desk, _: desk.scans.delete_selection(), "edit", ("Del",), "ph.trash",
            section=2, enabled=selected, tip=tr("Hide the points for good; undo brings them back")),
        Row("edit.bring_back", tr("&Bring deleted points back"),
            lambda desk, _: desk.scans.bring_back(), "edit", section=2,
            enabled=lambda d: d.has_deleted),
    )  # fmt: skip


def _scan_rows() -> tuple[Row, ...]:
    return (
        Row("scan.origin", tr("&Scanner position…"), lambda desk, _: desk.scans.set_origin(),
            "scan", icon="ph.map-pin", enabled=has_scan,
            tip=tr("Range, incidence angle and ghosts need to know where the scanner stood")),
        Row("scan.channel", tr("&Name a channel…"), lambda desk, _: desk.scans.name_channel(),
            "scan", icon="ph.activity", enabled=has_scan,
            tip=tr("Say which values are an intensity, and at which wavelength")),
        Row("scan.columns", tr("&Columns of the text file…"),
            lambda desk, _: desk.scans.name_columns(), "scan", icon="ph.columns",
            enabled=lambda d: d.has_text, tip=tr("Correct how the columns were guessed")),
        Row("scan.angles", tr("&Incidence angles"), lambda desk, _: desk.views.show_panel("angles"),
            "scan", ("A",), "mdi6.angle-acute", section=1, enabled=has_scan,
            tip=tr("Radius, estimator and beam; how neighbours were found, and how good angles "
                   "are")),
        Row("scan.calibrate", tr("Calib&rate…"),
            lambda desk, _: desk.views.show_panel("calibration"), "scan", ("K",), "ph.scales",
            section=1, enabled=has_scan,
            tip=tr("Turn raw numbers into reflectance by a profile; make one from panels")),
        Row("scan.correct", tr("C&orrect for the angle"),
            lambda desk, _: desk.views.show_panel("correct"), "scan", section=1, enabled=has_scan,
            tip=tr("Workflows WF1, WF2 and WF3 side by side; corrected channels")),
        Row("scan.index", tr("In&dices"), lambda desk, _: desk.views.show_panel("index"), "scan",
            section=1, enabled=has_scan,
            tip=tr("An index against the angle, and against the size of the footprint")),
        Row("scan.plan", tr("&Plan a scan"), lambda desk, _: desk.views.show_panel("planner"),
            "scan", section=1,
            tip=tr("Footprint, points and ghosts to be expected on a leaf; the largest angle")),
        Row("scan.own_indices", tr("O&wn indices…"), lambda desk, _: desk.scans.write_indices(),
            "scan", section=1, enabled=has_scan,
            tip=tr("Write an index of your own as a formula over channels or wavelengths")),
        Row("scan.find_leaves", tr("&Find leaves"), lambda desk, _: desk.scans.find_leaves(),
            "scan", icon="ph.leaf", section=1, enabled=has_scan,
            tip=tr("Part the whole scan into leaves by what hangs together")),
        Row("scan.split_leaf", tr("Spli&t the leaf…"), lambda desk, _: desk.scans.split_leaf(),
            "scan", section=1, enabled=lambda d: d.has_leaves,
            tip=tr("Make several leaves of the chosen one by clicking a point on each")),
        Row("scan.merge_leaves", tr("Mer&ge the leaves"), lambda desk, _: desk.scans.merge_leaves(),
            "scan", section=1, enabled=lambda d: d.has_leaves,
            tip=tr("Make one leaf of those chosen in the table of leaves")),
        Row("scan.make_leaf", tr("&Make the selection a leaf"),
            lambda desk, _: desk.scans.make_leaf(), "scan", ("M",), section=1,
            enabled=lambda d: d.has_selection),
        Row("scan.next_leaf", tr("N&ext leaf"), lambda desk, _: desk.scans.next_leaf(), "scan",
            ("N",), section=1, enabled=has_scan,
            tip=tr("Begin a fresh leaf: the next lasso makes one")),
    )  # fmt: skip


def _tool_rows() -> tuple[Row, ...]:
    return (
        Row("tool.navigate", tr("&Navigate"), lambda desk, _: desk.tools.arm("navigate"), "tools",
            icon="ph.hand-grabbing", bar="tool", group="tool",
            checked=lambda d: d.tools.tool == "navigate",
            tip=tr("Turn, move and zoom with the mouse (Esc)")),
        Row("tool.lasso", tr("&Lasso"), lambda desk, _: desk.tools.arm("lasso"), "tools",
            ("L",), "mdi6.lasso", bar="tool", group="tool", enabled=has_scan,
            checked=lambda d: d.tools.tool == "lasso",
            tip=tr("Draw around points; Shift adds, Ctrl or Alt takes away")),
        Row("tool.rectangle", tr("&Rectangle"), lambda desk, _: desk.tools.arm("rectangle"),
            "tools", ("R",), "ph.selection-plus", bar="tool", group="tool", enabled=has_scan,
            checked=lambda d: d.tools.tool == "rectangle",
            tip=tr("Pull a rectangle over points; what the lasso does, it does too")),
        Row("tool.pick", tr("&Pick a point"), lambda desk, _: desk.tools.arm("pick"), "tools",
            ("P",), "ph.crosshair", tr("Pick"), bar="tool", group="tool", enabled=has_scan,
            checked=lambda d: d.tools.tool == "pick", tip=tr("Show the values of a point")),
        Row("lasso.select", tr("Lasso &selects"), lambda desk, _: desk.tools.use_lasso_to("select"),
            "tools", ("Ctrl+1",), "ph.selection", tr("Select"), section=1, bar="purpose",
            group="purpose", enabled=has_scan, checked=lambda d: d.tools.purpose == "select",
            tip=tr("The lasso selects points")),
        Row("lasso.leaf", tr("Lasso makes a l&eaf"),
            lambda desk, _: desk.tools.use_lasso_to("leaf"), "tools", ("Ctrl+2",), "ph.leaf",
            tr("Leaf"), section=1, bar="purpose", group="purpose", enabled=has_scan,
            checked=lambda d: d.tools.purpose == "leaf",
            tip=tr("Each lasso makes a leaf; Shift adds to the current one")),
        Row("lasso.ghost", tr("Lasso marks &ghosts"),
            lambda desk, _: desk.tools.use_lasso_to("ghost"), "tools", ("Ctrl+3",), "ph.ghost",
            tr("Ghost"), section=1, bar="purpose", group="purpose", enabled=has_scan,
            checked=lambda d: d.tools.purpose == "ghost",
            tip=tr("The lasso marks ghost points; Ctrl takes the mark away")),
        Row("lasso.delete", tr("Lasso &deletes"), lambda desk, _: desk.tools.use_lasso_to("delete"),
            "tools", ("Ctrl+4",), "ph.trash", tr("Delete"), section=1, bar="purpose",
            group="purpose", enabled=has_scan, checked=lambda d: d.tools.purpose == "delete",
            tip=tr("The lasso deletes points; undo brings them back")),
        Row("reach.visible", tr("&Visible points only"),
            lambda desk, _: desk.tools.reach("visible"), "tools", icon="ph.eye",
            short=tr("Visible"), section=2, bar="reach", group="reach", enabled=has_scan,
            checked=lambda d: d.tools.mode == "visible",
            tip=tr("The lasso takes only what nothing hides (V switches)")),
        Row("reach.through", tr("&Through everything"),
            lambda desk, _: desk.tools.reach("through"), "tools", icon="ph.stack",
            short=tr("Through"), section=2, bar="reach", group="reach", enabled=has_scan,
            checked=lambda d: d.tools.mode == "through",
            tip=tr("The lasso also takes what lies behind (V switches)")),
        Row("reach.toggle", tr("S&witch visible and through"),
            lambda desk, _: desk.tools.toggle_reach(), "tools", ("V",), section=2,
            enabled=has_scan),
    )  # fmt: skip


def _view_rows() -> tuple[Row, ...]:
    return (
        Row("view.fit_all", tr("Show &everything"), lambda desk, _: desk.picture.fit_all(), "view",
            ("Home",), "ph.corners-out", bar="look", enabled=has_scan),
        Row("view.fit", tr("&Fit the selection"), lambda desk, _: desk.picture.fit_selection(),
            "view", ("F",), "ph.frame-corners", enabled=has_scan,
            tip=tr("Show the selection, else the current leaf, else everything")),
        Row("view.scanner", tr("From the &scanner"),
            lambda desk, _: desk.picture.look_from_scanner(), "view", ("Ctrl+Home",),
            "ph.aperture", bar="look", enabled=lambda d: d.has_pose,
            tip=tr("Look from where the scanner stood")),
        Row("view.top", tr("From &above"), lambda desk, _: desk.picture.look_from("top"), "view",
            ("8",), enabled=has_scan),
        Row("view.front", tr("From the f&ront"), lambda desk, _: desk.picture.look_from("front"),
            "view", ("5",), enabled=has_scan),
        Row("view.ortho", tr("&Orthographic"),
            lambda desk, on: desk.picture.set_orthographic(on), "view", ("O",), "ph.cube",
            bar="look", enabled=has_scan, checked=lambda d: d.picture.orthographic,
            tip=tr("Without perspective: equal lengths look equal")),
        Row("view.scan_image", tr("S&can image"),
            lambda desk, on: desk.views.set_shown("scan_image", on), "view", ("I",),
            "mdi6.panorama-variant-outline", bar="look",
            checked=lambda d: d.views.is_shown("scan_image"),
            tip=tr("What the scanner saw as a picture: azimuth to the right, elevation upwards")),
        Row("view.leaves", tr("Colour lea&ves"),
            lambda desk, on: desk.controller.look(show_leaves=on), "view", section=1,
            checked=lambda d: d.controller.view.show_leaves),
        Row("view.ghosts", tr("Show &ghost marks"),
            lambda desk, on: desk.controller.look(show_ghosts=on), "view", section=1,
            checked=lambda d: d.controller.view.show_ghosts),
        Row("view.footprints", tr("Show foot&prints"),
            lambda desk, on: desk.controller.look(show_footprints=on), "view", section=1,
            enabled=has_scan, checked=lambda d: d.controller.view.show_footprints,
            tip=tr("Draw the beam at true scale where it meets selected points or the leaf")),
        Row("view.mesh", tr("Show leaf mes&h"),
            lambda desk, on: desk.controller.look(show_mesh=on), "view", section=1,
            enabled=has_scan, checked=lambda d: d.controller.view.show_mesh,
            tip=tr("Draw the triangles of the current leaf, coloured by ω from 0° to 90°")),
        Row("view.larger", tr("&Larger points"), lambda desk, _: desk.views.scale_points(1),
            "view", ("]",), section=1, enabled=has_scan),
        Row("view.smaller", tr("S&maller points"), lambda desk, _: desk.views.scale_points(-1),
            "view", ("[",), section=1, enabled=has_scan),
        Row("view.full_screen", tr("F&ull screen"),
            lambda desk, _: desk.views.toggle_full_screen(), "view", ("F11",), section=3),
        Row("view.reset_layout", tr("Rese&t layout"), lambda desk, _: desk.views.reset_layout(),
            "view", section=3, tip=tr("Put every panel back to its place")),
    )  # fmt: skip


def _theme_rows() -> tuple[Row, ...]:
    return (
        Row("theme.system", tr("Theme of the s&ystem"),
            lambda desk, _: desk.views.choose_theme("system"), "view", section=2, group="theme",
            checked=lambda d: d.views.theme == "system"),
        Row("theme.light", tr("L&ight theme"), lambda desk, _: desk.views.choose_theme("light"),
            "view", icon="ph.sun", section=2, group="theme",
            checked=lambda d: d.views.theme == "light"),
        Row("theme.dark", tr("&Dark theme"), lambda desk, _: desk.views.choose_theme("dark"),
            "view", icon="ph.moon", section=2, group="theme",
            checked=lambda d: d.views.theme == "dark"),
    )  # fmt: skip


def _help_rows() -> tuple[Row, ...]:
    return (
        Row("help.guide", tr("&Guide"), lambda desk, _: desk.views.show_guide(), "help",
            ("F1",), "ph.book-open"),
        Row("help.keys", tr("&Keyboard and mouse"), lambda desk, _: desk.views.show_shortcuts(),
            "help", ("?",), "ph.keyboard"),
        Row("help.about", tr("&About Leafscope"), lambda desk, _: desk.views.show_about(), "help",
            section=1),
    )  # fmt: skip
