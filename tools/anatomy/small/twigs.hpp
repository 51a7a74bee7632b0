/* Turns what grew on larger arteries into small vessels. */
#pragma once
#include "tools/anatomy/small/grow.hpp"
#include "tools/anatomy/small/small_tree.hpp"

namespace anatomy
{

/* Adds the arteries that grew on the stems; a stem's arteries share its flow evenly among their ends. Their
 * bed is `bed_of_all`, or that of their stem if this is Bed::body. Grown vessels are named by numbers from 0
 * on. */
void add_twigs(const Growth &growth, const std::vector<Vessel> &stems, Bed bed_of_all,
               std::vector<SmallVessel> &vessels);

const Vessel *named(const std::vector<Vessel> &vessels, const std::string &name); // null: none

/* Adds a part whose grown vessels are named by numbers, which begin at 0 in each part. */
void append(std::vector<SmallVessel> part, std::vector<SmallVessel> &vessels);

} // namespace anatomy
