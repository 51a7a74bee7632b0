/* Lets small arteries wind, as those of living persons do. A stated course is smooth; the winding adds waves
 * across it. */
#pragma once
#include "tools/anatomy/vessels.hpp"
#include <cstdint>

namespace anatomy
{

/* Returns the vessel with waves across its course, which make it about `vessel.winding` times as long. Both
 * ends stay where they are. Waves are 16 diameters long, but 22 to 60 mm (assumed), and differ with the seed
 * and the stream. */
Vessel wound(const Vessel &vessel, std::uint64_t seed, std::uint64_t stream);

} // namespace anatomy
