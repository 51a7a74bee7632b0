"""The pictures of host/bench/peer_xray.cpp by gVirtualXray. Called by run_xray_peers.py with the python of its environment.

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

# (element numbers, mass shares, density g/cm3): the compounds of tools/check/make_attenuation.py, as NIST's tables have them.
MATERIALS = {
    "soft_tissue": ((1, 6, 7, 8, 11, 12, 15, 16, 17, 19, 20, 26, 30),
                    (.104472, .23219, .02488, .630238, .00113, .00013, .00133, .00199, .00134, .00199, .00023, 5e-5, 3e-5), 1.00),
    "blood": ((1, 6, 7, 8, 11, 12, 14, 15, 16, 17, 19, 20, 26, 30),
              (.101866, .10002, .02964, .759414, .00185, 4e-5, 3e-5, .00035, .00185, .00278, .00163, 6e-5, .00046, 1e-5), 1.06),
    "muscle": ((1, 6, 7, 8, 11, 12, 15, 16, 17, 19, 20, 26, 30),
               (.100637, .10783, .02768, .754773, .00075, .00019, .0018, .00241, .00079, .00302, 3e-5, 4e-5, 5e-5), 1.04),
    "lung": ((1, 6, 7, 8, 11, 12, 15, 16, 17, 19, 20, 26, 30),
             (.101278, .10231, .02865, .757072, .00184, .00073, .0008, .00225, .00266, .00194, 9e-5, .00037, 1e-5), 0.26),
    "adipose": ((1, 6, 7, 8, 11, 12, 15, 16, 17, 19, 20, 26, 30),
                (.119477, .63724, .00797, .232333, .0005, 2e-5, .00016, .00073, .00119, .00032, 2e-5, 2e-5, 2e-5), 0.92),
    "bone_cortical": ((1, 6, 7, 8, 12, 15, 16, 20, 30),
                      (.047234, .14433, .04199, .446096, .0022, .10497, .00315, .20993, .0001), 1.85),
    "air": ((6, 7, 8, 18), (.000124, .755267, .231781, .012827), 0.0012),
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
    for energy_keV, share in scene["spectrum"]:  # shares of energy; the peer asks for photons
        gvxr.addEnergyBinToSpectrumPerPixelAtSDD(energy_keV, "keV", share / energy_keV)


def look(scene, view):
    gvxr.setSourcePosition(*view["source_mm"], "mm")
    gvxr.usePointSource()
    gvxr.setDetectorPosition(*view["detector_mm"], "mm")
    gvxr.setDetectorUpVector(*view["up"])
    gvxr.setDetectorRightVector(*[-x for x in view["right"]])  # the detector as seen from behind it
    # What lies in the outer surface is taken out of it. The renderer forgets that surface when anything else is set.
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
                # Its first pixel is the lower right one.
                transmission[::-1, ::-1].astype("<f4").tofile(os.path.join(folder, "gvxr_%d.f32" % i))
    print("code=gvxr version=%s ms_min=%.4f ms_median=%.4f processor_ms_median=%.4f"
          % (gvxr.getVersionOfSimpleGVXR().split()[1], min(times_ms), statistics.median(times_ms),
             statistics.median(processor_ms)))


if __name__ == "__main__":
    main()
