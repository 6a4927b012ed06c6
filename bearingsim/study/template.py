"""The study that `bearingsim new` writes."""

SCHEMA_FILE = "study.schema.json"
"""Name of the schema beside a study, by which editors complete and check it."""

NEW_STUDY = (
    f"# yaml-language-server: $schema=./{SCHEMA_FILE}\n"
    + """\
# A parametric study. Check it with `bearingsim check FILE`, run it with `bearingsim run FILE`.
# Every quantity carries its unit. Lines that begin with # show what else may be said, at its default.

study: defect-length              # names the results folder

# The machine
bearing: nf308                    # a name in configs/bearings, a path to such a file, or a mapping in place
# rig: bvt5                       # the bracket that holds the outer ring, and the sensor
#                                 # `rig: {ring: {bends: true}}`: an outer ring that bends (static, rollers)
speed: 1800 rpm                   # of the inner ring
load: 150 N                       # radial
# load_across: 0 N                # a second load, across it
# clearance: 0 um                 # diametral, in operation; negative is preload; or a class such as CN or C3

# The damage. Several defects: `defects:` with a list, reached as defects.1.width. None: a healthy bearing.
defect:
  race: outer                     # or inner (turns with the ring), or roller, with its number: `roller: 3`
  shape: circular                 # rectangular, triangular, circular, elliptical, spall; or scan, with its `file:`
  length: 3 mm                    # along the roller
  width: 0.8 mm                   # along rolling
  depth: 0.05 mm
  angle: 0 deg                    # from the most loaded position
  # offset: 0 mm                  # of its middle from the roller's, along the axis; off it, rollers tilt (spatial)
  # edge: {radius: 20 um}         # or {ramp: 50 um}; sharp without it
# excitation: envelope            # how it is felt; or half-sine-pulse, clearance-increase, soft-edge, ...

# What varies: the product of the entries, the last one fastest. Values are a list, or
# {linspace: [from, to, how many]}, {logspace: [from, to, how many]}, {range: [from, to, step]}.
sweep:
  defect.length: [3 mm, 6 mm, 9 mm, 12 mm]
  load: {linspace: [150 N, 300 N, 3]}
  # zip: {defect.width: [0.2 mm, 0.4 mm], defect.depth: [0.02 mm, 0.05 mm]}   # moves several together
  # zip: {model: [impulse, ring, rollers], excitation: [impulse-train, half-sine-pulse, envelope]}
  # sobol: {n: 64, over: {defect.width: [0.2 mm, 2 mm], load: {log: [50 N, 500 N]}}}   # or lhs, saltelli, morris
  # derived: {defect.depth: defect.width / 16}      # follows from other values
  # where: [defect.length > 2 * defect.width]       # leaves out the other combinations

# The model
# model: rollers                  # impulse, static, ring, rollers, planar, spatial, or reference
# accuracy: 2 %                   # in place of `model`: the cheapest that is so close to the reference
# method: auto                    # verlet, dop853, rodas, backward-euler; for comparison rk4, nystrom, ...
# step: auto                      # or a time such as 0.5 us
# tolerance: auto                 # of dop853, rodas, backward-euler, dormand-prince: a number such as 1e-4
# step_check: true                # try the step on the run's beginning; `false` trusts it, `strict`
#                                 # also refuses a chaotic record too short for its RMS to be worth 1 %
# periodic: true                  # a motion that repeats itself is computed once; `false` computes all of it
# until: 0.5 %                    # with `record: []`: end as soon as line and RMS are known so well
# contact:
#   stiffness: palmgren           # or iso16281, johnson; point for balls; {law: constant, ...}
#   damping: {law: kraemer, beta: 2.5 us}  # or {law: hunt-crossley, chi: 50 s/m}, film, loss-factor, general, none

# What only the planar model can: slip, cage, changing speed
# friction: static-dynamic        # or traction, none, or {law: static-dynamic, static: 0.3, dynamic: 0.15}
# cage: {pocket_clearance: 0.2 mm, guide: centred}          # guide: rollers, inner-ring or outer-ring frees it
# drag: {oil_fraction: 0.1, oil_viscosity: 0.05 Pa s}       # none without it
# ramp: {to: 3000 rpm, time: 1 s}                           # from `speed`
# gravity: false
# shaft: {stiffness: 1e8 N/m, mass: 1 kg}                   # rigid without it
# unbalance: {mass_radius: 100 g mm}
# seed: 0                                                   # of what is random

# What only the spatial model can: tilt and skew
# misalignment: {inner: 0.2 mrad, direction: 0 deg}         # none without it
# A `rig` with axial_stiffness and tilting_stiffness lets the outer ring lean; a `shaft` with them the inner one.

# What only static and rollers can: an outer ring that bends
# A `rig` with `ring: {bends: true}` lets it bend. Its `load` says where the load enters, at the load line without
# it: {by: pads, angles: [-45 deg, 45 deg]}, {by: points, at: [{angle: 0 deg, stiffness: 1e8 N/m}]}, or
# {by: housing, stiffness: 1e10 N/m/m, fit: 0 um}; and `sensor: {on: ring, angle: 0 deg}` where the sensor sits.

# The record
duration: 1 s                     # after settling
# settle: auto                    # run before anything is recorded; with drag take 0.3 s, with gross slip 1 s
# sampling: 10240 Hz              # of the stored series, after a low-pass; `antialias: false` picks raw values
record: [ring.velocity]           # also ring.displacement, roller.3.outer_force, cage.slip, ...

figures:
  - {y: velocity@BPFO, x: defect.length, by: load}

# What is not known, tried: bands in figures, `error.damping` in the table; clearance, bracket, support
# uncertainty: {damping: [0.5 us, 10 us]}                   # c/k of a contact; `none`: not even on a few jobs

# A reduced study for a first look: `bearingsim run FILE --quick`
quick:
  duration: 0.3 s
  sweep: {load: [150 N]}
"""
)
