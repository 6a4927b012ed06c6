"""Defects of every kind for the tests, and what a roller feels of them by brute force."""

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from bearingsim.core.defects.depth import (
    Circular,
    EasedDefect,
    Elliptical,
    MergedDefects,
    Rectangular,
    ScannedDefect,
    ShiftedDefect,
    Triangular,
    extent,
    section,
)
from bearingsim.core.defects.pairs import inner_reduced_radius, outer_reduced_radius
from bearingsim.core.defects.profile import depth_at
from bearingsim.core.defects.spall import Spall

R_OUTER, R_INNER = outer_reduced_radius(0.006, 0.0385), inner_reduced_radius(0.006, 0.0265)
SMOOTH = (Rectangular, Triangular, Circular, Elliptical)

fractions = st.floats(-0.95, 0.95)
radii = st.sampled_from([R_OUTER, R_INNER])
lengths, widths, depths = st.floats(1e-3, 12e-3), st.floats(5e-5, 4e-3), st.floats(1e-7, 1e-4)
shapes = st.builds(lambda kind, *sizes: kind(*sizes), st.sampled_from(SMOOTH), lengths, widths, depths)
spalls = st.builds(Spall, lengths, widths, depths, st.floats(0.0, 1.0), st.integers(0, 1000))
plain_defects = shapes | spalls
eased_defects = st.builds(
    lambda defect, r: EasedDefect(defect, r, 0.0, defect.depth), plain_defects, st.floats(2e-6, 1e-4)
) | st.builds(
    lambda defect, ramp: EasedDefect(defect, 0.0, ramp, defect.depth), plain_defects, st.floats(5e-6, 2e-4)
)
shifted_defects = st.builds(
    ShiftedDefect, plain_defects | eased_defects, st.floats(-2e-3, 2e-3), st.floats(-2e-3, 2e-3)
)
merged_defects = st.builds(
    lambda defects: MergedDefects(tuple(defects)), st.lists(shifted_defects, min_size=2, max_size=4)
)
smooth_defects = shapes | spalls | eased_defects | merged_defects
"""Defects without a burr."""


def rough_scan(seed, burr=0.0):
    """A measured spall, 6 mm by 2 mm and 40 um deep, rough by 2 um; with a raised rim of ``burr`` (m)."""
    rng = np.random.default_rng(seed)
    s, z = np.linspace(-2e-3, 2e-3, 161), np.linspace(-4e-3, 4e-3, 33)
    r = np.hypot(*np.meshgrid(s / 1e-3, z / 3e-3))
    r *= 1.0 + 0.15 * np.cos(3.0 * np.arctan2(*np.meshgrid(z, s, indexing="ij")) + rng.uniform(0.0, 6.0))
    depth = np.where(r < 1.0, np.abs(4e-5 * (1.0 - r**4) + rng.normal(0.0, 2e-6, r.shape)), 0.0)
    depth -= np.where((r >= 1.0) & (r < 1.1), burr, 0.0)
    return ScannedDefect(f"scan {seed} {burr}", s, z, depth)


def brute_force(profile, s, R, reach=1e-3):
    """h(s) = min over t of p(t) + (t - s)^2/(2 R) on a fine grid that has every end and every s on it."""
    ends = profile.pieces[:, :2].ravel()
    t = np.linspace(min(ends.min(), s.min()) - reach, max(ends.max(), s.max()) + reach, 20001)
    t = np.concatenate([t, s, ends, ends - 1e-12, ends + 1e-12])
    p = depth_at(profile, t)
    return np.array([np.min(p + (t - x) ** 2 / (2.0 * R)) for x in s])


SHAPES = {"rectangular": Rectangular, "triangular": Triangular, "circular": Circular}
"""Shapes whose path has a closed form, by their words."""


def section_at(defect, fraction):
    """Return the section at a fraction of the defect's half length; skip examples without a section."""
    _, _, low, high = extent(defect)
    profile = section(defect, (low + high) / 2 + fraction * (high - low) / 2)
    assume(len(profile.pieces))
    return profile
