"""What draws on the page: strokes, rectangles, points and labels by name, in the coordinates of arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..camera import Camera
from ..geometry.hit_places import Float64Array
from .scene_frame import SIDE, SceneFrame
from .tone_curve import light_for

#: The size of points on the page.
POINT = 0.012 * SIDE


class Stage:
    """The scene of a server of viser.

    Parameters
    ----------
    server : viser.ViserServer
    frame : SceneFrame
    """

    def __init__(self, server: Any, frame: SceneFrame) -> None:
        self.frame = frame
        self._server, self._scene = server, server.scene
        self._shown: dict[str, Any] = {}
        server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False)
        self._scene.world_axes.visible = False

    def atomic(self) -> Any:
        """Return a context whose changes appear at once."""
        return self._server.atomic()

    def flush(self) -> None:
        """Send what has been drawn at once, as a slider that moves wants it."""
        self._server.flush()

    def place(self, name: str, at: Float64Array) -> None:
        """Put a group of names, such as "/0", at a place of the page."""
        place = tuple(at.tolist())
        if name in self._shown:
            self._shown[name].position = place
        else:
            self._shown[name] = self._scene.add_frame(name, show_axes=False, position=place)

    def strokes(self, name: str, ends: npt.NDArray[np.floating], colors: npt.ArrayLike, width: float) -> None:
        """Draw strokes (n, 2, 3) in colours (n, 2, 3), (n, 3) or (3,), linear; hide the name if there are none."""
        if not len(ends):
            return self.hide(name)
        light = light_for(colors)
        if light.ndim == 2:
            light = light[:, None]
        light = np.broadcast_to(light, ends.shape)
        points = self.frame.to_page(ends).astype(np.float32)
        self._shown[name] = self._scene.add_line_segments(
            name, points, light, thickness=width, thickness_units="screen"
        )
        return None

    def faces(self, name: str, corners: Float64Array, color: tuple[int, int, int], opacity: float) -> None:
        """Draw rectangles (n, 4, 3), which are seen through; hide the name if there are none."""
        if not len(corners):
            return self.hide(name)
        faces = 4 * np.arange(len(corners))[:, None] + np.array([[0, 1, 2, 0, 2, 3]])
        self._shown[name] = self._scene.add_mesh_simple(
            name,
            self.frame.to_page(corners.reshape(-1, 3)).astype(np.float32),
            faces.reshape(-1, 3).astype(np.uint32),
            color=color,
            opacity=opacity,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )
        return None

    def points(self, name: str, points: Float64Array, colors: npt.ArrayLike) -> None:
        """Draw points (n, 3); hide the name if there are none."""
        if not len(points):
            return self.hide(name)
        light = np.broadcast_to(light_for(colors), points.shape)
        self._shown[name] = self._scene.add_point_cloud(
            name,
            self.frame.to_page(points).astype(np.float32),
            light,
            point_size=POINT,
            point_shape="circle",
            precision="float32",
        )
        return None

    def label(self, name: str, text: str, at: Float64Array) -> None:
        """Write a text at a point."""
        place = tuple(self.frame.to_page(at).tolist())
        self._shown[name] = self._scene.add_label(name, text, position=place, anchor="bottom-center")

    def hide(self, name: str) -> None:
        """Take away what has a name, and all whose names begin with it and a slash."""
        for each in [each for each in self._shown if each == name or each.startswith(f"{name}/")][::-1]:
            self._shown.pop(each)
            if self._scene.get_handle_by_name(each) is not None:
                self._scene.remove_by_name(each)

    def look(self, camera: Camera) -> None:
        """Choose the camera of browsers, those that are there and those that come; its coordinates are the page's."""
        up = camera.up
        self._scene.set_up_direction(up)
        first = self._server.initial_camera
        first.up, first.position, first.look_at = up, camera.origin, camera.target
        first.fov = float(np.radians(camera.fov_degrees))
        first.far = 100 * SIDE
        for client in self._server.get_clients().values():
            client.camera.up_direction = up
            client.camera.position, client.camera.look_at = camera.origin, camera.target
