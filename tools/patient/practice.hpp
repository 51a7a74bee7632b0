// Writes the session that shows a person's own vessels.
#pragma once
#include "tools/patient/choices.hpp"
#include "tools/patient/entry.hpp"

#include <filesystem>

namespace crn::patient
{

// A guidewire goes on from the entry, a catheter follows it, the wire is withdrawn, and contrast medium is
// injected during a DSA run, with the vessels that it reaches in the middle of the picture. The narrowest
// part of the way decides which instruments are taken, and how far they go; the choices say so.
std::string practice_session(const std::filesystem::path &scene, const centreline::Tree &tree,
                             const TreeEnd &end, double inside_mm, Choices &choices);

} // namespace crn::patient
