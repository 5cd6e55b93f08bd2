# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on StitchMesh: one button knits the active mesh, and brings the relaxed yarns back as curves.

A local program ``stitchmesh`` does the work in a process of its own, while Blender stays usable. The panel stands in
the sidebar of the 3D view, on the tab StitchMesh.
"""

from __future__ import annotations

import time

import bpy

from .program import MESH, YARNS, KnitChoices, ProgramError, ProgramRun, commands, find_program
from .yarns import read_yarns, write_garment

SECONDS = 0.2
"""Time between two looks at the program [s]."""
ROWS = (
    ("MESH", "Quads of the mesh", "Rows follow the faces: a mesh of quads with one or two kinds of loops"),
    ("AUTO", "Found", "Rows and stitches are found on any mesh, also of triangles"),
)
QUALITIES = (
    ("draft", "Draft", "Seconds to a minute"),
    ("standard", "Standard", "Closer to rest; minutes"),
    ("reference", "Reference", "Double precision and fine samples; takes the longest"),
)


FAILURES = (ProgramError, OSError, RuntimeError)
"""Errors of the program, of the disk, and of operators of Blender, which are said in one line."""


class Watched:
    """The program that runs, if one does; no property of Blender, because files keep those."""

    run: ProgramRun | None = None
    cancelled = False


WATCHED = Watched()


class StitchMeshPreferences(bpy.types.AddonPreferences):
    """Where the program stands."""

    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program",
        description="Path of the program stitchmesh; if it is empty, the search path is used",
        subtype="FILE_PATH",
    )

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the preferences."""
        self.layout.prop(self, "program")
        self.layout.label(text="Install it with: pip install stitchmesh")


class StitchMeshSettings(bpy.types.PropertyGroup):
    """The choices of the panel, which the scene keeps."""

    stitch_width: bpy.props.FloatProperty(
        name="Stitch Width [cm]", description="Distance of neighbouring wales", default=0.8, min=0.05, max=20.0
    )
    rows: bpy.props.EnumProperty(name="Rows", items=ROWS, default="MESH")
    quality: bpy.props.EnumProperty(name="Quality", items=QUALITIES, default="draft")
    pattern: bpy.props.StringProperty(
        name="Pattern", description="Name of `stitchmesh patterns`, such as rib2x2; empty for plain knitting"
    )


class STITCHMESH_OT_knit(bpy.types.Operator):
    """Knit the active mesh with the program stitchmesh; the yarns replace those of the run before."""

    bl_idname = "stitchmesh.knit"
    bl_label = "Knit"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether the active object is a mesh, in object mode, and nothing is being knitted."""
        thing = context.active_object
        return WATCHED.run is None and thing is not None and thing.type == "MESH" and thing.mode == "OBJECT"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Start the program, and watch it while Blender stays usable."""
        if not self._begin(context):
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(SECONDS, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Look at the program; Esc and the button Cancel stop it."""
        if event.type == "ESC" or WATCHED.cancelled:
            self._end(context)
            self.report({"INFO"}, "Knitting was cancelled")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            ended = self._run.poll()
            _redraw(context)
            return self._finish(context) if ended else {"PASS_THROUGH"}
        except FAILURES as error:
            return self._fail(context, error)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Knit and wait for the result, as scripts do."""
        if not self._begin(context):
            return {"CANCELLED"}
        try:
            while not self._run.poll():
                time.sleep(SECONDS)
            return self._finish(context)
        except FAILURES as error:
            return self._fail(context, error)

    def cancel(self, context: bpy.types.Context) -> None:
        """Stop the program when Blender ends."""
        self._end(context)

    def _begin(self, context: bpy.types.Context) -> bool:
        """Write the mesh and start the program; returns whether it runs."""
        settings = context.scene.stitchmesh
        self._timer, self._garment = None, context.active_object.name
        self._run = WATCHED.run = ProgramRun()
        WATCHED.cancelled = False
        choices = KnitChoices(
            settings.stitch_width, settings.rows == "AUTO", settings.quality, settings.pattern.strip()
        )
        try:
            program = find_program(bpy.path.abspath(_preferences(context).program))
            write_garment(self._run.folder / MESH, context.active_object, context)
            self._run.start(commands(program, self._run.folder, choices))
        except FAILURES as error:
            self._fail(context, error)
            return False
        return True

    def _finish(self, context: bpy.types.Context) -> set[str]:
        """Bring the yarns back."""
        garment = bpy.data.objects.get(self._garment)
        if garment is None:
            raise ProgramError(f"{self._garment}: was removed or renamed while it was knitted; knit it again")
        yarns = read_yarns(self._run.folder / YARNS, garment, context)
        self._end(context)
        self.report({"INFO"}, f"{len(yarns.data.curves)} yarns on {garment.name}")
        return {"FINISHED"}

    def _fail(self, context: bpy.types.Context, error: Exception) -> set[str]:
        """Say an error in one line, which Blender shows in its status bar and in a popup."""
        self._end(context)
        self.report({"ERROR"}, " ".join(str(error).split()))
        return {"CANCELLED"}

    def _end(self, context: bpy.types.Context) -> None:
        """Stop the program if it still runs, and forget it."""
        self._run.close()
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        WATCHED.run = None
        _redraw(context)


class STITCHMESH_OT_cancel(bpy.types.Operator):
    """Stop knitting."""

    bl_idname = "stitchmesh.cancel"
    bl_label = "Cancel"

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Ask the running operator to stop."""
        WATCHED.cancelled = True
        return {"FINISHED"}


class STITCHMESH_PT_panel(bpy.types.Panel):
    """The panel in the sidebar of the 3D view."""

    bl_label = "StitchMesh"
    bl_category = "StitchMesh"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the choices and the button, or the progress."""
        run, settings = WATCHED.run, context.scene.stitchmesh
        column = self.layout.column()
        column.enabled = run is None
        for name in ("stitch_width", "rows", "quality", "pattern"):
            column.prop(settings, name)
        if run is not None:
            self.layout.progress(factor=run.step.part, text=run.step.text)
            self.layout.operator(STITCHMESH_OT_cancel.bl_idname, icon="CANCEL")
        else:
            self.layout.operator_context = "INVOKE_DEFAULT"
            self.layout.operator(STITCHMESH_OT_knit.bl_idname, icon="MOD_CLOTH")


CLASSES = (
    StitchMeshPreferences,
    StitchMeshSettings,
    STITCHMESH_OT_knit,
    STITCHMESH_OT_cancel,
    STITCHMESH_PT_panel,
)


def register() -> None:
    """Add the panel and its operators to Blender."""
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.stitchmesh = bpy.props.PointerProperty(type=StitchMeshSettings)


def unregister() -> None:
    """Remove them, and stop a program that still runs."""
    if WATCHED.run is not None:
        WATCHED.run.close()
    del bpy.types.Scene.stitchmesh
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)


def _preferences(context: bpy.types.Context) -> StitchMeshPreferences:
    return context.preferences.addons[__package__].preferences


def _redraw(context: bpy.types.Context) -> None:
    """Draw the sidebars again, where the progress stands."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
