// Draws the four figures of the thesis as pictures. The pictures show the thesis' values beside ours, with an
// additional bar for our direct solver.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// Each function writes one PNG file, or throws std::runtime_error, whose message names the file and the
// cause.
void draw_compression(const Study &study, const std::string &path);                  // Figure 5.11
void draw_shapes(const Study &study, const Vessel &vessel, const std::string &path); // Figure 5.12
void draw_convergence(const Study &study, const std::string &path);                  // Figure 5.13
void draw_times(const Study &study, const std::string &path);                        // Figure 5.14

} // namespace vcsim3
