#!/usr/bin/env python3
"""Writes host/xray/attenuation.cpp: linear attenuation of every material in steps of 1 keV.

usage: tools/check/make_attenuation.py > host/xray/attenuation.cpp     (needs Debian's libxrl11; exit code 1 without it)

The test test_attenuation.py compares the committed file with the text that this program makes today.

The script computes mass attenuation by xraylib's function CS_Total, and mass energy absorption by CS_Energy. Both
functions use cross-sections of EPDL97 and of NIST's XCOM (Schoonjans et al., Spectrochimica Acta B 66 (2011) 776). A
mixture that is given by a name is one of NIST's compounds in xraylib. The densities of tissues come from ICRU 44, those
of metals are the densities of the pure substances, and those of products are nominal values (see MATERIALS). This
program computes no X-ray spectra and no filters, and chooses no photon energies for pictures. Spectra, filters and
photon energies are the work of host/xray/spectrum.cpp and host/xray/beam_table.cpp.
"""

import ctypes
import sys
import textwrap

LIBRARY, VERSION = "libxrl.so.11", "4.0"  # xraylib's release in Debian 12

FIRST_keV, COUNT = 15.5, 110
ENERGIES_keV = [FIRST_keV + i for i in range(COUNT)]
AIR = "Air, Dry (near sea level)"

# name: (compound, or mixture by mass share; density g/cm3; source of the composition)
MATERIALS = [
    ("soft_tissue", "Tissue, Soft (ICRP)", 1.00, "ICRP 23"),
    ("muscle", "Muscle, Skeletal", 1.04, "ICRP 23"),
    ("blood", "Blood (ICRP)", 1.06, "ICRP 23"),
    ("lung", "Lung (ICRP)", 0.26, "ICRP 23, inflated"),
    ("adipose", "Adipose Tissue (ICRP)", 0.92, "ICRP 23"),
    ("bone_cortical", "Bone, Cortical (ICRP)", 1.85, "ICRP 23"),
    (
        "bone_spongy",
        {"Bone, Cortical (ICRP)": 0.32, "Adipose Tissue (ICRP)": 0.68},
        1.13,
        "nominal marrow and trabeculae",
    ),
    ("iohexol_350", {"C19H26I3N3O9": 0.5416, "H2O": 0.4584}, 1.406, "755 mg iohexol per ml, the label's density"),
    ("steel", {"Fe": 0.705, "Cr": 0.19, "Ni": 0.095, "Mn": 0.01}, 7.93, "AISI 304"),
    ("nitinol", {"Ni": 0.557, "Ti": 0.443}, 6.45, "ASTM F2063"),
    ("platinum", {"Pt": 0.92, "W": 0.08}, 21.1, "92/8 alloy of coil tips"),
    ("tungsten", {"W": 1.0}, 19.3, "element"),
    ("gold", {"Au": 1.0}, 19.3, "element"),
    ("polymer_barium", {"C6H11NO": 0.60, "BaSO4": 0.40}, 1.63, "nylon with 40 % by mass"),
    ("polymer", {"C6H11NO": 1.0}, 1.02, "nylon"),
    ("air", AIR, 0.0012, "ICRU 37"),
]


class Compound(ctypes.Structure):
    """Declares for ctypes those fields of struct compoundData (xraylib-parser.h) that this script reads."""

    _fields_ = [("element_count", ctypes.c_int), ("atoms", ctypes.c_double), ("elements", ctypes.POINTER(ctypes.c_int))]


class Mixture(ctypes.Structure):
    """Declares for ctypes those fields of struct compoundDataNIST (xraylib-nist-compounds.h) that this script reads."""

    _fields_ = [("name", ctypes.c_char_p), ("element_count", ctypes.c_int), ("elements", ctypes.POINTER(ctypes.c_int))]


class Xraylib:
    """Calls functions of the C library xraylib; photon energies are in keV, and cross-sections are in cm2/g. The last
    argument of each xraylib function is a pointer to an error object; without this object, a failing function only
    returns 0."""

    K_SHELL = 0

    def __init__(self):
        library = ctypes.CDLL(LIBRARY)
        self.cs_total = self.function(library.CS_Total, ctypes.c_double, ctypes.c_int, ctypes.c_double)
        self.cs_total_cp = self.function(library.CS_Total_CP, ctypes.c_double, ctypes.c_char_p, ctypes.c_double)
        self.cs_energy_cp = self.function(library.CS_Energy_CP, ctypes.c_double, ctypes.c_char_p, ctypes.c_double)
        self.edge_energy = self.function(library.EdgeEnergy, ctypes.c_double, ctypes.c_int, ctypes.c_int)
        self.parse = self.function(library.CompoundParser, ctypes.POINTER(Compound), ctypes.c_char_p)
        self.mixture = self.function(library.GetCompoundDataNISTByName, ctypes.POINTER(Mixture), ctypes.c_char_p)

    @staticmethod
    def function(symbol, result, *arguments):
        symbol.restype, symbol.argtypes = result, (*arguments, ctypes.c_void_p)

        def call(*values):
            got = symbol(*(v.encode() if isinstance(v, str) else v for v in values), None)
            if result is ctypes.c_double and got <= 0.0:
                sys.exit(f"make_attenuation: {symbol.__name__}{values} has no value in {LIBRARY}")
            return got

        return call

    def elements_of(self, part):
        """Returns the atomic numbers of the elements in a chemical formula or in a named mixture."""
        found = self.parse(part) or self.mixture(part)
        if not found:
            sys.exit(f"make_attenuation: {LIBRARY} knows neither a formula nor a mixture {part}")
        return found.contents.elements[: found.contents.element_count]


try:
    xrl = Xraylib()
except OSError:
    sys.exit(f"make_attenuation: {LIBRARY} was not found; install it (Debian: apt-get install libxrl11)")


def parts_of(composition):
    return {composition: 1.0} if isinstance(composition, str) else composition


def linear_per_cm(composition, density):
    return [
        sum(share * xrl.cs_total_cp(part, e) for part, share in parts_of(composition).items()) * density
        for e in ENERGIES_keV
    ]


def edge_keV(composition):
    """Returns the energy of the highest K edge between iodine's K edge and the end of the table, or 0 if there is no
    such edge. Attenuation cannot be interpolated across a K edge."""
    edges = [xrl.edge_energy(z, xrl.K_SHELL) for part in parts_of(composition) for z in xrl.elements_of(part)]
    return max([e for e in edges if 34.0 < e < ENERGIES_keV[-1]], default=0.0)


def array(values):
    return "\n".join(
        textwrap.wrap(
            ", ".join("%.5gf" % v if "." in "%.5g" % v or "e" in "%.5g" % v else "%.5g.0f" % v for v in values),
            104,
            initial_indent="     ",
            subsequent_indent="     ",
        )
    )


def main():
    print(f"""// Written by tools/check/make_attenuation.py from xraylib {VERSION}; do not edit.
#include "host/xray/attenuation.hpp"

// clang-format off
namespace crn {{

const float attenuation_per_cm[material_count][energy_count] = {{""")
    for name, composition, density, source in MATERIALS:
        print(f"    // {name}: {density:g} g/cm3, {source}\n    {{\n{array(linear_per_cm(composition, density))}}},")
    print("};\n")
    print("const float edge_keV[material_count] = {\n%s};\n" % array(edge_keV(m[1]) for m in MATERIALS))
    rows = (
        ("aluminium_per_cm", (xrl.cs_total(13, e) * 2.699 for e in ENERGIES_keV)),
        ("copper_per_cm", (xrl.cs_total(29, e) * 8.96 for e in ENERGIES_keV)),
        ("caesium_iodide_per_cm", (xrl.cs_total_cp("CsI", e) * 4.51 for e in ENERGIES_keV)),
        ("anode_cm2_per_g", (xrl.cs_total(74, e) for e in ENERGIES_keV)),
        ("air_absorption_cm2_per_g", (xrl.cs_energy_cp(AIR, e) for e in ENERGIES_keV)),
    )
    for name, values in rows:
        print("const float %s[energy_count] = {\n%s};\n" % (name, array(values)))
    print("// clang-format on\n} // namespace crn")


if __name__ == "__main__":
    main()
