// Declares the linear attenuation of every material in steps of 1 keV; tools/check/make_attenuation.py writes
// the table.
#pragma once
#include "host/xray/paths/materials.hpp"

namespace crn
{

inline constexpr int energy_count = 110;
// Returns the middle of a 1 keV step: 15.5 .. 124.5 keV.
constexpr double energy_keV(int index)
{
    return 15.5 + index;
}

extern const float attenuation_per_cm[material_count][energy_count];

// Gives each material's highest K edge in keV between 33.2 keV (the K edge of iodine) and the end of the
// table; 0 means that the material has no K edge there.
extern const float edge_keV[material_count];

// The next tables hold the attenuation of the filters, of the scintillator (at the density of the crystal)
// and of the anode; the last one holds the mass energy absorption of air, for the kerma.
extern const float aluminium_per_cm[energy_count];
extern const float copper_per_cm[energy_count];
extern const float caesium_iodide_per_cm[energy_count];
extern const float anode_cm2_per_g[energy_count];
extern const float air_absorption_cm2_per_g[energy_count];

} // namespace crn
