"""Makes the pictures of tools/lab/peers/peer_xray.cpp with the program gVirtualXray. The script run_xray_peers.py calls
this script with the Python of its virtual environment.

  peer_gvxr.py FOLDER ROUNDS

Reads FOLDER/scene.json, writes FOLDER/gvxr_V.f32 (transmissions, row 0 on top) and prints one line of key=value pairs.
"""

import json
import os
import statistics
import sys
import time

import numpy
from gvxrPython3 import gvxr

# (element numbers, mass shares, density g/cm3): the compounds of tools/check/make_attenuation.py, as NIST's tables
# have them.
MATERIALS = {
    "soft_tissue": (
        (1, 6, 7, 8, 11, 12, 15, 16, 17, 19, 20, 26, 30),
        (
            0.104472,
            0.23219,
            0.02488,
            0.630238,
            0.00113,
            0.00013,
            0.00133,
            0.00199,
            0.00134,
            0.00199,
            0.00023,
            5e-5,
            3e-5,
        ),
        1.00,
    ),
    "blood": (
        (1, 6, 7, 8, 11, 12, 14, 15, 16, 17, 19, 20, 26, 30),
        (
            0.101866,
            0.10002,
            0.02964,
            0.759414,
            0.00185,
            4e-5,
            3e-5,
            0.00035,
            0.00185,
            0.00278,
            0.00163,
            6e-5,
            0.00046,
            1e-5,
        ),
        1.06,
    ),
    "muscle": (
        (1, 6, 7, 8, 11, 12, 15, 16, 17, 19, 20, 26, 30),
        (0.100637, 0.10783, 0.02768, 0.754773, 0.00075, 0.00019, 0.0018, 0.00241, 0.00079, 0.00302, 3e-5, 4e-5, 5e-5),
        1.04,
    ),
    "lung": (
        (1, 6, 7, 8, 11, 12, 15, 16, 17, 19, 20, 26, 30),
        (
            0.101278,
            0.10231,
            0.02865,
            0.757072,
            0.00184,
            0.00073,
            0.0008,
            0.00225,
            0.00266,
            0.00194,
            9e-5,
            0.00037,
            1e-5,
        ),
        0.26,
    ),
    "adipose": (
        (1, 6, 7, 8, 11, 12, 15, 16, 17, 19, 20, 26, 30),
        (0.119477, 0.63724, 0.00797, 0.232333, 0.0005, 2e-5, 0.00016, 0.00073, 0.00119, 0.00032, 2e-5, 2e-5, 2e-5),
        0.92,
    ),
    "bone_cortical": (
        (1, 6, 7, 8, 12, 15, 16, 20, 30),
        (0.047234, 0.14433, 0.04199, 0.446096, 0.0022, 0.10497, 0.00315, 0.20993, 0.0001),
        1.85,
    ),
    "air": ((6, 7, 8, 18), (0.000124, 0.755267, 0.231781, 0.012827), 0.0012),
}


def load(folder, scene):
    for i, body in enumerate(scene["bodies"]):
        label = "body_%d" % i
        gvxr.loadMeshFile(label, os.path.join(folder, body["file"]), "mm", False)
        elements, shares, density = MATERIALS[body["material"]]
        gvxr.setMixture(label, elements, shares)
        gvxr.setDensity(label, density, "g/cm3")
    gvxr.setDetectorNumberOfPixels(scene["size"], scene["size"])
    gvxr.setDetectorPixelSize(scene["pixel_mm"], scene["pixel_mm"], "mm")
    gvxr.resetBeamSpectrum()
    for energy_keV, share in scene["spectrum"]:  # these are shares of energy; the peer needs numbers of photons
        gvxr.addEnergyBinToSpectrumPerPixelAtSDD(energy_keV, "keV", share / energy_keV)


def look(scene, view):
    gvxr.setSourcePosition(*view["source_mm"], "mm")
    gvxr.usePointSource()
    gvxr.setDetectorPosition(*view["detector_mm"], "mm")
    gvxr.setDetectorUpVector(*view["up"])
    gvxr.setDetectorRightVector(*[-x for x in view["right"]])  # the detector as seen from behind it
    # Bodies inside the outer surface are subtracted from it. The renderer loses that surface when anything else is
    # set afterwards.
    gvxr.removePolygonMeshesFromXRayRenderer()
    for i, body in enumerate(scene["bodies"]):
        if not body["is_outer"]:
            gvxr.addPolygonMeshAsInnerSurface("body_%d" % i)
    for i, body in enumerate(scene["bodies"]):
        if body["is_outer"]:
            gvxr.addPolygonMeshAsOuterSurface("body_%d" % i)


def main():
    folder, rounds = sys.argv[1], int(sys.argv[2])
    with open(os.path.join(folder, "scene.json"), encoding="utf-8") as file:
        scene = json.load(file)
    gvxr.createWindow(-1, False, "EGL")
    load(folder, scene)
    times_ms, processor_ms = [], []
    for repeat in range(rounds + 1):
        for i, view in enumerate(scene["views"]):
            look(scene, view)
            begin, processor_begin = time.perf_counter(), time.process_time()
            picture = numpy.array(gvxr.computeXRayImage(), dtype=numpy.float32)
            if repeat > 0:
                times_ms.append((time.perf_counter() - begin) * 1e3)
                processor_ms.append((time.process_time() - processor_begin) * 1e3)
            else:
                transmission = picture / numpy.float32(gvxr.getTotalEnergyWithDetectorResponse())
                # The first pixel of the peer's picture is the lower right one.
                transmission[::-1, ::-1].astype("<f4").tofile(os.path.join(folder, "gvxr_%d.f32" % i))
    print(
        "code=gvxr version=%s ms_min=%.4f ms_median=%.4f processor_ms_median=%.4f"
        % (
            gvxr.getVersionOfSimpleGVXR().split()[1],
            min(times_ms),
            statistics.median(times_ms),
            statistics.median(processor_ms),
        )
    )


if __name__ == "__main__":
    main()
