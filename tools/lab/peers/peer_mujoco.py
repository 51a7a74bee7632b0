#!/usr/bin/env python3
"""Simulates the rod of docs/bench.md ("Peers") in MuJoCo as a 1D flex, that is, a discrete elastic rod with one twist
angle per edge.

  peer_mujoco.py free|tube SETTLE_TICKS TIMED_TICKS

Prints one line of key=value pairs. The program needs the Python package mujoco (4.x, or 3.17 and later for the rod's
bending).

All choices favour the peer. The integrator `discrete` treats bending implicitly. No other integrator is stable with
this rod at time steps of 1 ms. Of MuJoCo's solvers, the Newton solver is the fastest for the rod of the benchmark.
Eight planes form the tube; planes are faster than a mesh, and exact for a straight tube. The rod is at rest, so the
solver starts each step with the correct solution. Equality constraints on the edges of MuJoCo's flex keep the length of
the rod. With the default impedance of the edges' constraints, the hanging rod is 8 % too long. With the `solimp` below,
the rod's length error is only 0.07 %, and the simulation is no slower.
"""

import math
import sys
import time

import mujoco
import numpy

ELEMENTS, LENGTH_M, RADIUS_M, TUBE_RADIUS_M = 256, 0.5, 0.445e-3, 1.5e-3
YOUNG_PA, POISSON, DENSITY_KG_M3, FRICTION, DRAG_PER_S, STEP_S = 60e9, 0.3, 7850.0, 0.2, 20.0, 1e-3
PLANES = 8
# The first edge is clamped, so bending begins in the middle of this edge, which is placed at x = 0.
SPACING_M = LENGTH_M / (ELEMENTS - 0.5)
MASS_KG_M = DENSITY_KG_M3 * math.pi * RADIUS_M**2
EDGE = 'solref="0.002 1" solimp="0.999 0.9999 0.001 0.5 2"'
CONTACT = 'condim="3" friction="%g 0 0" solref="0.002 1"' % FRICTION


def tube_planes():
    """Yields the planes that form the tube; all normals point to the tube's axis. The first of the planes around the
    rod is below the rod."""
    for k in range(PLANES):
        angle = 2 * math.pi * k / PLANES
        normal = (0.0, math.sin(angle), math.cos(angle))
        place = " ".join("%.9g" % (-TUBE_RADIUS_M * n) for n in normal)
        yield '<geom type="plane" size="1 1 0.1" pos="%s" zaxis="%s" %s/>' % (
            place,
            " ".join("%.9g" % n for n in normal),
            CONTACT,
        )


def make_model(in_tube):
    text = """<mujoco>
  <option timestep="%g" integrator="discrete" solver="Newton" gravity="0 0 -9.81"/>
  <worldbody>%s
    <flexcomp name="rod" type="grid" dim="1" count="%d 1 1" spacing="%.12g 1 1"
        pos="%.12g 0 0" radius="%g" mass="%.12g">
      <pin id="0 1"/><edge equality="true" %s/>
      <elasticity young="%g" poisson="%g"/><contact selfcollide="none" %s/>
    </flexcomp>
  </worldbody></mujoco>""" % (
        STEP_S,
        "".join(tube_planes()) if in_tube else "",
        ELEMENTS + 1,
        SPACING_M,
        SPACING_M * (ELEMENTS - 1) / 2,
        RADIUS_M,
        MASS_KG_M * SPACING_M * (ELEMENTS + 1),
        EDGE,
        YOUNG_PA,
        POISSON,
        CONTACT,
    )
    model = mujoco.MjModel.from_xml_string(text)
    # Half an element belongs to the tip node; the drag of 20/s acts on every node, not on the twist.
    tip = model.flex_vertbodyid[ELEMENTS]
    model.body_mass[tip] /= 2
    model.body_inertia[tip] /= 2
    for dof in range(model.nv):
        if model.jnt_type[model.dof_jntid[dof]] == mujoco.mjtJoint.mjJNT_SLIDE:
            model.dof_damping[dof] = DRAG_PER_S * model.body_mass[model.dof_bodyid[dof]]
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def run(scene, settle, timed):
    model = make_model(scene == "tube")
    data = mujoco.MjData(model)
    for _ in range(settle):
        mujoco.mj_step(model, data)
    times_us = []
    for _ in range(timed):
        start = time.perf_counter_ns()
        mujoco.mj_step(model, data)
        times_us.append((time.perf_counter_ns() - start) / 1e3)
    edges = numpy.asarray(data.flexedge_length)
    # Positions belong to the state before the last step; at rest that is the same place.
    tip_mm = numpy.asarray(data.flexvert_xpos)[ELEMENTS] * 1e3
    print(
        "code=mujoco version=%s scene=%s step_us=%g us_per_ms_min=%.4f us_per_ms_median=%.4f contacts=%d "
        "length_error_pct=%.5f tip_x_mm=%.4f tip_z_mm=%.4f elements=%d bend_N_m2=%.6g mass_g_per_m=%.5g friction=%g "
        "drag_per_s=%g"
        % (
            mujoco.__version__,
            scene,
            STEP_S * 1e6,
            min(times_us),
            numpy.median(times_us),
            data.ncon,
            (edges.sum() / (ELEMENTS * SPACING_M) - 1) * 100,
            tip_mm[0],
            tip_mm[2],
            ELEMENTS,
            YOUNG_PA * math.pi * RADIUS_M**4 / 4,
            MASS_KG_M * 1e3,
            FRICTION,
            DRAG_PER_S,
        )
    )


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in ("free", "tube") or not all(n.isdigit() for n in sys.argv[2:]):
        print("usage: peer_mujoco.py free|tube SETTLE_TICKS TIMED_TICKS", file=sys.stderr)
        return 2
    run(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
