# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A garment between two stages: its mesh, its options, and the values that the stages have made so far."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Generic, TypeVar

from stitchmesh import __version__
from stitchmesh.budget.budget import Budget
from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.repair import RepairAction
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.quality import Quality, quality_named
from stitchmesh.shaping.found_stitches import FoundStitches
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import Relaxation

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Made(Generic[T]):
    """What a stage has made."""

    value: T
    """The value, for the stages after it."""
    report: Mapping[str, Any]
    """Its entries in ``report.json``."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Garment:
    """A garment between two stages."""

    mesh: Mesh | PanelMesh
    """The polygon mesh, or the panels of a sewing pattern."""
    options: KnitOptions
    """Options of all stages."""
    budget: Budget | None = None
    """Limits on the time and on the error; None without limits."""
    report: Mapping[str, Any] = field(default_factory=dict)
    """Entries of ``report.json`` so far."""
    values: Mapping[type, Any] = field(default_factory=dict)
    """The newest value of each kind that a stage has made."""

    @classmethod
    def begin(
        cls, mesh: Mesh | PanelMesh, options: KnitOptions, *, budget: Budget | None = None,
        repair: Sequence[RepairAction] | None = None,
    ) -> Garment:  # fmt: skip
        """Return a garment before its first stage, with the first entries of its report.

        Args:
            mesh: the polygon mesh, or the panels of a sewing pattern.
            options: options of all stages.
            budget: limits on the time and on the error.
            repair: earlier changes of the mesh, for the report; None if the mesh was not repaired.

        Raises:
            ParameterError: there is no such device.
        """
        garment = cls(mesh=mesh, options=options, budget=budget)
        head = {"stitchmesh": __version__, "device": garment.device, "quality": garment.quality_entry}
        return garment.reporting(head if repair is None else {**head, "repair": _repair_entries(repair)})

    def reporting(self, entries: Mapping[str, Any]) -> Garment:
        """Return the garment with more entries of its report."""
        return replace(self, report={**self.report, **entries})

    def after(self, kind: type[T], made: Made[T]) -> Garment:
        """Return the garment after a stage that makes values of a kind."""
        return replace(self.reporting(made.report), values={**self.values, kind: made.value})

    @property
    def device(self) -> str:
        """Warp's name of the device."""
        return str(device_named(self.options.device))

    @property
    def quality(self) -> Quality:
        """The quality that a budget has chosen, else the quality of the options."""
        chosen: Quality | None = self.values.get(Quality)
        return quality_named(self.options.quality) if chosen is None else chosen

    @property
    def quality_entry(self) -> str | dict[str, Any]:
        """The quality of the options in the form of the report."""
        given = self.options.quality
        return given if isinstance(given, str) else asdict(given)

    @property
    def found(self) -> FoundStitches | None:
        """The stitches as they were found on the mesh; None if its rows are labeled."""
        found: FoundStitches | None = self.values.get(FoundStitches)
        return found

    @property
    def fabric(self) -> StitchMesh:
        """The stitch mesh after the last stage that made one: the labeled mesh at first."""
        fabric: StitchMesh = self.values[StitchMesh] if StitchMesh in self.values else self.values[FoundStitches].fabric
        return fabric

    @property
    def surface(self) -> Mesh:
        """The surface on which the stitches are evened out."""
        return whole_mesh(self.mesh) if self.found is None else self.found.surface_mesh

    @property
    def yarns(self) -> YarnSet:
        """The generated yarns."""
        yarns: YarnSet = self.values[YarnSet]
        return yarns

    @property
    def relaxed(self) -> Relaxation:
        """The relaxed yarns."""
        relaxed: Relaxation = self.values[Relaxation]
        return relaxed


def whole_mesh(mesh: Mesh | PanelMesh) -> Mesh:
    """Return a mesh that is not divided into the panels of a sewing pattern.

    Raises:
        ParameterError: the mesh is a sewing pattern, and the options do not say how its panels are knitted.
    """
    if isinstance(mesh, PanelMesh):
        raise ParameterError("mesh: got the panels of a sewing pattern; set panels=PanelOptions() in the options")
    return mesh


def _repair_entries(actions: Sequence[RepairAction]) -> list[dict[str, object]]:
    """Return what a repair changed: each action with its text and its places."""
    return [{**asdict(action), "text": f"{action.text}: {action.places}"} for action in actions]
