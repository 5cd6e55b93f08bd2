# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The scene in the browsers, drawn by viser."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from stitchmesh.app.browser.bridge import Bridge, colour_script
from stitchmesh.app.scene.drawing import (
    Arrows,
    Colour,
    Colours,
    Copies,
    Drawing,
    Labels,
    Lines,
    Surface,
    YarnTubes,
    shows_nothing,
)
from stitchmesh.app.scene.levels_of_detail import add_tubes, update_tubes
from stitchmesh.app.scene.scene import CameraView, Modifier, Stroke, ViewName
from stitchmesh.errors import DisplayError
from stitchmesh.mesh import FloatArray
from stitchmesh.mesh.palette import linear_colour

FIELD_OF_VIEW = np.radians(35.0)
"""Vertical field of view; it is small, so that a garment is hardly distorted."""
MARGIN = 1.12
"""Size of the window over the size of the visible box."""
VIEWS: dict[ViewName, tuple[float, float, float]] = {
    "front": (0.0, 0.06, 1.0), "back": (0.0, 0.06, -1.0), "left": (-1.0, 0.06, 0.0), "right": (1.0, 0.06, 0.0),
    "top": (0.0, 1.0, 0.01),
}  # fmt: skip
"""Direction from the object to the camera, for each view."""


@dataclass(eq=False)
class _Shown:
    """A drawing, the nodes of viser that show it, and viser's name of the first node."""

    drawing: Drawing
    nodes: list[Any]
    node_name: str


class ViserScene:
    """A ``DrawingScene`` in the browsers."""

    def __init__(self, server: viser.ViserServer, bridge: Bridge, on_stroke: Callable[[Stroke], None]) -> None:
        """Set up light and camera; the thread of the server calls ``on_stroke``."""
        self._server, self._bridge, self._on_stroke = server, bridge, on_stroke
        self._shown: dict[str, _Shown] = {}
        self._made = 0
        server.scene.set_up_direction("+y")
        _light(server)
        server.initial_camera.fov = float(FIELD_OF_VIEW)
        self._box: tuple[FloatArray, FloatArray, ViewName] | None = None
        self._placed: dict[int, tuple[float, FloatArray]] = {}
        bridge.on_connect(self._colour_all)
        bridge.on_connect(self._place_camera)

    def show(self, name: str, drawing: Drawing | None) -> None:
        """Draw under a name; see ``DrawingScene``."""
        if drawing is None or shows_nothing(drawing):
            self.remove(name)
            return
        before = self._shown.get(name)
        if before is not None and self._updated(before, drawing):
            before.drawing = drawing
            return
        with self._server.atomic():
            self.remove(name)
            self._made += 1
            node_name = f"/{name}/{self._made}"
            self._shown[name] = _Shown(drawing, self._add(node_name, drawing), node_name)
        self._send_colours(self._shown[name])

    def remove(self, name: str) -> None:
        """Remove the drawing under a name."""
        shown = self._shown.pop(name, None)
        for node in shown.nodes if shown is not None else ():
            node.remove()

    def clear(self) -> None:
        """Remove all drawings."""
        with self._server.atomic():
            for name in list(self._shown):
                self.remove(name)

    def look_at(self, low: FloatArray, high: FloatArray, view: ViewName | None = None) -> None:
        """Show a box; see ``DrawingScene``."""
        box = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
        if view is None and self._box is not None and _are_alike(box, self._box[:2]):
            return
        self._box = *box, view or "front"
        for client in self._server.get_clients().values():
            self._place_camera(client)

    def fit_again(self, client: viser.ClientHandle) -> None:
        """Place the camera of a browser again if the shape of its window has changed, unless the user has moved it."""
        aspect, position = self._placed.get(client.client_id, (client.camera.aspect, None))
        reshaped = abs(client.camera.aspect / aspect - 1.0) > 0.02
        if reshaped and position is not None and np.allclose(client.camera.position, position, rtol=1e-3):
            self._place_camera(client)

    def cameras(self) -> list[CameraView]:
        """Return the cameras of the browsers."""
        return [view_of(client) for client in self._server.get_clients().values()]

    def screenshot(self, width: int, height: int) -> bytes:
        """Return a picture as a PNG file; see ``DrawingScene``."""
        from PIL import Image

        clients = list(self._server.get_clients().values())
        if not clients:
            raise DisplayError("screenshot: no browser is connected; open the page first")
        try:
            pixels = clients[0].get_render(height, width, transport_format="png", timeout=30.0)
        except (RuntimeError, TimeoutError) as error:
            raise DisplayError(f"screenshot: the browser gave no picture ({error}); try once more") from error
        stream = io.BytesIO()
        picture = Image.fromarray(pixels)
        white = Image.new("RGBA", picture.size, (255, 255, 255, 255))
        Image.alpha_composite(white, picture.convert("RGBA")).convert("RGB").save(stream, "PNG")
        return stream.getvalue()

    def _place_camera(self, client: viser.ClientHandle) -> None:
        """Place the camera of a browser so that it shows the box."""
        if self._box is None:
            return
        camera, (low, high, view) = client.camera, self._box
        direction = np.array(VIEWS[view]) / np.linalg.norm(VIEWS[view])
        size = np.maximum(high - low, 1e-3)
        across = size[[0, 2]].max() if view == "top" else size[2 if view in ("left", "right") else 0]
        upright = size[2] if view == "top" else size[1]
        half = np.tan(0.5 * FIELD_OF_VIEW)
        depth = 0.5 * float(np.abs(direction) @ size)
        distance = depth + MARGIN * 0.5 * max(upright, across / max(camera.aspect, 0.2)) / half
        centre = 0.5 * (low + high)
        camera.fov = float(FIELD_OF_VIEW)
        position = centre + distance * direction
        self._placed[client.client_id] = camera.aspect, position
        camera.position, camera.look_at = tuple(position), tuple(centre)
        camera.near, camera.far = float(0.01 * distance), float(10.0 * distance)

    def _updated(self, shown: _Shown, drawing: Drawing) -> bool:
        """Change the nodes of a drawing in place if the new drawing has the same structure; return whether it has."""
        before = shown.drawing
        if isinstance(before, Surface) and isinstance(drawing, Surface):
            return self._surface_updated(shown, before, drawing)
        if isinstance(before, Lines) and isinstance(drawing, Lines) and before.width == drawing.width:
            with self._server.atomic():
                shown.nodes[0].points = np.asarray(drawing.segments, dtype=np.float32)
                shown.nodes[0].colors = np.asarray(drawing.colour, dtype=np.uint8)
            return len(before.segments) == len(drawing.segments)
        if isinstance(before, Copies) and isinstance(drawing, Copies):
            return self._copies_updated(shown.nodes[0], before, drawing)
        if isinstance(before, YarnTubes) and isinstance(drawing, YarnTubes):
            with self._server.atomic():
                return update_tubes(shown.nodes[0], before, drawing)
        return False

    def _copies_updated(self, node: Any, before: Copies, now: Copies) -> bool:
        """Move copies, if their number and their triangles are the same."""
        if before.triangles is not now.triangles or len(before.offsets) != len(now.offsets):
            return False
        with self._server.atomic():
            if before.points is not now.points:
                node.vertices = np.asarray(now.points, dtype=np.float32)
            if before.offsets is not now.offsets:
                node.batched_positions = np.asarray(now.offsets, dtype=np.float32)
            if before.colour != now.colour:
                node.batched_colors = _linear_bytes(now.colour)
        return True

    def _surface_updated(self, shown: _Shown, before: Surface, now: Surface) -> bool:
        alike = (before.flat, before.opacity, before.takes_strokes) == (now.flat, now.opacity, now.takes_strokes)
        kinds_alike = isinstance(before.colours, Colours) == isinstance(now.colours, Colours)
        same_triangles = before.triangles is now.triangles and len(before.points) == len(now.points)
        if not (alike and kinds_alike and same_triangles):
            return False
        if before.points is not now.points:
            shown.nodes[0].vertices = _vertices(now)
        if before.colours is not now.colours:
            if isinstance(now.colours, tuple):
                shown.nodes[0].color = now.colours
            shown.drawing = now
            self._send_colours(shown)
        return True

    def _add(self, name: str, drawing: Drawing) -> list[Any]:
        """Add the nodes of a drawing."""
        scene = self._server.scene
        if isinstance(drawing, Surface):
            return [self._add_surface(name, drawing)]
        if isinstance(drawing, Lines):
            segments = np.asarray(drawing.segments, dtype=np.float32).reshape(-1, 2, 3)
            colours = np.asarray(drawing.colour, dtype=np.uint8)
            return [scene.add_line_segments(name, segments, colours, thickness=drawing.width, thickness_units="screen")]
        if isinstance(drawing, Arrows):
            return [
                scene.add_arrows(
                    name, np.asarray(drawing.segments, dtype=np.float32).reshape(-1, 2, 3),
                    np.asarray(drawing.colour, dtype=np.uint8), shaft_radius=drawing.radius,
                    head_radius=2.5 * drawing.radius, head_length=5.0 * drawing.radius,
                )
            ]  # fmt: skip
        if isinstance(drawing, Copies):
            return [self._add_copies(name, drawing)]
        if isinstance(drawing, YarnTubes):
            return [add_tubes(scene, name, drawing)]
        assert isinstance(drawing, Labels)
        return [
            scene.add_label(f"{name}-{number}", text, position=tuple(point))
            for number, (text, point) in enumerate(zip(drawing.texts, drawing.points.tolist(), strict=True))
        ]

    def _add_surface(self, name: str, surface: Surface) -> Any:
        faces = np.arange(3 * len(surface.triangles)).reshape(-1, 3) if surface.flat else surface.triangles
        colour = (255, 255, 255) if isinstance(surface.colours, Colours) else surface.colours
        node = self._server.scene.add_mesh_simple(
            name, _vertices(surface), np.asarray(faces, dtype=np.uint32),
            color=colour, flat_shading=surface.flat, side="double",
            opacity=None if surface.opacity >= 1.0 else surface.opacity, cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        if surface.takes_strokes:
            node.on_drag("left")(self._drag)
        return node

    def _add_copies(self, name: str, copies: Copies) -> Any:
        offsets = np.asarray(copies.offsets, dtype=np.float32)
        return self._server.scene.add_batched_meshes_simple(
            name, np.asarray(copies.points, dtype=np.float32), np.asarray(copies.triangles, dtype=np.uint32),
            np.tile(np.array([1.0, 0.0, 0.0, 0.0], dtype=np.float32), (len(offsets), 1)), offsets,
            batched_colors=_linear_bytes(copies.colour), lod="off", cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    async def _drag(self, event: viser.SceneNodeDragEvent) -> None:
        """Pass on a drag as a stroke; the function is asynchronous, because viser keeps the order of such functions."""
        place = event.start_screen_pos if event.phase == "start" else event.end_screen_pos
        origin, direction = view_of(event.client).ray(*place)
        phase = "move" if event.phase == "update" else event.phase
        self._on_stroke(Stroke(origin, direction, modifier_of(event.modifier), event.client_id, phase))

    def _send_colours(self, shown: _Shown, client: viser.ClientHandle | None = None) -> None:
        surface = shown.drawing
        if isinstance(surface, Surface) and isinstance(surface.colours, Colours):
            self._bridge.run(colour_script(shown.node_name, surface.colours, flat=surface.flat), client)

    def _colour_all(self, client: viser.ClientHandle) -> None:
        """Send all colours to a newly connected browser."""
        for shown in list(self._shown.values()):
            self._send_colours(shown, client)


def _are_alike(box: tuple[FloatArray, FloatArray], other: tuple[FloatArray, FloatArray]) -> bool:
    """Return whether two boxes differ by only a small part of their size."""
    most = 0.1 * max(float((box[1] - box[0]).max()), 1e-3)
    return all(bool(np.abs(corner - its).max() <= most) for corner, its in zip(box, other, strict=True))


def view_of(client: viser.ClientHandle) -> CameraView:
    """Return the camera of a browser."""
    camera = client.camera
    return CameraView(np.array(camera.position), np.array(camera.wxyz), float(camera.fov), float(camera.aspect))


def modifier_of(modifier: str | None) -> Modifier:
    """Return our name of the key that viser names; of several keys, the first known one."""
    for ours, theirs in (("shift", "shift"), ("ctrl", "cmd/ctrl"), ("alt", "alt")):
        if modifier is not None and theirs in modifier:
            return ours  # type: ignore[return-value]
    return ""


def _linear_bytes(colour: Colour) -> NDArray[np.uint8]:
    """Return the bytes of a colour in linear light, because the colours of copies reach WebGL unchanged."""
    return np.rint(255.0 * linear_colour(np.array(colour) / 255.0)).astype(np.uint8)


def _vertices(surface: Surface) -> NDArray[np.float32]:
    """Return the positions for viser: three for each triangle of a flat surface."""
    points = np.asarray(surface.points, dtype=np.float32)
    return points[surface.triangles].reshape(-1, 3) if surface.flat else points


def _light(server: viser.ViserServer) -> None:
    """Light the scene from the upper left, so that yarns look round; there are no shadows, which change colours."""
    server.scene.configure_default_lights(enabled=False)
    server.scene.configure_environment_map(hdri=None)
    server.scene.add_light_ambient("/light/ambient", intensity=1.1)
    server.scene.add_light_directional("/light/front", intensity=2.3, position=(-0.6, 0.9, 0.8))
    server.scene.add_light_directional("/light/back", intensity=1.0, position=(-0.5, 0.5, -1.0))
