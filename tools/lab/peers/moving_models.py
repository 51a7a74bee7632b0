"""Builds the peers' wires for the moving task (moving_task.py) as MuJoCo models in XML.

`cathsim` is the wire of the simulator CathSim (commit adfabb2), rebuilt from its published parameters: 80 capsules and
a curved tip of 4, 2 mm apart, on two hinges each. Its stiffness, armature (rotor inertia added to a hinge), damping,
density, fluid forces and contact margin are CathSim's. `chain` consists of as many bodies, with the mass, the friction
and the stiffness of a real wire in bending and in twist (CathSim's wire cannot twist). In both, the task moves the
first body: its slide and its hinge have a strong damper and a motor that overcomes it at the task's speed, so that the
wall cannot slow the feed.

A setting is a dictionary: step_s, integrator, solver, jacobian; margin_m, damping_N_m_s and fluid of `cathsim`;
armature_kg_m2, twist_armature_kg_m2, damping_s (time constant of the hinges), solref_s, solimp and twist of `chain`.
"""

import math

import moving_task as task

DRIVE_N_s_per_m, DRIVE_N_m_s = 1e6, 1e2
RADIUS_m, HALF_m, DENSITY_kg_m3, ARMATURE_kg_m2 = 0.5e-3, 0.75e-3, 672.0, 0.05
STIFFNESS_N_m, SOFTENING = 20.0, 0.995  # of the first hinge, and from each hinge to the next one
TIP_BODIES, TIP_N_m, TIP_DAMPING_N_m_s, TIP_rad = 4, 1.0, 0.5, math.pi / 3
FLUID_kg_m3, VISCOSITY_Pa_s, MARGIN_m = 1055.0, 0.004, 0.004
# Of a hinge of the chain; GJ = EI / 1.3, as in our core.
BEND_N_m = task.BEND_STIFFNESS_N_m2 / task.BODY_LENGTH_m
TWIST_N_m = BEND_N_m / 1.3


def numbers(values):
    return " ".join("%.12g" % value for value in values)


def vessel(attributes):
    """Yields the boxes of the vessel's wall."""
    for place, along, outward, sizes in task.staves():
        turned = ((1, 2), (2, 0), (0, 1))
        across = [outward[i] * along[j] - outward[j] * along[i] for i, j in turned]
        yield '<geom type="box" pos="%s" xyaxes="%s %s" size="%s" contype="0" conaffinity="1" %s/>' % (
            numbers(place),
            numbers(along),
            numbers(across),
            numbers(sizes),
            attributes,
        )


def bodies(hinges):
    """Yields the nested bodies of a wire along its local z axis. hinges[k] contains the attributes of the hinges in
    front of body k; body 0 has a slide and a hinge instead. The site `tip` is the end of the last body."""
    first_m = task.START_m - task.WIRE_m + task.BODY_LENGTH_m / 2
    yield '<body pos="%.12g 0 0" euler="0 %.12g 0"><geom/>' % (first_m, math.pi / 2)
    yield '<joint name="slide" type="slide" axis="0 0 1" stiffness="0" damping="%g"/>' % DRIVE_N_s_per_m
    yield '<joint name="turn" type="hinge" axis="0 0 1" stiffness="0" damping="%g"/>' % DRIVE_N_m_s
    for attributes in hinges[1:]:
        joints = "".join("<joint %s/>" % text for text in attributes)
        yield '<body pos="0 0 %.12g"><geom/>%s' % (task.BODY_LENGTH_m, joints)
    yield '<site name="tip" pos="0 0 %.12g"/>' % (task.BODY_LENGTH_m / 2) + "</body>" * len(hinges)


def document(setting, option, defaults, wall, hinges):
    return """<mujoco><compiler angle="radian"/><size memory="256M"/>
<option gravity="0 0 -9.81" timestep="%.9g" integrator="%s" solver="%s" jacobian="%s" %s/>
<default>%s</default>
<worldbody>%s</worldbody>
<actuator><motor joint="slide"/><motor joint="turn"/></actuator></mujoco>""" % (
        setting["step_s"],
        setting["integrator"],
        setting.get("solver", "Newton"),
        setting.get("jacobian", "sparse"),
        option,
        defaults,
        "\n".join([*vessel(wall), *bodies(hinges)]),
    )


def cathsim_hinges(damping_N_m_s):
    hinges, stiffness_N_m = [None], STIFFNESS_N_m
    for _ in range(1, task.BODIES - TIP_BODIES):
        text = 'stiffness="%.9g" damping="%g"' % (stiffness_N_m, damping_N_m_s)
        hinges.append(('axis="1 0 0" ' + text, 'axis="0 1 0" ' + text))
        stiffness_N_m *= SOFTENING
    tip = 'stiffness="%g" damping="%g" springref="%.9g"' % (TIP_N_m, TIP_DAMPING_N_m_s, TIP_rad / TIP_BODIES)
    hinges.append(('axis="0 0 1" ' + tip, 'axis="0 1 0" ' + tip))
    return hinges + [('axis="1 0 0" ' + tip, 'axis="0 1 0" ' + tip)] * (TIP_BODIES - 1)


def cathsim(setting):
    option = 'density="%g" viscosity="%g"' % (FLUID_kg_m3, VISCOSITY_Pa_s) if setting.get("fluid", True) else ""
    defaults = (
        '<geom type="capsule" size="%g %g" density="%g" condim="1" contype="1" conaffinity="0" fluidshape="ellipsoid"/>'
        '<joint type="hinge" pos="0 0 %g" armature="%g"/>'
        % (RADIUS_m, HALF_m, DENSITY_kg_m3, -task.BODY_LENGTH_m / 2, ARMATURE_kg_m2)
    )
    wall = 'condim="1" margin="%g"' % setting.get("margin_m", MARGIN_m)
    return document(setting, option, defaults, wall, cathsim_hinges(setting.get("damping_N_m_s", 0.0)))


def chain_hinges(setting):
    """Returns two hinges that bend and, unless the setting leaves out the twist, one that twists. Armature is added to
    the hinges that bend alone, because it would keep the turn from the tip."""
    damping_s = setting.get("damping_s", 0.0)
    bend = 'stiffness="%.9g" damping="%.9g" armature="%g"' % (
        BEND_N_m,
        BEND_N_m * damping_s,
        setting.get("armature_kg_m2", 0.0),
    )
    hinges = ['axis="1 0 0" ' + bend, 'axis="0 1 0" ' + bend]
    if setting.get("twist", True):
        twist = (TWIST_N_m, TWIST_N_m * damping_s, setting.get("twist_armature_kg_m2", 0.0))
        hinges.append('axis="0 0 1" stiffness="%.9g" damping="%.9g" armature="%g"' % twist)
    return [hinges] * task.BODIES


def chain(setting):
    contact = 'condim="3" friction="%g 0 0" solref="%g 1" solimp="%g %g 0.001"' % (
        task.FRICTION,
        setting["solref_s"],
        *setting["solimp"],
    )
    defaults = (
        '<geom type="capsule" size="%g %g" mass="%.9g" contype="1" conaffinity="0" %s/>'
        '<joint type="hinge" pos="0 0 %g"/>'
        % (
            task.WIRE_RADIUS_m,
            task.BODY_LENGTH_m / 2,
            task.MASS_kg_per_m * task.BODY_LENGTH_m,
            contact,
            -task.BODY_LENGTH_m / 2,
        )
    )
    return document(setting, "", defaults, contact, chain_hinges(setting))


MODELS = {"cathsim": cathsim, "chain": chain}


class Sheath:
    """Holds the part of the chain before the vessel straight: there, the hinges that bend have CathSim's stiffness. So
    the sheath needs no contacts, which favours the peer. A hinge gets the wire's own stiffness when it enters the
    vessel."""

    def __init__(self, model, setting):
        self.model, self.damping_s, self.outside = model, setting.get("damping_s", 0.0), task.BODIES - 1
        self.hinges = 3 if setting.get("twist", True) else 2
        for body in range(1, task.BODIES):
            self.set_hinges(body, STIFFNESS_N_m)

    def set_hinges(self, body, stiffness_N_m):
        first = 2 + self.hinges * (body - 1)  # body 0 has a slide and a hinge
        self.model.jnt_stiffness[first : first + 2] = stiffness_N_m
        self.model.dof_damping[first : first + 2] = stiffness_N_m * self.damping_s

    def release(self, fed_m):
        """Releases the hinges that have passed the origin when the first body has moved by fed_m."""
        while self.outside > 0 and task.START_m + fed_m > (task.BODIES - self.outside) * task.BODY_LENGTH_m:
            self.set_hinges(self.outside, BEND_N_m)
            self.outside -= 1
