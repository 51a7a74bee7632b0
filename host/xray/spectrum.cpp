// Integrates Tucker's model of the X-ray spectrum over the energy of the electrons by the midpoint rule.
#include "host/xray/spectrum.hpp"
#include "host/xray/float_math.hpp"
#include <algorithm>

namespace crn
{
namespace
{

constexpr double sine_of_anode = 0.190808995376545; // 11 degrees
constexpr double electron_rest_keV = 510.99895;
constexpr double edge_K_keV = 69.525;
constexpr double output_scale = 1.17; // scales to spekpy's kerma: spectrum.hpp

// Holds the constant alpha r_e^2 Z^2 / A of tungsten in cm2 per g (alpha: fine-structure constant, r_e:
// electron radius, Z: atomic number, A: atomic mass).
constexpr double cross_section_cm2_g =
    1.0 / 137.036 * 2.8179403e-13 * 2.8179403e-13 * 74 * 74 / (183.84 * 1.66053907e-24);

// Holds the number of electrons of one mAs, divided by the area in mm2 of a sphere with radius 1 m.
constexpr double per_mm2_mAs = 6.241509e15 / (4.0 * 3.14159265358979 * 1e6);

// Returns the constant c of the law of Thomson and Whiddington, T0^2 - T^2 = c x, for an electron's energies
// T0 at the surface and T at the depth x, which is in g/cm2. The constant c is in keV2 cm2/g, and is
// interpolated linearly between measured voltages.
double whiddington(double kV)
{
    constexpr double at_kV[] = {40.0, 50.0, 75.0, 100.0, 150.0};
    constexpr double value[] = {5.06e5, 5.4e5, 6.25e5, 7.0e5, 8.4e5};
    int i = 0;
    while (i < 3 && kV > at_kV[i + 1]) ++i;
    return value[i] + (value[i + 1] - value[i]) * (kV - at_kV[i]) / (at_kV[i + 1] - at_kV[i]);
}

// Returns photons per electron and keV.
double bremsstrahlung(double energy, double anode_cm2_g, double kV)
{
    constexpr int steps = 24;
    constexpr double b1 = -5.049, b2 = 10.847, b3 = -10.516, b4 = 3.842;
    const double level = 36.85 + 0.0290 * kV, c = whiddington(kV), width = (kV - energy) / steps;
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double electron = energy + (i + 0.5) * width, u = energy / electron;
        const double shape = 1.0 + u * (b1 + u * (b2 + u * (b3 + u * b4)));
        const double stopping = 2024.1 + 10361.0 * exp_double(-0.04695 * electron); // keV cm2/g
        const double seen = exp_double(-anode_cm2_g * (kV * kV - electron * electron) / (c * sine_of_anode));
        sum += shape * (electron + electron_rest_keV) / electron * seen / stopping;
    }
    return cross_section_cm2_g * level * sum * width / energy;
}

struct Line {
    double energy_keV, share;
};
constexpr Line lines[] = {{59.32, 0.505}, {57.98, 0.291}, {67.2, 0.162}, {69.1, 0.042}};

// Returns the number of photons of a K line per electron. The photons of a K line are made from the anode's
// surface down to the depth at which the energy of the electron is that of the K edge.
double line_photons(const Line &line, double anode_cm2_g, double kV)
{
    constexpr int steps = 16;
    const double range = (kV * kV - edge_K_keV * edge_K_keV) / whiddington(kV);
    double seen = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double x = (i + 0.5) / steps;
        seen += 1.5 * (1.0 - x * x) * exp_double(-anode_cm2_g * x * range / sine_of_anode) / steps;
    }
    return 1.349e-3 * exp2_double(1.648 * log2_double(kV / edge_K_keV - 1.0)) * line.share * seen;
}

int step_of(double energy)
{
    return static_cast<int>(energy - energy_keV(0) + 0.5);
}

} // namespace

Spectrum tube_spectrum(double tube_voltage_kV, double copper_mm)
{
    const double kV = std::clamp(tube_voltage_kV, tube_voltage_min_kV, tube_voltage_max_kV);
    Spectrum photons{};
    for (int i = 0; i < energy_count && energy_keV(i) < kV; ++i)
        photons[i] = bremsstrahlung(energy_keV(i), anode_cm2_per_g[i], kV);
    if (kV > edge_K_keV + 1e-6)
        for (const Line &line : lines) {
            const int i = step_of(line.energy_keV);
            photons[i] += line_photons(line, anode_cm2_per_g[i], kV);
        }
    for (int i = 0; i < energy_count; ++i)
        photons[i] *= output_scale * per_mm2_mAs *
                      exp_double(-0.1 * (inherent_aluminium_mm * aluminium_per_cm[i] +
                                         std::max(copper_mm, 0.0) * copper_per_cm[i]));
    return photons;
}

Spectrum behind(const Spectrum &spectrum, Material material, double thickness_cm)
{
    Spectrum left = spectrum;
    for (int i = 0; i < energy_count; ++i)
        left[i] *= exp_double(-thickness_cm * attenuation_per_cm[static_cast<int>(material)][i]);
    return left;
}

double air_kerma_uGy(const Spectrum &photons_mm2)
{
    constexpr double joule_per_keV = 1.602176634e-16;
    double gray = 0.0; // 1/mm2 -> 1/m2, cm2/g -> m2/kg
    for (int i = 0; i < energy_count; ++i)
        gray += photons_mm2[i] * 1e6 * energy_keV(i) * joule_per_keV * air_absorption_cm2_per_g[i] * 0.1;
    return gray * 1e6;
}

double scintillator_absorption(int energy_index)
{
    return 1.0 - exp_double(-0.055 * caesium_iodide_per_cm[energy_index]);
}

} // namespace crn
