# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options of the pipeline from a polygon mesh to relaxed yarns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from stitchmesh.editing.edge_forms import EdgeForm
from stitchmesh.editing.edit import Edit
from stitchmesh.editing.pattern_regions import PatternRegion
from stitchmesh.errors import ParameterError
from stitchmesh.mesh.shaping_stitches import DEFAULT_INCREASE, Increase, check_increase
from stitchmesh.meshrelax import MeshRelaxOptions
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.shaping.panels.options import PanelOptions
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH
from stitchmesh.tessellate.counts import EdgeName
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarngen import YarnFinish
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.energies.term import Choice
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL, material_of

OF_LABELED_MESHES = {
    "borders": "start border", "seeds": "start edge", "flip": "flip", "counts": "count", "marked": "mark",
}  # fmt: skip
"""Fields of ``KnitOptions`` that name edges or faces of a labeled mesh, and their options on the command line."""


@dataclass(frozen=True)
class RelaxOptions:
    """Options of the relaxation of yarns, except for quality and device.

    Raises:
        ParameterError: there is no material or no value of that name, or a value is out of bounds.
    """

    material: str | YarnMaterial | None = None
    """A material for a yarn of ``REFERENCE_RADIUS``, or its name; it is scaled to the radius of the yarns. None
    for that of the yarn of which they were made, or the default material (``material_of``)."""
    stiffness: Mapping[str, float] = field(default_factory=dict)
    """New values of single fields of the material, by name, for a yarn of ``REFERENCE_RADIUS``."""
    rest_lengths: RestLengths = field(default_factory=RestLengths)
    """Changes of the rest lengths."""
    terms: Sequence[Choice] = ()
    """Additional energies, and constraints of control points."""
    keep_shape: bool = True
    """Whether the borders and the shape of the fabric from which the yarns were made are kept, if it is known."""

    def __post_init__(self) -> None:
        self._reference.changed(self.stiffness)

    @property
    def _reference(self) -> YarnMaterial:
        given = self.material
        return given if isinstance(given, YarnMaterial) else YarnMaterial.named(given or DEFAULT_MATERIAL)

    def yarn_material(self, yarns: YarnSet) -> YarnMaterial:
        """Return the material of yarns, for their mean radius.

        Raises:
            ParameterError: as for ``material_of``.
        """
        return material_of(yarns, self.material, self.stiffness)

    def material_of_radius(self, yarn_radius: float) -> YarnMaterial:
        """Return the material of yarn of a radius [cm]."""
        return self._reference.changed(self.stiffness).of_radius(yarn_radius)


@dataclass(frozen=True)
class KnitOptions:
    """Options of ``knit_and_write``.

    Raises:
        ParameterError: an option names edges or faces of a labeled mesh, and rows are found without one; rows are found
            both on any mesh and on panels; or there is no such form of increases.
    """

    stitch_width: float = STITCH_WIDTH
    """Wale spacing [cm]."""
    stitch_height: float | None = None
    """Course spacing [cm]; by default 0.77 times the stitch width."""
    counts: Mapping[EdgeName, int] = field(default_factory=dict)
    """Number of stitches along single edges (``tessellate``)."""
    marked: Sequence[EdgeName] = ()
    """Wale edges at which all increases and decreases of their faces stand (``tessellate``)."""
    increase: Increase = DEFAULT_INCREASE
    """How increases are made: ``m1``, ``kfb``, ``lifted`` or ``yo`` (``stitchmesh.mesh.shaping_stitches``)."""
    mesh_relaxation: MeshRelaxOptions = field(default_factory=MeshRelaxOptions)
    """Options of the relaxation of the stitch mesh."""
    yarn_radius: float | None = None
    """Yarn radius [cm]; by default an eighth of the stitch width."""
    drawn_radius: float | None = None
    """Radius of the yarn in pictures and files for renderers [cm]; by default 1.7 yarn radii (``generate_yarns``)."""
    mass_per_length: float | None = None
    """Mass of a length of yarn [g/cm]; by default the mass of the material."""
    yarn: Yarn | None = None
    """The yarn, which the yarns then carry (``YarnSet.made_of``); its stiffnesses are in ``relaxation``."""
    quality: str | Quality = DEFAULT_QUALITY
    """Name of a preset of ``quality.py``, or a ``Quality``."""
    device: str | None = None
    """Warp's name of the device; None for the preferred device."""
    borders: Sequence[int | tuple[int, int]] = ()
    """Edges of borders from which rows start (``label``)."""
    seeds: Sequence[int | tuple[int, int]] = ()
    """Course edges from which rows start (``label``)."""
    flip: Sequence[int] = ()
    """Faces whose rows are reversed (``label``)."""
    shaping: ShapingOptions | None = None
    """How rows are found on a mesh of any kind (``shape_fabric``); None labels the modelled rows of the mesh."""
    panels: PanelOptions | None = None
    """How the panels of a sewing pattern are knitted (``knit_panels``); None if the mesh is no sewing pattern."""
    palette: Sequence[str] = ()
    """Colours of the yarns by number, as texts (``parse_colour``); stock colours for all other numbers."""
    patterns: Sequence[PatternRegion] = ()
    """Knitting patterns, each on its part of the fabric; plain knit elsewhere."""
    edits: Sequence[Edit] = ()
    """Edits of the stitch mesh, after the patterns and before the mesh relaxation."""
    edge_forms: Sequence[EdgeForm] = ()
    """Forms of edges, such as a folded hem; their rows are added after the mesh relaxation."""
    spiral: bool = False
    """Whether the rings of tubes become turns of one spiral row."""
    finish: YarnFinish = field(default_factory=YarnFinish)
    """How rows are cast on and bound off, and which floats are cut."""
    relaxation: RelaxOptions = field(default_factory=RelaxOptions)
    """Options of the relaxation of yarns."""

    def __post_init__(self) -> None:
        if self.shaping is not None and self.panels is not None:
            raise ParameterError("panels: rows are also found on the whole mesh (--auto); leave one of the two out")
        check_increase(self.increase)
        flag = "--auto" if self.panels is None else "--panels"
        for name, words in OF_LABELED_MESHES.items() if self.finds_rows else ():
            if getattr(self, name):
                raise ParameterError(
                    f"{words}: names edges or faces of a labeled mesh, but rows are found without one ({flag}); leave "
                    "one of the two out"
                )

    @property
    def finds_rows(self) -> bool:
        """Whether rows are found, on a mesh of any kind or on panels, instead of labeled."""
        return self.shaping is not None or self.panels is not None

    @property
    def mesh_relax_options(self) -> MeshRelaxOptions:
        """Options of ``relax_mesh``; the aspect of the stitches is the default of its aspect."""
        height = self.stitch_height
        aspect = COURSE_OVER_WALE_SPACING if height is None else height / self.stitch_width
        given = self.mesh_relaxation.aspect
        return replace(self.mesh_relaxation, aspect=aspect if given is None else given)
