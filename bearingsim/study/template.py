"""Template of a study, written by `bearingsim new`."""

SCHEMA_FILE = "study.schema.json"
"""File name of the schema, which editors use to complete and check a study in the same folder."""

SCHEMA_COMMENT = f"# yaml-language-server: $schema=./{SCHEMA_FILE}\n"
"""First line of a study, by which editors find the schema."""

NEW_STUDY = (
    SCHEMA_COMMENT
    + """\
# A parametric study. Check it with `bearingsim check FILE`, run it with `bearingsim run FILE`.
# Quantities have units. Commented lines are optional settings, shown with their defaults.

study: defect-length              # names the results folder

# The machine
bearing: nf308                    # a name in configs/bearings, a path to such a file, or a mapping
# rig: bvt5                       # support of the outer ring, and the sensor
#                                 # `rig: {ring: {bends: true}}`: flexible outer ring (static, rollers)
speed: 1800 rpm                   # of the inner ring
load: 150 N                       # radial
# load_across: 0 N                # a second radial load, perpendicular to `load`
# clearance: 0 um                 # diametral, in operation; negative: preload; or a class such as CN or C3

# The defect. For several, use a list `defects:` (paths such as defects.1.width); omit it for a healthy bearing.
defect:
  race: outer                     # or inner (rotates with the ring), or roller, with its number: `roller: 3`
  shape: circular                 # rectangular, triangular, circular, elliptical, spall; or scan, with its `file:`
  length: 3 mm                    # along the roller
  width: 0.8 mm                   # in the rolling direction
  depth: 0.05 mm
  angle: 0 deg                    # from the most loaded position
  # offset: 0 mm                  # axial distance from the roller's centre; tilts rollers (spatial)
  # edge: {radius: 20 um}         # or {ramp: 50 um}; default: sharp
# excitation: envelope            # geometric path of the roller; or half-sine-pulse, soft-edge, ...

# The sweep: all combinations of the entries, the last one fastest. Values are a list, or
# {linspace: [from, to, count]}, {logspace: [from, to, count]}, {range: [from, to, step]}.
sweep:
  defect.length: [3 mm, 6 mm, 9 mm, 12 mm]
  load: {linspace: [150 N, 300 N, 3]}
  # zip: {defect.width: [0.2 mm, 0.4 mm], defect.depth: [0.02 mm, 0.05 mm]}   # varied together
  # zip: {model: [impulse, ring, rollers], excitation: [impulse-train, half-sine-pulse, envelope]}
  # sobol: {n: 64, over: {defect.width: [0.2 mm, 2 mm], load: {log: [50 N, 500 N]}}}   # or lhs, saltelli, morris
  # derived: {defect.depth: defect.width / 16}      # computed from other values
  # where: [defect.length > 2 * defect.width]       # keeps only these combinations

# The model
# model: rollers                  # impulse, static, ring, rollers, planar, spatial, or reference
# accuracy: 2 %                   # instead of `model`: the cheapest model within 2 % of the reference
# method: auto                    # verlet, dop853, rodas, backward-euler; for comparison rk4, nystrom, ...
# step: auto                      # or a time such as 0.5 us
# tolerance: auto                 # of adaptive methods: a number such as 1e-4
# step_check: true                # check the step at the start of the run; `false`: no check; `strict`: check
#                                 # the whole run, and require an RMS within 1 % if it is chaotic
# periodic: true                  # fill in periodic responses; `false` integrates the whole record
# until: 0.5 %                    # with `record: []`: end once line amplitude and RMS are that accurate
# contact:
#   stiffness: palmgren           # or iso16281, johnson; point for balls; {law: constant, ...}
#   damping: {law: kraemer, beta: 2.5 us}  # or {law: hunt-crossley, chi: 50 s/m}, film, loss-factor, general, none

# Form of surfaces, in all models except impulse. Default: smooth races, equal rollers
# surfaces:
#   outer: {spectrum: {amplitude: 0.2 um}}                  # A n^-1.3, orders 2 to 200; or {roundness: race.csv}
#   inner: {harmonics: [{order: 12, amplitude: 20 nm}]}
#   rollers: {diameter: {scatter: 0.5 um}}
#   seed: 0

# Planar and spatial models only: slip, cage, changing speed
# friction: static-dynamic        # or traction, none, or {law: static-dynamic, static: 0.3, dynamic: 0.15}
# cage: {pocket_clearance: 0.2 mm, guide: centred}          # guide: or rollers, inner-ring, outer-ring
# drag: {oil_fraction: 0.1, oil_viscosity: 0.05 Pa s}       # default: none
# ramp: {to: 3000 rpm, time: 1 s}                           # from `speed`
# gravity: false
# shaft: {stiffness: 1e8 N/m, mass: 1 kg}                   # default: rigid
# unbalance: {mass_radius: 100 g mm}
# seed: 0                                                   # of random initial values and impulses

# Spatial model only: tilt and skew
# misalignment: {inner: 0.2 mrad, direction: 0 deg}         # default: none
# axial_stiffness and tilting_stiffness in `rig` let the outer ring tilt, in `shaft` the inner ring.

# Models static and rollers only: a flexible outer ring, `rig: {ring: {bends: true}}`
# `load` in `rig` defines where the load acts (default: a point load). Use
# {by: pads, angles: [-45 deg, 45 deg]}, {by: points, at: [{angle: 0 deg, stiffness: 1e8 N/m}]}, or
# {by: housing, stiffness: 1e10 N/m/m, fit: 0 um}; `sensor: {on: ring, angle: 0 deg}` places the sensor.

# The record
duration: 1 s                     # after settling
# settle: auto                    # time before the record, for transients to decay; or a time such as 0.3 s
# sampling: 10240 Hz              # of the stored signals, after a low-pass filter; `antialias: false`: unfiltered
record: [ring.velocity]           # also ring.displacement, roller.3.outer_force, cage.slip, ...

figures:
  - {y: velocity@BPFO, x: defect.length, by: load}

# Uncertain parameters (damping, clearance, bracket, support, form, shaft, ring_mass, edge): bands in figures,
# `error.damping` in the table
# uncertainty: {damping: [0.5 us, 10 us]}                   # c/k of a contact; `none`: vary nothing

# Measured features or signals for comparison: open markers in figures, differences in `bearingsim show`
# measured:
#   - {points: line.csv, label: test rig}      # header with units: load [N], velocity@BPFO [um/s]
#   - signals: [{file: run1.wav, at: {load: 150 N}, rate: 51.2 kHz, unit: m/s^2}]

# Reduced study for a first look: `bearingsim run FILE --quick`
quick:
  duration: 0.3 s
  sweep: {load: [150 N]}
"""
)
