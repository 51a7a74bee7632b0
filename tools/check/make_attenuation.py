#!/usr/bin/python3
"""Writes host/xray/attenuation.cpp: how strongly each material attenuates the beam, per energy bin.

usage: tools/check/make_attenuation.py [--check] > host/xray/attenuation.cpp     (needs Debian's python3-xraylib)

Beam: tungsten anode, Kramers' bremsstrahlung with the K lines, PEAK_kV, filtered by 2.5 mm Al + 0.2 mm Cu; the detector
is 0.55 mm of CsI. Mass attenuation is xraylib's CS_Total (NIST/EPDL tables). A bin's attenuation is the mean over the
photons detected in that bin behind 10 cm of soft tissue, so that thick and thin parts of a patient are both close.
--check prints the effective figures behind 20 cm of soft tissue beside those of spekpy 2.5.4 at 70 and 80 kVp.
"""
import math
import sys
import xraylib as xrl

PEAK_kV = 75
EDGES_keV = [20, 40, 48, 56, 64, 75]

# name: (compound or mixture by mass share, density g/cm3). Shares of 304 steel, L605, Pt-W and iohexol are nominal.
MATERIALS = [
    ("soft_tissue", "Tissue, Soft (ICRP)", 1.00),
    ("muscle", "Muscle, Skeletal", 1.04),
    ("blood", "Blood (ICRP)", 1.06),
    ("lung", "Lung (ICRP)", 0.26),
    ("adipose", "Adipose Tissue (ICRP)", 0.92),
    ("bone_cortical", "Bone, Cortical (ICRP)", 1.85),
    ("bone_spongy", {"Bone, Cortical (ICRP)": 0.32, "Adipose Tissue (ICRP)": 0.68}, 1.13),
    ("iohexol_350", {"C19H26I3N3O9": 0.5416, "H2O": 0.4584}, 1.406),
    ("steel", {"Fe": 0.705, "Cr": 0.19, "Ni": 0.095, "Mn": 0.01}, 7.93),
    ("nitinol", {"Ni": 0.557, "Ti": 0.443}, 6.45),
    ("platinum", {"Pt": 0.92, "W": 0.08}, 21.1),
    ("tungsten", {"W": 1.0}, 19.3),
    ("gold", {"Au": 1.0}, 19.3),
    ("polymer_barium", {"C6H11NO": 0.60, "BaSO4": 0.40}, 1.63),
    ("polymer", {"C6H11NO": 1.0}, 1.02),
    ("air", "Air, Dry (near sea level)", 0.0012),
]


def mass_attenuation(composition, energy_keV):
    if isinstance(composition, str):
        return xrl.CS_Total_CP(composition, energy_keV)
    return sum(share * xrl.CS_Total_CP(part, energy_keV) for part, share in composition.items())


def linear(name, energy_keV):
    """1/mm."""
    _, composition, density = next(m for m in MATERIALS if m[0] == name)
    return mass_attenuation(composition, energy_keV) * density / 10.0


def spectrum(peak_kV):
    """[(keV, photons detected without a patient, photons emitted)], 0.5 keV steps."""
    points = []
    step = 0.5
    for i in range(int((peak_kV - 15) / step)):
        energy = 15.25 + i * step
        photons = (peak_kV / energy - 1.0)
        # Self-absorption at about half the electron range, seen under 11 degrees.
        photons *= math.exp(-xrl.CS_Total(74, energy) * 19.3 * 3.5e-4 / math.sin(math.radians(11)))
        # K lines above the edge, share of the continuum from Birch and Marshall's measurements (a few per cent at 75 kV).
        over = peak_kV / 69.525 - 1.0
        for line, weight in ((57.98, 0.58), (59.32, 1.0), (67.2, 0.42)):
            if over > 0 and abs(energy - line) < step / 2 + 1e-9:
                photons += 9.0 * weight * over ** 1.6
        photons *= math.exp(-xrl.CS_Total(13, energy) * 2.70 * 0.25 - xrl.CS_Total(29, energy) * 8.96 * 0.02)
        absorbed = 1.0 - math.exp(-xrl.CS_Total_CP("CsI", energy) * 4.51 * 0.055)
        points.append((energy, photons * absorbed, photons))
    return points


def behind(points, tissue_mm):
    return [(e, d * math.exp(-linear("soft_tissue", e) * tissue_mm), p * math.exp(-linear("soft_tissue", e) * tissue_mm))
            for e, d, p in points]


def mean(values, weights):
    return sum(v * w for v, w in zip(values, weights)) / sum(weights)


def kerma_nGy_per_photon_mm2(points, column):
    """Air kerma of one detected (1) or emitted (2) photon per mm2; mass energy absorption by xraylib's CS_Energy."""
    nGy = 0.0
    for point in points:
        energy_J = point[0] * 1.602176634e-16
        cm2_per_g = xrl.CS_Energy_CP("Air, Dry (near sea level)", point[0])
        nGy += point[2] * energy_J * cm2_per_g * 0.1 * 1e6 * 1e9  # cm2/g -> m2/kg, 1/mm2 -> 1/m2
    return nGy / sum(p[column] for p in points)


def check():
    for peak, expected in ((70, "53.2 keV soft .220 bone .726"), (80, "58.0 keV soft .211 bone .643")):
        points = behind(spectrum(peak), 200)
        weights = [d * e for e, d, _ in points]
        energies = [e for e, _, _ in points]
        soft = mean([linear("soft_tissue", e) * 10 for e in energies], weights)
        bone = mean([linear("bone_cortical", e) * 10 for e in energies], weights)
        print(f"{peak} kVp: {mean(energies, weights):.1f} keV soft {soft:.3f} bone {bone:.3f} 1/cm   spekpy: {expected}")


def bins(points):
    for low, high in zip(EDGES_keV, EDGES_keV[1:]):
        yield [p for p in points if low <= p[0] < high]


def main():
    if "--check" in sys.argv[1:]:
        return check()
    open_beam = spectrum(PEAK_kV)
    total = sum(d for _, d, _ in open_beam)
    shares = [sum(d for _, d, _ in part) / total for part in bins(open_beam)]
    scale = math.log2(math.e) / 1024.0
    print(f"""// Written by tools/check/make_attenuation.py from xraylib {xrl.XRAYLIB_MAJOR}.{xrl.XRAYLIB_MINOR}; do not edit.
// {PEAK_kV} kVp, 2.5 mm Al + 0.2 mm Cu, 0.55 mm CsI; bins {", ".join(f"{a}-{b}" for a, b in zip(EDGES_keV, EDGES_keV[1:]))} keV.
#include "host/xray/attenuation.hpp"

namespace seld {{

const float beam_share[beam_bin_count] = {{{", ".join(f"{s:.7f}f" for s in shares)}}};

const float attenuation_log2_per_q10mm[material_count][beam_bin_count] = {{""")
    for name, _, _ in MATERIALS:
        row, text = [], []
        for part in bins(behind(open_beam, 100)):
            mu = mean([linear(name, e) for e, _, _ in part], [d for _, d, _ in part])
            row.append(f"{mu * scale:.8e}f")
            text.append(f"{mu * 10:.3f}")
        print(f"    {{{', '.join(row)}}}, // {name}: {' '.join(text)} 1/cm")
    print(f"""}};

const double kerma_behind_patient_nGy_mm2 = {kerma_nGy_per_photon_mm2(behind(open_beam, 200), 1):.6e};
const double kerma_open_nGy_mm2 = {kerma_nGy_per_photon_mm2(open_beam, 1):.6e};

}} // namespace seld""")


if __name__ == "__main__":
    main()
