"""Between the controller and the 3-D view: scenes go one way, gestures come back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from PySide6.QtCore import QObject

from app.model.events import EVERYTHING, Change
from app.model.project import Project
from app.model.scene import Scene, resolve
from app.model.view_state import ColourRange, ViewState
from widgets.controller import Controller
from widgets.leaf_work import Combine, LeafWork
from widgets.picking import Picker
from widgets.theme import ThemeSwitch
from widgets.tools import Tools

if TYPE_CHECKING:
    from widgets.viewport.view3d import View3D

StandardView = Literal["top", "front", "right", "iso"]


class Picture(QObject):
    """Serves the 3-D view; does nothing as long as there is none."""

    def __init__(
        self,
        controller: Controller,
        work: LeafWork,
        tools: Tools,
        theme: ThemeSwitch,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._controller, self._work, self._tools, self._theme = controller, work, tools, theme
        self.picker = Picker(controller, self)
        self.view: View3D | None = None
        self._kept: object = None
        self._instead: Project | None = None
        self._shown = False
        self._there: set[str] = set()
        self._leaves = 0
        self._revealed_over: str | None = None
        controller.document_changed.connect(self._reveal_leaves)
        controller.view_changed.connect(self._give_way)

    def attach(self, view: View3D) -> None:
        """Take a view into service."""
        self.view = view
        view.lasso_finished.connect(self._lasso)
        view.picked.connect(self._pick)
        view.limits_changed.connect(self._limit)
        view.tool_changed.connect(self._follow_view)
        self._controller.scene_changed.connect(self._show)
        self._tools.changed.connect(self._follow_tools)
        self._theme.changed.connect(self._dye)
        self._dye(self._theme.dark)
        self._follow_tools()
        self._show(self._controller.scene)

    def detach(self) -> None:
        """Close the view, which must go before its window."""
        view, self.view = self.view, None
        if view is None:
            return
        self._controller.scene_changed.disconnect(self._show)
        self._tools.changed.disconnect(self._follow_tools)
        self._theme.changed.disconnect(self._dye)
        view.close()

    def show_instead(self, project: Project | None) -> None:
        """Show another document of the same scans, to try something out; None: the true one."""
        if project is not self._instead:
            self._instead = project
            self._show(self._controller.scene)

    # Camera

    def fit_all(self) -> None:
        """Show everything."""
        if self.view is not None:
            self.view.fit_all()

    def fit_selection(self) -> None:
        """Show the selection, else the current leaf, else everything."""
        state = self._controller.scan
        if self.view is None or state is None:
            return
        leaf = self._controller.project.state.leaves.get(self._controller.view.leaf or "")
        points = state.selection
        if len(points) == 0 and leaf is not None and leaf.scan == self._controller.current:
            points = leaf.members
        if len(points):
            self.view.fit(state.scan.xyz[points.indices[state.alive[points.indices]]])
        else:
            self.view.fit_all()

    def look_from_scanner(self) -> None:
        """Show what the scanner saw."""
        state = self._controller.scan
        if self.view is not None and state is not None and state.scan.pose is not None:
            self.view.view_from(np.array(state.scan.pose.position))

    def look_from(self, name: StandardView) -> None:
        """One of the standard views."""
        if self.view is not None:
            self.view.view_standard(name)

    @property
    def orthographic(self) -> bool:
        """Whether the picture has no perspective."""
        return self.view is not None and self.view.camera().parallel_scale is not None

    def set_orthographic(self, on: bool) -> None:
        """Switch between orthographic and perspective."""
        if self.view is not None:
            self.view.set_orthographic(on)

    def keep_camera(self) -> None:
        """Write the camera into the view state, for the session file."""
        if self.view is not None and self._controller.scene.clouds:
            camera = self.view.camera()
            self._kept = (camera.position, camera.focal_point, camera.view_up)
            self._controller.look(
                camera=self._kept,
                view_angle=camera.view_angle,
                parallel_scale=camera.parallel_scale,
            )

    def _show(self, scene: Scene) -> None:
        from app.render.camera import Camera
        from app.render.picture import ProjectSource

        if self.view is None:
            return
        shown = self._instead or self._controller.project
        if self._instead is not None:
            scene = resolve(shown, self._controller.view)
        state, first = self._controller.view, bool(scene.clouds) and not self._shown
        there = {cloud.scan for cloud in scene.clouds}
        joined = bool(there - self._there)
        # A scan that was only hidden comes back to where the camera is.
        kept = self._there & self._controller.project.state.scans.keys()
        self._there = there | kept
        self._shown = bool(scene.clouds)
        if not self._shown:
            self._kept = None  # what comes next brings a camera of its own
        self.view.show_scene(scene, ProjectSource(shown, state))
        if scene.clouds and state.camera is not None and state.camera != self._kept:
            # A session brought its camera along.
            self._kept = state.camera
            position, focus, up = state.camera
            camera = Camera(position, focus, up, state.view_angle, state.parallel_scale)
            self.view.set_camera(camera)
        elif first:
            # A scan looks familiar from where it was made.
            self.look_from_scanner()
        elif joined:
            self.view.fit_all()  # a scan that came later may lie anywhere

    def _reveal_leaves(self, change: Change) -> None:
        """Show leaves in the picture when there are some for the first time."""
        before, self._leaves = self._leaves, len(self._controller.project.state.leaves)
        view = self._controller.view
        if change != EVERYTHING and before == 0 < self._leaves and not view.show_leaves:
            self._revealed_over = view.colour
            self._controller.look(show_leaves=True)

    def _give_way(self, view: ViewState) -> None:
        """Who asks for other colours wants to see them, and not leaves that came by themselves."""
        over = self._revealed_over
        if over is not None and view.colour != over:
            self._revealed_over = None
            self._controller.look(show_leaves=False)

    # Gestures

    def _lasso(self, corners: list[tuple[float, float]], combine: Combine) -> None:
        if self.view is not None:
            tools = self._tools
            self._work.lasso(self.view.current_view(), corners, tools.mode, tools.purpose, combine)

    def _pick(self, x: float, y: float) -> None:
        if self.view is not None:
            self.picker.pick(self.view.current_view(), x, y, self.view.devicePixelRatioF())

    def _limit(self, low: float, high: float, finished: bool) -> None:
        view = self._controller.view
        if finished and view.colour:
            ranges = {**view.ranges, view.colour: ColourRange(low, high)}
            self._controller.look(ranges=ranges)

    # What the view follows

    def _follow_tools(self) -> None:
        if self.view is not None:
            self.view.set_tool(self._tools.tool)

    def _follow_view(self, name: str) -> None:
        # The view puts a tool away by itself when Escape is pressed in it.
        if name != self._tools.tool and name == "navigate":
            self._tools.arm("navigate")

    def _dye(self, dark: bool) -> None:
        if self.view is not None:
            self.view.set_background("dark" if dark else "light")
