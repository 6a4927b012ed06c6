"""Glossary of words that are not keys of a study: quantities that are not modelled, results, and synonyms.

It has priority over the suggestion of a similarly spelt key, which would be another quantity.
"""

from collections.abc import Collection

from bearingsim.text.units import suggestion

_GROUPS: dict[tuple[str, ...], str] = {
    # not modelled, with the closest alternative
    ("contact_angle", "angular_contact", "pressure_angle"): (
        "all models have contact angle 0; only `bearingsim freq` uses a contact angle"
    ),
    ("axial_load", "load_axial", "thrust", "thrust_load", "axial_force"): (
        "no model has an axial load: `load` and `load_across` are radial"
    ),
    ("moment", "moment_load", "tilting_moment", "load_moment"): (
        "no model has a moment load; `misalignment: {inner: 0.5 mrad}` tilts a ring (`model: spatial`)"
    ),
    ("rows", "row", "number_of_rows", "double_row", "multi_row"): "every bearing has a single row of elements",
    ("tapered", "conical", "taper", "spherical", "barrel", "toroidal"): (
        "elements are cylindrical rollers or balls; no model has tapered, spherical or toroidal rollers"
    ),
    ("outer_speed", "outer_ring_speed", "speed_outer"): (
        "only the inner ring rotates, at `speed`; `bearingsim freq --outer-speed` accepts that of the outer ring"
    ),
    (
        "torque",
        "driving_torque",
        "motor",
        "power",
    ): "the speed is prescribed, not the torque: `speed`, or a `ramp`",
    ("grease", "lubricant", "lubrication", "greased"): (
        "no model has grease: oil acts as `drag` (`model: planar`) and in the damping law `film`"
    ),
    ("lubricant_temperature", "oil_temperature", "grease_temperature"): (
        "use `contact: {damping: {law: film, oil: VG 68, temperature: 55 C}}`"
    ),
    ("film_thickness", "ehl", "oil_film", "lambda_ratio"): (
        "the film's thickness is computed: `contact: {damping: {law: film, oil: VG 68, temperature: 55 C}}`"
    ),
    ("heat", "thermal", "thermal_expansion", "ambient_temperature", "warmth"): (
        "heat is not modelled; `clearance` is the value at operating temperature"
    ),
    ("interference", "shaft_fit", "shrink_fit", "press_fit", "housing_fit"): (
        "`clearance` is the value after mounting; only a flexible ring has a fit, `rig.load.fit` (docs/ring.md)"
    ),
    ("creep", "ring_creep"): (
        "creep of a ring in its seat is not modelled; `model: planar` computes slip of the cage"
    ),
    ("waviness", "out_of_roundness", "form_error", "form"): (
        "use `surfaces: {outer: {spectrum: {amplitude: 0.2 um}}}`"
    ),
    ("roughness", "surface_roughness", "surface_finish"): (
        "roughness is not modelled; `surfaces` has waves up to order 1000"
    ),
    ("tolerance_class", "grade", "class"): (
        "tolerance classes are not supported: give `harmonics` or a `spectrum` in `surfaces`"
    ),
    ("wear", "contamination", "debris", "particles", "current", "corrosion"): (
        "damage does not grow: `defects` are constant during a run"
    ),
    ("crack", "cracks"): "cracks are not modelled: a `defect` is missing material on a race or an element",
    ("noise", "snr", "measurement_noise", "noise_level"): (
        "records contain no noise; add it to `results.series(job)` in Python"
    ),
    ("cage_material", "cage_stiffness", "flexible_cage"): (
        "the cage is a rigid body: `cage: {mass: 50 g, pocket_stiffness: 1e7 N/m}` (`model: planar`)"
    ),
    ("rotor", "flexible_shaft", "shaft_length", "shaft_diameter", "shaft_stiffness"): (
        "a shaft is a rigid mass on a spring: `shaft: {stiffness: 1e8 N/m, mass: 1 kg}` (`model: planar`)"
    ),
    ("gear", "gears", "belt", "coupling", "blade"): "only the bearing, its rig and shaft are modelled",
    ("life", "l10", "fatigue", "rating", "load_rating"): (
        "fatigue life is not computed; `check` warns of a load above the static rating"
    ),
    ("resonance", "natural_frequency", "eigenfrequency", "modes"): (
        "resonances follow from masses and stiffnesses: `rig: {ring_mass: 0.5 kg, bracket_stiffness: 1e7 N/m}`"
    ),
    # results
    ("slip", "cage_slip", "skidding"): (
        "slip is a result, not an input: `model: planar` computes it, `record: [cage.slip]` shows it"
    ),
    ("skew", "roller_tilt", "roller_skew"): (
        "a roller's tilt and skew are results: `record: [roller.1.tilt, roller.1.skew]` (`model: spatial`)"
    ),
    ("bpfo", "bpfi", "bsf", "ftf", "defect_frequency", "fault_frequency"): (
        "characteristic frequencies follow from the bearing and `speed`: `bearingsim freq` prints them"
    ),
    ("cage_speed", "ftf_speed"): "the cage's speed is a result: `record: [cage.speed]` (`model: planar`)",
    ("load_zone", "load_distribution"): "the load zone is a result: `record: [load_zone.rollers]`",
    # synonyms
    ("preload", "pretension", "radial_preload"): "a preload is a negative clearance: `clearance: -5 um`",
    ("clearance_class", "internal_clearance", "radial_clearance", "play"): "use `clearance: C3`, or a length",
    ("rpm", "shaft_speed", "inner_speed", "rotational_speed", "rotation_speed", "omega"): "use `speed: 1800 rpm`",
    ("rpm_profile", "speed_profile", "run_up", "runup", "run_down", "coast_down", "speed_ramp"): (
        "the speed can change once, linearly: `ramp: {to: 3000 rpm, time: 1 s}` (`model: planar`)"
    ),
    ("radial_load", "load_radial", "force"): "use `load: 150 N`",
    ("crown", "crowning", "crowned", "profile", "crown_drop"): (
        "a roller's profile belongs to its bearing, as `roller_profile: {shape: crowned, drop: 5 um}`"
    ),
    ("housing", "pedestal", "support"): (
        "use `rig: {bracket_stiffness: 1e7 N/m}`, or let the outer ring bend in a housing (docs/ring.md)"
    ),
    ("flexible_ring", "elastic_ring", "ring_flexibility", "outer_ring"): "use `rig: {ring: {bends: true}}`",
    ("imbalance", "eccentricity", "mass_imbalance"): (
        "use `unbalance: {mass_radius: 100 g mm}` with a `shaft` (`model: planar`)"
    ),
    ("pit", "spall", "dent", "fault", "damage", "flaw", "slot"): (
        "use `defect: {shape: rectangular, length: 3 mm, width: 0.8 mm, depth: 50 um}`"
    ),
    ("balls", "ball_count", "number_of_balls", "number_of_rollers", "n_balls", "roller_count", "z"): (
        "the number of elements is `rollers`, also for balls"
    ),
    ("ball_diameter", "element_diameter", "rolling_element_diameter", "d_w", "dw"): (
        "the element diameter is `roller_diameter`, also for balls"
    ),
    ("d_m", "dm", "pitch_circle", "pcd"): "the pitch circle diameter is `pitch_diameter`",
    ("inner_diameter", "inside_diameter", "bore_diameter"): "a bearing's inner diameter is `bore`",
    ("outer_diameter", "od"): "a bearing's outer diameter is `outside_diameter`",
    ("groove_radius", "osculation", "conformity", "curvature_ratio"): (
        "a ball bearing has the lengths `inner_groove_radius` and `outer_groove_radius`"
    ),
    ("roller_mass", "ball_mass", "element_mass"): (
        "the mass of an element follows from its dimensions and the `density` of the material"
    ),
    ("youngs_modulus", "e_modulus", "elastic_modulus", "modulus", "elasticity"): (
        "a bearing's `material` has `young_modulus`, a pressure such as 207 GPa"
    ),
    ("friction_coefficient", "mu", "coefficient_of_friction"): (
        "use `friction: {static: 0.3, dynamic: 0.15}` (`model: planar`)"
    ),
    ("sample_rate", "sampling_rate", "sampling_frequency", "fs"): "use `sampling: 10240 Hz`",
    ("dt", "time_step", "timestep"): "use `step: 0.5 us`, or `auto`; the step of a record follows from `sampling`",
    ("end_time", "t_end", "record_length", "simulation_time"): "use `duration: 1 s`",
    ("lhs", "sobol", "saltelli", "morris", "derived", "where", "zip", "repeat"): "it is a key of `sweep`",
    ("solver", "integrator"): "use `method: auto`, or the name of a method",
    ("rtol", "atol", "reltol", "abstol"): "use `tolerance: 1e-4`, with an adaptive `method`",
    (
        "filter",
        "lowpass",
        "cutoff",
    ): "records are low-pass filtered for their `sampling` unless `antialias: false`",
}

EXPLANATIONS = {word: sentence for words, sentence in _GROUPS.items() for word in words}
"""Explanation of each word."""


def explanation(word: str) -> str:
    """Explain a word, ignoring its case, with hyphens or blanks for underscores; empty if not in the glossary."""
    return EXPLANATIONS.get(word.lower().replace("-", "_").replace(" ", "_"), "")


def advice(word: str, words: Collection[str]) -> str:
    """Explain a word that is not in ``words``, or suggest a similar one; empty if neither is possible."""
    return explanation(word) or suggestion(word, words)
