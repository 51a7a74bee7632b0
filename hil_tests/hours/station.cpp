#include "hil_tests/hours/station.hpp"

namespace hours
{

namespace
{

hil::PlantSettings quick_plant(std::uint64_t seed)
{
    constexpr double tolerance = 1e-9;
    constexpr int steps_per_ms = 2; // enough for hands that lead the tools
    hil::PlantSettings settings;
    settings.seed = seed;
    settings.translation.sweep_tolerance = settings.rotation.sweep_tolerance = tolerance;
    settings.translation.steps_per_ms = settings.rotation.steps_per_ms = steps_per_ms;
    return settings;
}

} // namespace

Station::Station(std::uint64_t seed) : plant_(quick_plant(seed)) {}

void Station::note(const std::string &trouble)
{
    if (ledger_.trouble.empty()) ledger_.trouble = trouble;
}

} // namespace hours
