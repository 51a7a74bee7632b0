"""The settings of the peers that run_moving.py tries, and the gate that tells the right ones from the wrong ones.

A setting is right if its tip stays within 1 mm of a reference run, no contact is deeper than 0.1 mm, the wire keeps
its length to 0.5 %, and the solver gives no warning. The reference run has a quarter of the step. Aids that come with a
long step (added damping, added armature, soft contact) are also divided by 4 there, because they must vanish with the
step.
"""

import math

LIMITS = {"tip_mm": 1.0, "penetration_mm": 0.1, "length_error_pct": 0.5, "warnings": 0}
DIVISOR = 4
DIVIDED = ("step_s", "solref_s", "damping_s", "armature_kg_m2", "twist_armature_kg_m2")
BAR = 15.0
HARD, FIRM = (0.9999, 0.9999), (0.99, 0.999)


def cathsim(step_ms, integrator="Euler", jacobian="dense", **more):
    return dict({"step_s": step_ms * 1e-3, "integrator": integrator, "jacobian": jacobian}, **more)


def chain(step_ms, armature_kg_m2, damping_steps=8.0, integrator="discrete", solimp=HARD, twist_kg_m2=0.0, **more):
    step_s = step_ms * 1e-3
    setting = {"step_s": step_s, "integrator": integrator, "solref_s": 2 * step_s, "solimp": solimp}
    setting.update(armature_kg_m2=armature_kg_m2, damping_s=damping_steps * step_s, twist_armature_kg_m2=twist_kg_m2)
    return dict(setting, **more)


# (peer, setting, whether it counts: settings that change the physics of a wire have no bar)
CANDIDATES = (
    ("cathsim", cathsim(4, "implicitfast", "sparse"), True),  # as shipped
    ("cathsim", cathsim(4), True),
    ("cathsim", cathsim(8), True),
    ("cathsim", cathsim(12), True),
    ("cathsim", cathsim(24), True),
    ("cathsim", cathsim(8, jacobian="sparse"), True),
    ("cathsim", cathsim(8, solver="CG"), True),
    ("cathsim", cathsim(8, "discrete"), True),
    ("cathsim", cathsim(4, margin_m=0.0), True),
    ("cathsim", cathsim(8, margin_m=0.003), True),
    ("cathsim", cathsim(10, margin_m=0.003), True),
    ("cathsim", cathsim(12, margin_m=0.003), True),
    ("cathsim", cathsim(8, margin_m=0.0025), True),
    ("cathsim", cathsim(12, damping_N_m_s=0.5), False),
    ("cathsim", cathsim(8, margin_m=0.003, damping_N_m_s=0.5), False),
    ("cathsim", cathsim(8, margin_m=0.003, fluid=False), False),
    ("chain", chain(1, 0.0, 0.0), True),
    ("chain", chain(1, 1e-3), True),
    ("chain", chain(2, 1e-3), True),
    ("chain", chain(2, 1e-2, 4.0, "implicitfast", FIRM, 1e-3), True),
    ("chain", chain(6, 2e-2, twist_kg_m2=1e-4), True),
    ("chain", chain(6, 2e-2, twist_kg_m2=1e-3), True),
    ("chain", chain(7.5, 2e-2, solimp=FIRM, twist_kg_m2=1e-2), True),
    ("chain", chain(8, 2.5e-2, 20.0, twist_kg_m2=1e-2), True),
    ("chain", chain(10, 3e-2, 20.0, twist_kg_m2=3e-2, solref_s=0.01), True),
    ("chain", chain(12, 3e-2, 40.0, twist_kg_m2=3e-2), True),
    ("chain", chain(6, 2e-2, twist=False), False),
    ("chain", chain(8, 2.5e-2, 20.0, twist=False), False),
    ("chain", chain(10, 3e-2, 20.0, solref_s=0.01, twist=False), False),
    ("chain", chain(12, 3e-2, 40.0, twist=False), False),
)


def reference(setting):
    """Returns the setting of the reference run."""
    return {key: value / DIVISOR if key in DIVIDED else value for key, value in setting.items()}


def tip_difference_mm(tips_mm, others_mm):
    """Returns the largest distance between the places of two tips at equal times; infinite if one run is shorter, or a
    place is no number."""
    if len(tips_mm) != len(others_mm) or not tips_mm:
        return math.inf
    distances = [math.dist(one, other) for one, other in zip(tips_mm, others_mm)]
    return max(distances) if all(math.isfinite(distance) for distance in distances) else math.inf


def faults(figures):
    """Returns the names of the limits that the figures exceed, in the order of LIMITS. A figure that is missing or is
    no number exceeds its limit."""
    return [name for name, limit in LIMITS.items() if not figures.get(name, math.inf) <= limit]


def faults_alone(figures):
    """Returns the faults that show without a reference run."""
    return [name for name in faults(figures) if name != "tip_mm"]


def speed(figures):
    """Returns the simulated seconds per second of a processor."""
    return figures["simulated_s"] / figures["processor_s"]


def fastest_right(rows, peer, counts=True):
    """Returns the peer's fastest row that is right and counts (or does not count), or None."""
    right = [row for row in rows if row["peer"] == peer and row["counts"] == counts and not row["faults"]]
    return max(right, key=lambda row: speed(row["figures"]), default=None)


def verdict(row):
    """Returns the verdict in words."""
    if row["faults"]:
        return "wrong: " + ", ".join(row["faults"])
    return "right" if row["counts"] else "right, but changed physics: no bar"


def words_of(setting):
    """Returns the setting as one text."""
    text = "%g ms, %s" % (setting["step_s"] * 1e3, setting["integrator"])
    forms = (
        ("jacobian", "%s"),
        ("solver", "%s"),
        ("margin_m", "margin %g m"),
        ("damping_N_m_s", "hinges damped by %g N m s"),
        ("fluid", "fluid %s"),
        ("armature_kg_m2", "armature %g"),
        ("twist_armature_kg_m2", "%g"),
        ("damping_s", "damping %.3g s"),
        ("solimp", "solimp %g"),
        ("twist", "twist %s"),
    )
    for key, form in forms:
        if key in setting:
            value = setting[key][0] if key == "solimp" else setting[key]
            text += ", " + form % (("yes" if value else "no") if isinstance(value, bool) else value)
    return text
