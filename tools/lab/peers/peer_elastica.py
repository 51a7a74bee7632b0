#!/usr/bin/env python3
"""Simulates the rod of docs/bench.md ("Peers") in PyElastica as a Cosserat rod. The time integration of PyElastica is
explicit, so shear waves across the rod's radius limit the time step.

  peer_elastica.py free WARM_STEPS TIMED_STEPS [STEP_us]

Prints one line of key=value pairs. Needs the package pyelastica.

A time step of 0.2 us is stable. A step of 0.25 us is unstable: with this step, length_error_pct reaches thousands
within 8,000 steps. A simulated second takes minutes. The rod is therefore timed while it starts to fall and not at
rest; its tip is printed as `nan`, and its accuracy counts as perfect.
"""

import importlib.metadata
import math
import sys
import time

import elastica
import numpy

ELEMENTS, LENGTH_M, RADIUS_M = 256, 0.5, 0.445e-3
YOUNG_PA, POISSON, DENSITY_KG_M3, DRAG_PER_S, STEP_us = 60e9, 0.3, 7850.0, 20.0, 0.2
CHUNK_STEPS = 100


class Simulator(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping):
    """Combines those features of the simulator PyElastica that the scene of the benchmark needs."""


def make_rod(step_s):
    simulator = Simulator()
    rod = elastica.CosseratRod.straight_rod(
        ELEMENTS,
        numpy.zeros(3),
        numpy.array([1.0, 0, 0]),
        numpy.array([0, 0, 1.0]),
        LENGTH_M,
        RADIUS_M,
        DENSITY_KG_M3,
        youngs_modulus=YOUNG_PA,
        shear_modulus=YOUNG_PA / (2 * (1 + POISSON)),
    )
    simulator.append(rod)
    simulator.constrain(rod).using(elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    simulator.add_forcing_to(rod).using(elastica.GravityForces, acc_gravity=numpy.array([0, 0, -9.81]))
    simulator.dampen(rod).using(elastica.AnalyticalLinearDamper, uniform_damping_constant=DRAG_PER_S, time_step=step_s)
    simulator.finalize()
    return simulator, rod


def run(warm, timed, step_us):
    step_s = numpy.float64(step_us * 1e-6)
    simulator, rod = make_rod(step_s)
    stepper, now = elastica.PositionVerlet(), numpy.float64(0)
    for _ in range(warm):
        now = stepper.step(simulator, now, step_s)
    per_ms_us = []
    for _ in range(max(1, timed // CHUNK_STEPS)):
        start = time.perf_counter_ns()
        for _ in range(CHUNK_STEPS):
            now = stepper.step(simulator, now, step_s)
        per_ms_us.append((time.perf_counter_ns() - start) / 1e3 / CHUNK_STEPS * (1000 / step_us))
    print(
        "code=pyelastica version=%s scene=free step_us=%g us_per_ms_min=%.4f us_per_ms_median=%.4f contacts=0 "
        "length_error_pct=%.5f tip_x_mm=nan tip_z_mm=nan elements=%d bend_N_m2=%.6g mass_g_per_m=%.5g friction=nan "
        "drag_per_s=%g"
        % (
            importlib.metadata.version("pyelastica"),
            step_us,
            min(per_ms_us),
            numpy.median(per_ms_us),
            (rod.lengths.sum() / LENGTH_M - 1) * 100,
            ELEMENTS,
            YOUNG_PA * math.pi * RADIUS_M**4 / 4,
            DENSITY_KG_M3 * math.pi * RADIUS_M**2 * 1e3,
            DRAG_PER_S,
        )
    )


def main():
    numbers = sys.argv[2:]
    if len(numbers) not in (2, 3) or sys.argv[1] != "free" or not all(n.isdigit() for n in numbers[:2]):
        print("usage: peer_elastica.py free WARM_STEPS TIMED_STEPS [STEP_us]", file=sys.stderr)
        return 2
    run(int(numbers[0]), int(numbers[1]), float(numbers[2]) if len(numbers) == 3 else STEP_us)
    return 0


if __name__ == "__main__":
    sys.exit(main())
