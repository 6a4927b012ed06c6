"""The study that `bearingsim new` writes."""

NEW_STUDY = """\
# A parametric study. Check it with `bearingsim check FILE`, run it with `bearingsim run FILE`.
# Every quantity carries its unit. Lines that begin with # show what else may be said, at its default.

study: defect-length              # names the results folder

# The machine
bearing: nf308                    # a name in configs/bearings, a path to such a file, or a mapping in place
# rig: bvt5                       # the bracket that holds the outer ring, and the sensor
speed: 1800 rpm                   # of the inner ring
load: 150 N                       # radial
# clearance: 0 um                 # diametral, in operation; negative is preload

# The damage. Several defects: `defects:` with a list, reached as defects.1.width. None: a healthy bearing.
defect:
  shape: circular                 # rectangular, triangular or circular
  length: 3 mm                    # along the roller
  width: 0.8 mm                   # along rolling
  depth: 0.05 mm
  angle: 0 deg                    # from the most loaded position

# What varies: the product of the entries, the last one fastest. Values are a list, or
# {linspace: [from, to, how many]}, {logspace: [from, to, how many]}, {range: [from, to, step]}.
sweep:
  defect.length: [3 mm, 6 mm, 9 mm, 12 mm]
  load: {linspace: [150 N, 300 N, 3]}
# zip: {defect.width: [0.2 mm, 0.4 mm], defect.depth: [0.02 mm, 0.05 mm]}     # moves several together

# The model
# model: rollers                  # static (equilibrium only), ring (massless rollers) or rollers
# method: verlet                  # or rk4
# step: auto                      # or a time such as 0.5 us
# contact:
#   stiffness: palmgren           # or iso16281
#   damping: {law: hunt-crossley, chi: 50 s/m}      # or {law: kraemer, beta: 10 us}

# The record
duration: 1 s                     # after settling
# settle: 50 ms                   # run before anything is recorded
# sampling: 10240 Hz              # of the stored series, after a low-pass; `antialias: false` picks raw values
record: [ring.velocity]           # also ring.displacement, ring.acceleration, roller.outer_force, ...

figures:
  - {y: velocity@BPFO, x: defect.length, by: load}

# A reduced study for a first look: `bearingsim run FILE --quick`
quick:
  duration: 0.3 s
  sweep: {load: [150 N]}
"""
