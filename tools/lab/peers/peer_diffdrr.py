"""Makes the pictures of tools/lab/peers/peer_ct.cpp with the renderer of DiffDRR, on the processor. The script
run_ct_peers.py calls this script with the Python of its virtual environment.

  peer_diffdrr.py FOLDER ROUNDS

Reads FOLDER/scene.json and FOLDER/volume.u16, writes FOLDER/diffdrr_V.f32 (transmissions at 70 keV, row 0 on top) and
prints one line of key=value pairs. The renderer is the faster one of DiffDRR's two, Trilinear, with its default of 500
points per ray. Only the module with the renderers is imported, because the rest of DiffDRR needs packages for windows.
"""

import importlib.metadata
import json
import os
import statistics
import sys
import time

import numpy
import torch
from diffdrr.renderers import Trilinear

WATER_PER_MM = 0.019288  # at 70 keV, xraylib
POINTS, RAYS_AT_ONCE = 500, 32768


def rays_of(view, size):
    """Returns the source and the middles of all pixels, in voxels along x, y and z."""
    source, forward, right, up = (torch.tensor(view[key]) for key in ("source", "forward", "right", "up"))
    steps = torch.arange(size) + 0.5 - size / 2
    middle = source + forward
    targets = middle + right * steps[None, :, None] - up * steps[:, None, None]
    return source[None, None], targets.reshape(1, -1, 3)


def picture(renderer, volume, view, scene):
    source, targets = rays_of(view, scene["size"])
    parts = []
    for begin in range(0, targets.shape[1], RAYS_AT_ONCE):
        part = targets[:, begin : begin + RAYS_AT_ONCE]
        length_mm = (part - source).norm(dim=-1, keepdim=True).permute(0, 2, 1) * scene["voxel_mm"]
        parts.append(renderer(volume, source, part, length_mm, n_points=POINTS).reshape(-1))
    return torch.exp(-WATER_PER_MM * torch.cat(parts))


def main():
    folder, rounds = sys.argv[1], int(sys.argv[2])
    with open(os.path.join(folder, "scene.json"), encoding="utf-8") as file:
        scene = json.load(file)
    torch.set_num_threads(2)
    voxels = numpy.fromfile(os.path.join(folder, "volume.u16"), dtype="<u2").reshape([scene["edge"]] * 3)
    volume = torch.from_numpy(voxels.astype(numpy.float32) / 1000).permute(2, 0, 1).contiguous()
    renderer = Trilinear()
    times_ms, processor_ms = [], []
    with torch.no_grad():
        for _ in range(rounds):
            for i, view in enumerate(scene["views"]):
                begin, processor_begin = time.perf_counter(), time.process_time()
                transmission = picture(renderer, volume, view, scene)
                times_ms.append((time.perf_counter() - begin) * 1e3)
                processor_ms.append((time.process_time() - processor_begin) * 1e3)
                transmission.numpy().astype("<f4").tofile(os.path.join(folder, "diffdrr_%d.f32" % i))
    print(
        "code=diffdrr version=%s ms_min=%.4f ms_median=%.4f processor_ms_median=%.4f"
        % (
            importlib.metadata.version("diffdrr"),
            min(times_ms),
            statistics.median(times_ms),
            statistics.median(processor_ms),
        )
    )


if __name__ == "__main__":
    main()
