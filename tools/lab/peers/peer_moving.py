#!/usr/bin/env python3
"""Simulates the moving task (moving_task.py) in MuJoCo, with one wire of moving_models.py and one setting.

  peer_moving.py cathsim|chain SETTING [SECONDS]

SETTING is a JSON object (moving_models.py). Prints one line of key=value pairs. The processor time is that of the steps
alone. The run ends early when its steps took more than SECONDS of processor time (default 400). The program needs the
Python package mujoco 4.
"""

import json
import math
import os
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import mujoco  # noqa: E402
import numpy  # noqa: E402

import moving_models as models  # noqa: E402
import moving_task as task  # noqa: E402


def start(model):
    data = mujoco.MjData(model)
    data.ctrl[:] = (models.DRIVE_N_s_per_m * task.PUSH_m_per_s, models.DRIVE_N_m_s * task.TURN_rad_per_s)
    data.qvel[:2] = (task.PUSH_m_per_s, task.TURN_rad_per_s)
    return data


def length_error_pct(model, data):
    """Returns how far the distances between neighbouring hinges are from 2 mm, summed over the wire, in % of it."""
    first = next(k for k in range(1, model.nbody) if model.body_parentid[k] == 0)
    joints = [model.body_jntadr[body] for body in range(first + 1, model.nbody)]
    length = numpy.linalg.norm(numpy.diff(data.xanchor[joints], axis=0), axis=1).sum()
    return abs(length / ((len(joints) - 1) * task.BODY_LENGTH_m) - 1) * 100


def run(name, setting, limit_s):
    """Returns the places of the tip in mm at equal intervals of the task, and what happened on the way."""
    model = mujoco.MjModel.from_xml_string(models.MODELS[name](setting))
    sheath = models.Sheath(model, setting) if name == "chain" else None
    data = start(model)
    steps = round(task.DURATION_s / task.SAMPLES / setting["step_s"])
    tips_mm, spent_s, depth_m, contacts, error_pct = [], 0.0, 0.0, 0, 0.0
    while len(tips_mm) < task.SAMPLES and spent_s < limit_s:
        for _ in range(steps):
            if sheath:
                sheath.release(data.qpos[0])
            begin = time.process_time()
            mujoco.mj_step(model, data)
            spent_s += time.process_time() - begin
            if data.ncon:
                depth_m, contacts = max(depth_m, -data.contact.dist.min()), max(contacts, data.ncon)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        tips_mm.append([value * 1e3 for value in data.site("tip").xpos])
        error_pct = max(error_pct, length_error_pct(model, data))
    figures = {
        "simulated_s": len(tips_mm) * task.DURATION_s / task.SAMPLES,
        "processor_s": spent_s,
        "penetration_mm": depth_m * 1e3,
        "length_error_pct": error_pct if math.isfinite(error_pct) else 100.0,
        "warnings": sum(warning.number for warning in data.warning),
        "contacts": contacts,
    }
    return tips_mm, figures


def main():
    if len(sys.argv) not in (3, 4) or sys.argv[1] not in models.MODELS:
        print("usage: peer_moving.py %s SETTING [SECONDS]" % "|".join(models.MODELS), file=sys.stderr)
        return 2
    limit_s = float(sys.argv[3]) if len(sys.argv) == 4 else 400.0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # MuJoCo writes a log of its warnings into the current folder
        tips_mm, figures = run(sys.argv[1], json.loads(sys.argv[2]), limit_s)
        os.chdir(os.sep)
    words = ["version=" + mujoco.__version__]
    words += ["%s=%.6g" % item for item in figures.items()]
    words.append("tips_mm=" + ";".join(",".join("%.4f" % value for value in tip) for tip in tips_mm))
    print(" ".join(words))
    return 0


if __name__ == "__main__":
    sys.exit(main())
