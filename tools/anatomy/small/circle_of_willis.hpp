/* The circle of Willis and its variants. The arteries of the shipped file make a complete circle; a variant
 * changes widths, leaves out arteries, and changes from where an artery is fed. */
#pragma once
#include "tools/anatomy/vessels.hpp"
#include <array>
#include <cstdint>

namespace anatomy
{

enum class Communicating {
    usual,
    fetal,
    absent
}; // fetal: the posterior cerebral artery is fed by the carotid

struct CircleOfWillis {
    enum class Front { complete, without_communicating, right_narrow, left_narrow };
    Front front = Front::complete; // narrow: A1 of one side is hypoplastic, and the other feeds both A2
    std::array<Communicating, 2> back = {Communicating::usual, Communicating::usual}; // right, left
    bool is_complete() const
    {
        return front == Front::complete && back[0] == Communicating::usual && back[1] == Communicating::usual;
    }
};

/* Draws the circle of a seed: complete in 17 %, its front half in 77 %, a fetal posterior cerebral artery
 * in 15.9 %. */
CircleOfWillis drawn_circle(std::uint64_t seed);

/* Returns the arteries with the circle's variant; each artery comes after its parent. */
std::vector<Vessel> with_circle(std::vector<Vessel> arteries, const CircleOfWillis &circle);

} // namespace anatomy
