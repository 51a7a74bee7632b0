"""Describes the moving task on which tools/lab/peers/run_moving.py compares simulators (docs/bench.md, "Peers on a
moving wire").

A wire of 168 mm lies with 15 mm in a vessel. For 3.6 s it is pushed at 35 mm/s and turned at 1 rad/s. These are the
length of CathSim's wire, its inserted length when an episode begins, the duration of its episodes, and the largest feed
of stEVE. The vessel is a tube of 4 mm radius: a straight piece, a bend, a straight piece. It begins at the origin in
the direction +x, and bends towards +z; the introducer sheath lies before the origin. This module needs no simulator.
"""

import math

BODIES, BODY_LENGTH_m = 84, 2e-3
WIRE_m = BODIES * BODY_LENGTH_m
START_m, PUSH_m_per_s, TURN_rad_per_s, DURATION_s, SAMPLES = 0.015, 0.035, 1.0, 3.6, 30
RADIUS_m, STRAIGHT_m, BEND_RADIUS_m, BEND_rad, END_m = 4e-3, 0.03, 0.06, math.radians(75), 0.06
# The physical wire of our core and of the chain in MuJoCo: an Amplatz Stiff (Harrison 2011).
BEND_STIFFNESS_N_m2, MASS_kg_per_m, WIRE_RADIUS_m, FRICTION = 5.21e-4, 4.88e-3, 0.445e-3, 0.2

# In MuJoCo the wall consists of flat staves: so many around the vessel, and so many along the bend. The bend's outside
# is a groove between two staves, and the staves have such a distance from the axis that a wire in the groove lies where
# it would lie in the round tube.
STAVES, BEND_PIECES = 8, 12
APOTHEM_m = WIRE_RADIUS_m + (RADIUS_m - WIRE_RADIUS_m) * math.cos(math.pi / STAVES)
STAVE_THICKNESS_m, OVERLAP_m = 2e-3, 1.5e-3


def axis_pieces():
    """Yields the pieces of the vessel's axis: the start (x, z) in m, the angle in rad of the middle's direction from +x
    towards +z, the length along the axis in m, and the angle in rad by which the piece bends."""
    yield (0.0, 0.0), 0.0, STRAIGHT_m, 0.0
    bend = BEND_rad / BEND_PIECES
    for piece in range(BEND_PIECES + 1):
        angle = piece * bend
        start = (STRAIGHT_m + BEND_RADIUS_m * math.sin(angle), BEND_RADIUS_m * (1 - math.cos(angle)))
        if piece < BEND_PIECES:
            yield start, angle + bend / 2, BEND_RADIUS_m * bend, bend
        else:
            yield start, angle, END_m, 0.0


def staves_of(piece):
    """Yields the boxes of the wall around one piece of the axis (see staves)."""
    (x, z), angle, length, bend = piece
    thick = STAVE_THICKNESS_m / 2
    along = (math.cos(angle), 0.0, math.sin(angle))
    inward = (-math.sin(angle), 0.0, math.cos(angle))  # towards the bend's centre
    chord = 2 * BEND_RADIUS_m * math.sin(bend / 2) if bend else length
    sagitta = BEND_RADIUS_m * (1 - math.cos(bend / 2)) if bend else 0.0
    middle = [start + chord / 2 * a - sagitta * i for start, a, i in zip((x, 0.0, z), along, inward)]
    for stave in range(STAVES):
        around = 2 * math.pi * (stave + 0.5) / STAVES
        outward = (inward[0] * math.cos(around), math.sin(around), inward[2] * math.cos(around))
        to_centre = APOTHEM_m * math.cos(around)
        half = (BEND_RADIUS_m - to_centre) * math.tan(bend / 2) if bend else length / 2
        if to_centre < 0:
            half += OVERLAP_m
        place = tuple(m + (APOTHEM_m + thick) * o for m, o in zip(middle, outward))
        yield place, along, outward, (half, (APOTHEM_m + 2 * thick) * math.tan(math.pi / STAVES), thick)


def staves():
    """Yields the boxes that form the vessel: the place of the middle, the axis along the vessel and the outward axis (3
    numbers each), and the half sizes along, across and outwards, all in m. The boxes on the inside of the bend are
    mitred, so that no edge reaches into the lumen. Those on its outside overlap behind the faces of their neighbours,
    so that no tip catches between two boxes."""
    for piece in axis_pieces():
        yield from staves_of(piece)


def of_our_core():
    """Returns the task as the arguments of our program (peer_moving.c), by name, in SI units."""
    return {
        "start_m": START_m,
        "push_m_per_s": PUSH_m_per_s,
        "turn_rad_per_s": TURN_rad_per_s,
        "duration_s": DURATION_s,
        "samples": SAMPLES,
        "radius_m": RADIUS_m,
        "straight_m": STRAIGHT_m,
        "bend_radius_m": BEND_RADIUS_m,
        "bend_rad": BEND_rad,
        "end_m": END_m,
        "stiffness_N_m2": BEND_STIFFNESS_N_m2,
        "mass_kg_per_m": MASS_kg_per_m,
        "wire_radius_m": WIRE_RADIUS_m,
        "wire_m": WIRE_m,
        "element_m": BODY_LENGTH_m,
        "friction": FRICTION,
    }
