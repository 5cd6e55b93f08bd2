# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The arm of scenes: its volume, its parts, its motion, and what it refuses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.vertex_motion import VertexMotion
from stitchmesh.mixed.scene.motion_section import AttachmentSection, BodySection, Keyframe
from stitchmesh.mixed.scene.simple_bodies import LARGEST_BEND, Arm
from stitchmesh.simulation.bodies.mesh_features import enclosed_volume

ARM = Arm(3.0, 20.0, 15.0)
BEND = (Keyframe(time=0.0), Keyframe(time=2.0, bend=90.0, displacement=(1.0, 0.0, 0.0)))


@pytest.mark.parametrize("bend", [1e-7, LARGEST_BEND])
def test_a_bend_keeps_the_volume(bend):
    """A tube round a curved line has the area of its ring times the length of the line (Pappus)."""
    volume = enclosed_volume(replace(ARM.mesh(), vertices=ARM.vertices(bend)))
    exact = np.pi * 3.0**2 * 35.0 + 4.0 / 3.0 * np.pi * 3.0**3
    assert volume == pytest.approx(exact, rel=0.02)  # a polygon of 24 sides has 1.2 % less area than its circle
    assert volume == pytest.approx(enclosed_volume(ARM.mesh()), rel=5e-3)  # chords along the elbow


def test_upper_arm_rests_and_forearm_turns():
    straight, bent = ARM.vertices(0.0), ARM.vertices(90.0)
    upper, fore = straight[:, 1] > 4.0, straight[:, 1] < -4.0
    np.testing.assert_allclose(bent[upper], straight[upper], atol=1e-12)
    lengths = [np.linalg.norm(part - part[:1], axis=1) for part in (straight[fore], bent[fore])]
    np.testing.assert_allclose(lengths[1], lengths[0], atol=1e-12)
    assert np.ptp(bent[fore][:, 1]) == pytest.approx(np.ptp(straight[fore][:, 2]), abs=1e-9)  # it points along z


def test_a_body_bends_between_its_keyframes():
    section = BodySection(shape="arm", size=(3.0, 20.0, 15.0), centre=(0.0, 5.0, 0.0), keyframes=BEND)
    motion = section.body().motion
    assert isinstance(motion, VertexMotion)
    for time in (0.0, 40.0 / 45.0, 2.0):  # a shape every 2 degrees
        expected = ARM.vertices(45.0 * time) + np.array([0.5 * time, 5.0, 0.0])
        np.testing.assert_allclose(motion.vertices_at(time), expected, atol=1e-12)
    # between two of its shapes the vertices move along chords of at most 2 degrees
    apart = motion.vertices_at(1.011) - ARM.vertices(45.0 * 1.011) - np.array([0.5 * 1.011, 5.0, 0.0])
    assert np.abs(apart).max() < 20.0 * np.radians(2.0) ** 2 / 8.0


def test_the_check_of_a_body_finds_the_places_at_its_keyframes_only(monkeypatch):
    """A damaged scene of 45 kB had 300 arms; their places between the keyframes took 25 s."""
    bends, vertices = list[float](), Arm.vertices
    monkeypatch.setattr(Arm, "vertices", lambda arm, bend: bends.append(bend) or vertices(arm, bend))
    section = BodySection(shape="arm", size=(3.0, 20.0, 15.0), keyframes=BEND)
    assert bends == [0.0, 90.0]
    assert len(section.motion().times) > 40


def test_bends_and_measures_that_are_not_possible_are_refused():
    with pytest.raises(ParameterError, match="got a bend of 200"):
        ARM.vertices(200.0)
    with pytest.raises(ParameterError, match=r"expected at least 3\.9 cm"):
        Arm(3.0, 20.0, 1.0)
    with pytest.raises(ParameterError, match="expected at most 900 cm"):
        Arm(3.0, 2147483647.0, 15.0)
    with pytest.raises(ParameterError, match="expected 0 to 140"):
        BodySection(shape="arm", size=(3.0, 20.0, 15.0), keyframes=(BEND[0], Keyframe(time=1.0, bend=np.nan)))
    with pytest.raises(ParameterError, match="expected one of an arm alone"):
        BodySection(shape="ball", size=(1.0,), keyframes=BEND)
    with pytest.raises(ParameterError, match="keyframes of an arm alone"):
        AttachmentSection(vertices=(0,), keyframes=BEND)
