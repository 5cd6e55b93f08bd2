# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A scene of mixed yarns and triangles as numbers, texts and lists; the names of the fields are the keys of the file.

Lengths are in cm, times in s, masses in g; y points up. A scene file is TOML with these keys. Paths in a file are
relative to its folder.

``ClothSection`` and ``YarnsSection`` describe the cloth and the yarns that are laid out on it; ``region_section`` says
where yarns are simulated, and ``motion_section`` what is held, moved, or in the way.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.path_kind import whole_path
from stitchmesh.io.toml_file import SUFFIX, changed_fields, read_dataclass, table_lines
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh import BOTTOM, TOP, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.panel_file import read_panels
from stitchmesh.mixed.cloth.panels import Panel, PanelPosition
from stitchmesh.mixed.cloth.seams import PanelSeam, cloth_from_panels
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.output.display import ROUNDS
from stitchmesh.mixed.scene.motion_section import AttachmentSection, BodySection
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.settings import NOT_NEGATIVE, POSITIVE, check_settings, setting

MATCHED = "matched"
"""Name of the cloth material that is matched to the yarns of the scene."""
STITCH_SUFFIXES = (".h5", ".smobj")
"""Suffixes of stitch meshes."""


@dataclass(frozen=True, kw_only=True)
class ClothSection:
    """A cloth as triangles: one of ``rectangle``, ``panels`` and ``file``.

    Raises:
        ParameterError: not exactly one of them is given, or seams are given without panels.
    """

    rectangle: tuple[float, float] | None = setting(
        None, "width and height of one flat panel; x along wefts or courses, y along warps or wales", unit="cm",
        unset="none",
    )  # fmt: skip
    position: PanelPosition = field(default_factory=PanelPosition)
    """Where the rectangle lies in space at the start: ``origin``, ``x_axis``, ``y_axis``, ``radius``."""
    panels: tuple[Panel, ...] = setting((), "panels: name, outline, position, side_edges")
    seams: tuple[PanelSeam, ...] = setting(
        (), "seams between panels: first and second (panel, start, end), angle, edges"
    )
    seam_rods: bool = setting(
        False, "whether the rods along seams, to which other yarns are joined, go on where triangles are simulated; "
        "alpha blends their stiffness and mass as it does for other yarns",
    )  # fmt: skip
    file: str | None = setting(
        None, "panels and seams (.toml), a polygon mesh whose texture coordinates are its rest shape (.obj), or a "
        "stitch mesh (.h5, .smobj)", unset="none",
    )  # fmt: skip
    stitch_width: float | None = setting(
        None, "wale spacing of a stitch mesh at rest", unit="cm", unset="the median of its sides"
    )
    course_height: float | None = setting(
        None, "course spacing of a stitch mesh at rest", unit="cm", unset="the median of its sides"
    )
    unit: str = setting(DEFAULT_UNIT, "unit of the coordinates in an OBJ file")
    edge_length: float | None = setting(
        None, "length of the edges of triangles; an OBJ file has its own triangles", unit="cm",
        unset="1, or as the file of panels states",
    )  # fmt: skip
    material: str | None = setting(
        None, "a measured cloth (docs/cloth-materials.md), a material file (.toml), or matched: fitted to the yarns by "
        "tests of one repeat, which takes seconds and is kept in the output folder",
        unset="the stiffness of straight yarns for a weave, interlock for a knit",
    )  # fmt: skip

    def __post_init__(self) -> None:
        given = [name for name in ("rectangle", "panels", "file") if getattr(self, name)]
        if len(given) != 1:
            found = " and ".join(given) or "nothing"
            raise ParameterError(f"cloth: got {found}; expected exactly one of rectangle, panels and file")
        if self.seams and not self.panels:
            raise ParameterError("cloth.seams: got seams without panels; expected the panels that they join")

    def cloth(self) -> Cloth:
        """Make the cloth.

        Raises:
            ParameterError: a panel or a seam is not possible.
            FileError: a file cannot be read.
            MeshError: the panels sewn together are not a manifold surface.
        """
        if self.file is not None:
            return self._from_file(self.file)
        panels = self.panels
        if self.rectangle is not None:
            width, height = self.rectangle
            outline = ((0.0, 0.0), (width, 0.0), (width, height), (0.0, height))
            panels = (Panel(name="panel", outline=outline, position=self.position),)
        return cloth_from_panels(panels, self.seams, edge_length=self.edge_length or 1.0)

    def _from_file(self, path: str) -> Cloth:
        suffix = Path(path).suffix.lower()
        if suffix == ".toml":
            content = read_panels(path)
            return replace(content, edge_length=self.edge_length or content.edge_length).cloth()
        if suffix == ".obj":
            from stitchmesh.mixed.cloth.from_obj import cloth_from_obj

            return cloth_from_obj(path, unit=self.unit)
        if suffix in STITCH_SUFFIXES:
            from stitchmesh.mixed.cloth.from_stitches import cloth_from_stitches

            fabric = self.stitches()
            width, height = self.stitch_size(fabric)
            return cloth_from_stitches(fabric, stitch_width=width, course_height=height)
        expected = ".toml (panels), .obj (texture coordinates), .h5 or .smobj (stitches)"
        raise FileError(f"{path}: got the suffix {suffix!r}; expected {expected}")

    def stitches(self) -> StitchMesh:
        """Return the stitch mesh of the file.

        Raises:
            FileError: the file cannot be read.
            ParameterError: the file does not hold stitches.
        """
        from stitchmesh.io import read_stitches

        if self.file is None or Path(self.file).suffix.lower() not in STITCH_SUFFIXES:
            raise ParameterError("yarns.knit: got 'stitches' without any; expected a cloth.file of .h5 or .smobj")
        return read_stitches(self.file)

    def stitch_size(self, fabric: StitchMesh) -> tuple[float, float]:
        """Return the wale and course spacing of a stitch mesh at rest [cm]."""
        across = (fabric.side_role == BOTTOM) | (fabric.side_role == TOP)
        found = [float(np.median(fabric.side_length[chosen])) for chosen in (across, ~across)]
        return self.stitch_width or found[0], self.course_height or found[1]


Matrix = NDArray[np.int64]
STITCHES = "stitches"
"""Name of the knit whose loops are the stitches of the cloth."""
DEFAULT_DENSITY = 5.0
"""Default number of yarns, wales or courses per cm."""


@dataclass(frozen=True, kw_only=True)
class YarnsSection:
    """Yarns that are laid out on the panels: ``weave`` or ``knit``.

    Raises:
        ParameterError: both or neither are given, or a density is not positive.
    """

    weave: str | tuple[str, ...] | None = setting(
        None, "weave: plain, basket-NxN, twill-AxB, a name or a file of the library, or rows from the top such as "
        '["10", "01"], with 1 where the weft lies above', unset="none",
    )  # fmt: skip
    model: Literal["crossings", "splines"] = setting(
        "crossings", "how yarns are simulated: crossings (nodes where yarns cross), or splines (B-splines in contact, "
        'whose loops stand out of the cloth; for static scenes with knit = "stitches")',
    )  # fmt: skip
    knit: str | tuple[str, ...] | None = setting(
        None, 'knit: name or file of a pattern of knit and purl stitches, rows from the top such as ["kp"], or '
        "stitches for the stitches of the cloth", unset="none",
    )  # fmt: skip
    divisions: int = setting(1, "for stitches: number of loops along each side of a stitch of the cloth", **POSITIVE)
    ends: float = setting(DEFAULT_DENSITY, "warps for each cm", **POSITIVE)
    picks: float = setting(DEFAULT_DENSITY, "wefts for each cm", **POSITIVE)
    wales: float = setting(DEFAULT_DENSITY, "wales for each cm", **POSITIVE)
    courses: float = setting(DEFAULT_DENSITY, "courses for each cm", **POSITIVE)
    density: float = setting(
        1.0, "number of finer yarns in the place of each yarn, so that the cloth stays as heavy and as stiff; not for "
        "stitches, which have divisions", **POSITIVE,
    )  # fmt: skip
    loop_length: float | None = setting(
        None, "for splines: length of yarn in each plain stitch", unit="cm", unset="as the loops are drawn", **POSITIVE
    )
    material: str | None = setting(
        None, "material of the yarns, in material_file or among the named materials", unset="gong-1"
    )
    warp_material: str | None = setting(None, "material of the warps", unset="that of the wefts")
    material_file: str | None = setting(None, "file of materials (.toml)", unset="the named materials")
    radius: float | None = setting(
        None, "radius of the yarns", unit="cm", unset="that of the material, or an eighth of a stitch for splines",
        **POSITIVE,
    )  # fmt: skip

    def __post_init__(self) -> None:
        if (self.weave is None) == (self.knit is None):
            found = "neither" if self.weave is None else "both"
            raise ParameterError(f"yarns: got {found} of weave and knit; expected one of them")
        self._check_model()
        check_settings(self, "yarns")

    def _check_model(self) -> None:
        """Check that the keys fit the yarn model."""
        if self.model == "crossings":
            if self.loop_length is not None:
                raise ParameterError("yarns.loop_length: got one with crossings; expected model = 'splines' beside it")
            return
        if self.knit != STITCHES:
            raise ParameterError("yarns.model: got 'splines' without stitches; expected knit = 'stitches' beside it")
        for name in ("material_file", "warp_material"):
            if getattr(self, name) is not None:
                raise ParameterError(f"yarns.{name}: got one with B-splines; expected the name of a material alone")
        if self.divisions != 1:
            raise ParameterError(f"yarns.divisions: got {self.divisions} with B-splines; expected 1")

    def crossings_on(self, cloth: Cloth) -> float:
        """Return the approximate number of crossings of the yarns on a cloth; each loop of a knit has four."""
        if self.weave is not None:
            return float(cloth.rest_area.sum()) * self.ends * self.picks * self.density**2
        return 4.0 * float(cloth.rest_area.sum()) * self.wales * self.courses * self.density**2

    def layout(self, cloth: Cloth) -> CrossingYarns:
        """Lay the yarns out on a cloth.

        Raises:
            ParameterError: the weave or the pattern is unknown, or no panel holds a crossing.
            PatternError: a file does not describe a pattern.
        """
        n = self.density
        if self.weave is not None:
            return lay_weave(cloth, weave_matrix(self.weave), ends=n * self.ends, picks=n * self.picks)
        assert self.knit is not None  # the constructor has checked it
        chart = knit_chart(self.knit)
        return lay_knit(cloth, chart, wale_spacing=1.0 / (n * self.wales), course_spacing=1.0 / (n * self.courses))


def weave_matrix(weave: str | tuple[str, ...]) -> Matrix:
    """Return the matrix of a weave: 1 where the weft of a row passes over the warp of a column.

    Names: ``plain``, ``basket-NxN`` (groups of N yarns), ``twill-AxB`` (over A and under B, one yarn further in each
    row), and names in the library of weaves, such as ``satin-2x3``.

    Raises:
        ParameterError: the name is unknown, rows are of different lengths or contain other characters, or the weave has
            several layers or yarns of different sizes.
        FileError: a file cannot be read.
        PatternError: a file does not describe a weave.
    """
    if not isinstance(weave, str):
        return _rows("yarns.weave", weave, "01")
    found = re.fullmatch(r"(basket|twill)-([1-9])x([1-9])", "basket-1x1" if weave == "plain" else weave)
    if found is None:
        return _written_weave(weave)
    kind, over, repeat = found[1], int(found[2]), int(found[2]) + int(found[3])
    i, j = np.arange(repeat)[:, None], np.arange(repeat)[None, :]
    if kind == "twill":
        return np.asarray((j - i) % repeat < over, dtype=np.int64)
    if repeat != 2 * over:
        raise ParameterError(f"yarns.weave: got {weave!r}; expected two equal numbers, such as 'basket-2x2'")
    return np.asarray((i // over + j // over) % 2 == 0, dtype=np.int64)


def _written_weave(name: str) -> Matrix:
    """The matrix of a weave of the library, or of a file."""
    from stitchmesh.periodic.weave.library import read_weave
    from stitchmesh.periodic.weave.weave import Thread

    weave = read_weave(name)
    if weave.layer_count > 1:
        found = f"{name!r} has {weave.layer_count} layers"
        raise ParameterError(f"yarns.weave: {found}; expected one, in which two yarns cross at each crossing")
    if any(replace(thread, colour=0) != Thread() for thread in (*weave.wefts, *weave.warps)):
        raise ParameterError(f"yarns.weave: {name!r} has yarns of different sizes; expected equal ones")
    return np.array(weave.matrix, dtype=np.int64)


def knit_chart(knit: str | tuple[str, ...]) -> Matrix:
    """Return the chart of a knit: 1 for a knit stitch and 0 for a purl stitch, the last row knitted first.

    Raises:
        ParameterError: the pattern is unknown or has other stitches, or rows are of different lengths.
        FileError: a file cannot be read.
        PatternError: a file does not describe a pattern.
    """
    if not isinstance(knit, str):
        return _rows("yarns.knit", tuple(row.lower() for row in knit), "pk")
    from stitchmesh.patterns import read_pattern
    from stitchmesh.patterns.pattern import Loop

    pattern = read_pattern(knit)
    rows = [[cell.stitch for cell in row.sections[1]] for row in reversed(pattern.rows)]
    found = {stitch for row in rows for stitch in row} - {Stitch.KNIT, Stitch.PURL}
    if found:
        name = sorted(map(stitch_name, found))[0]
        raise ParameterError(f"yarns.knit: {knit!r} has {name} stitches; expected knit and purl stitches alone")
    if any(loop != Loop() for row in pattern.rows for loop in row.loops):
        raise ParameterError(f"yarns.knit: {knit!r} has cables or twists; expected knit and purl stitches alone")
    if len({len(row) for row in rows}) != 1:
        raise ParameterError(f"yarns.knit: {knit!r} has rows of different lengths; expected equal ones")
    return np.array([[int(stitch == Stitch.KNIT) for stitch in row] for row in rows])


def _rows(name: str, rows: tuple[str, ...], letters: str) -> Matrix:
    """The matrix of rows of two letters; the second letter stands for 1."""
    wrong = [row for row in rows if not row or set(row) - set(letters)]
    if wrong or not rows:
        found = repr(wrong[0]) if wrong else "no row"
        raise ParameterError(f"{name}: got {found}; expected rows of {letters[0]} and {letters[1]}")
    if len({len(row) for row in rows}) > 1:
        raise ParameterError(f"{name}: got rows of {len(rows[0])} and other numbers of letters; expected equal ones")
    return np.array([[letters.index(letter) for letter in row] for row in rows])


def is_file(name: str) -> bool:
    """Return whether a text names a file rather than an entry of a library."""
    return bool(Path(name).suffix) or Path(name).name != name


Triple = tuple[float, float, float]
YARN_FORMATS = ("bcc", "h5", "usda", "usdc", "vtp", "obj", "glb")
"""Formats of yarns that a scene may write."""


@dataclass(frozen=True, kw_only=True)
class ContactSection:
    """Contact of the cloth with itself and with bodies.

    Raises:
        ParameterError: a number is out of bounds.
    """

    self_collision: bool = setting(False, "whether the cloth collides with itself")
    thickness: float | None = setting(
        None, "thickness of the cloth in contact", unit="cm", unset="four yarn radii, two layers at a crossing",
        **POSITIVE,
    )  # fmt: skip
    pressure: float | None = setting(
        None, "scale of the pressure of contact", unit="dyn/cm^2", unset="a value that suits cloth", **POSITIVE
    )
    friction: float = setting(
        0.0, "coefficient of friction between the layers of a cloth that moves and collides with itself", **NOT_NEGATIVE
    )
    start_outside: bool = setting(
        False, "whether a cloth that starts partly inside a body is moved out of it, while its strain spreads; "
        "otherwise a deep start is an error",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self, "contact")


MOST_FRAMES = 10_000
"""Largest number of frames of a dynamic run, whose files have four digits in their names."""


@dataclass(frozen=True, kw_only=True)
class SceneSolverSection:
    """Precision, processor and tolerances.

    Raises:
        ParameterError: a number is out of bounds.
    """

    precision: Literal["float32", "float64"] = setting(
        "float64", "floating-point type of the simulation; float32 is faster on a GPU"
    )
    device: str | None = setting(
        None, "processor, cpu or cuda:0", unset="the first GPU, or the CPU without a GPU"
    )
    velocity_tolerance: float = setting(
        0.5, "root mean square error of the velocities of a step of a dynamic run", unit="cm/s", **POSITIVE
    )
    force_tolerance: float = setting(
        0.01, "largest unbalanced force on a vertex or a node at a static equilibrium", unit="dyn", **POSITIVE
    )
    solve_tolerance: float = setting(1e-2, "relative tolerance of the linear solves", **POSITIVE)
    most_iterations: int = setting(
        500, "largest number of Newton iterations of one search for an equilibrium", **POSITIVE
    )
    friction_updates: int = setting(
        20, "largest number of times that a search for an equilibrium releases yarns that friction no longer holds; "
        "with 0, yarns stay where they cross in the layout, which is faster", **NOT_NEGATIVE,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self, "solver")


@dataclass(frozen=True, kw_only=True)
class OutputSection:
    """The files and pictures that a run writes.

    Raises:
        ParameterError: a number is out of bounds, or a format is unknown.
    """

    frames_per_second: float = setting(30.0, "states of a dynamic run that are kept for each second", **POSITIVE)
    yarns: tuple[str, ...] = setting(("bcc",), f"formats of the yarns at the end: {', '.join(YARN_FORMATS)}")
    animation: bool = setting(True, "whether all frames are written as USD with time samples")
    picture: bool = setting(True, "whether a picture is drawn")
    colour: Literal["yarn", "alpha", "tension"] = setting(
        "yarn", "what decides the colours of the picture: yarn, alpha or tension"
    )
    view: tuple[float, float] = setting(
        (0.0, 0.0), "direction of the camera: azimuth (0 is the side of z, 90 the side of x) and elevation",
        unit="degrees",
    )  # fmt: skip
    size: tuple[int, int] = setting((1200, 900), "width and height of the picture", unit="pixels")
    subdivisions: int = setting(
        ROUNDS, "rounds of subdivision of the triangles for display", least=0, most=4, expected="0 to 4"
    )

    def __post_init__(self) -> None:
        check_settings(self, "output")
        unknown = [name for name in self.yarns if name not in YARN_FORMATS]
        if unknown:
            raise ParameterError(f"output.yarns: got {unknown[0]!r}; expected some of {', '.join(YARN_FORMATS)}")


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything that decides a run of the mixed system.

    Raises:
        ParameterError: a number is out of bounds, or keys contradict each other.
    """

    mode: Literal["static", "dynamic"] = setting(
        "static", "static: the cloth comes to an equilibrium; dynamic: it moves in time"
    )
    duration: float = setting(
        1.0, "time of a dynamic run; for a static run, the time of the keyframes at its end", unit="s", **POSITIVE
    )
    largest_step: float = setting(2e-3, "largest time step", unit="s", **POSITIVE)
    load_steps: int = setting(
        1, "number of equilibria of a static run, from the first place of attachments and bodies to the last one",
        **POSITIVE,
    )  # fmt: skip
    gravity: Triple = setting((0.0, -981.0, 0.0), "acceleration", unit="cm/s^2")
    disturbance: float = setting(
        0.0, "size of random displacements across the cloth at the start, so that a flat cloth can buckle; they are "
        "the same in each run", unit="cm", **NOT_NEGATIVE,
    )  # fmt: skip
    cloth: ClothSection
    """The cloth as triangles."""
    yarns: YarnsSection
    """The yarns that are laid out on it."""
    region: RegionSection = field(default_factory=RegionSection)
    """Where yarns are simulated."""
    attachments: tuple[AttachmentSection, ...] = ()
    """Parts of the cloth that are held or moved."""
    bodies: tuple[BodySection, ...] = ()
    """Bodies that the cloth cannot enter."""
    contact: ContactSection = field(default_factory=ContactSection)
    solver: SceneSolverSection = field(default_factory=SceneSolverSection)
    output: OutputSection = field(default_factory=OutputSection)

    def __post_init__(self) -> None:
        check_settings(self)
        if self.yarns.model == "splines" and self.mode != "static":
            raise ParameterError(f"mode: got {self.mode!r} with B-spline yarns; expected 'static'")
        if self.mode == "static" and self.contact.friction:
            raise ParameterError(
                f"contact.friction: got {self.contact.friction} in a static scene, whose layers slide freely; expected "
                '0, or mode = "dynamic"'
            )
        if self.mode == "dynamic" and self.region.start != "layout":
            raise ParameterError(
                f"region.start: got {self.region.start!r} in a dynamic scene; expected 'layout', or mode = \"static\""
            )
        frames = self.duration * self.output.frames_per_second
        if self.mode == "dynamic" and frames > MOST_FRAMES:
            raise ParameterError(
                f"duration: got {self.duration:g} s with {frames:.3g} frames; expected at most {MOST_FRAMES:,} frames: "
                "give a shorter duration or fewer output.frames_per_second"
            )
        if not all(math.isfinite(part) for part in self.gravity):
            raise ParameterError(f"gravity: got {list(self.gravity)}; expected three finite numbers of cm/s^2")

    @property
    def equilibria(self) -> int:
        """Number of equilibria that a static run finds with its yarns."""
        return 1 if self.region.starts_on_triangles else self.load_steps


HEADER = """\
# A scene of mixed yarns and triangles: stitchmesh drape SCENE -o DIR runs it.
# docs/settings.md lists every key. Lengths are in cm, times in s; y points up. Paths are relative to this file.
"""
INLINE = ("position", "first", "second", "low", "high")
"""Keys whose tables are written within one line."""


def read_scene(path: FilePath) -> Scene:
    """Read a scene from a TOML file.

    Raises:
        FileError: the file cannot be read, is not TOML, or has an unknown key or an impossible value; the message names
            the key and, for an unknown key, the nearest known one.
    """
    scene = read_dataclass(path, Scene)
    return _with_paths(scene, lambda inside: os.path.normpath(Path(path).parent / inside))


def write_scene(path: FilePath, scene: Scene) -> None:
    """Write a scene as a TOML file; the file is written atomically. Keys whose value is the default are left out.

    Raises:
        FileError: the file cannot be written, or its suffix is not ``.toml``.
    """
    suffix_of(path, [SUFFIX])
    write_text(path, scene_text(scene, whole_path(path).parent))


def scene_text(scene: Scene, folder: Path | None = None) -> str:
    """Return a scene as the text of a TOML file in a folder; without a folder, the paths in it are absolute."""

    def relative(inside: str) -> str:
        return (Path(inside).absolute() if folder is None else Path(os.path.relpath(inside, folder))).as_posix()

    moved = _with_paths(scene, relative)
    return HEADER + "\n" + "\n".join(table_lines(changed_fields(moved), inline=INLINE)) + "\n"


def example_scene() -> str:
    """Return the text of an example scene, with comments."""
    return Path(__file__).with_name("example.toml").read_text(encoding="utf-8")


def _with_paths(scene: Scene, change: Callable[[str], str]) -> Scene:
    """Return a scene with all paths of files changed."""

    def file(name: str | None) -> str | None:
        return None if name is None else change(name)

    def library(name: Any) -> Any:
        return change(name) if isinstance(name, str) and is_file(name) else name

    cloth, yarns = scene.cloth, scene.yarns
    return replace(
        scene,
        cloth=replace(cloth, file=file(cloth.file), material=library(cloth.material)),
        yarns=replace(
            yarns,
            weave=library(yarns.weave),
            knit=library(yarns.knit),
            material_file=file(yarns.material_file),
        ),
        bodies=tuple(replace(body, file=file(body.file)) for body in scene.bodies),
    )
