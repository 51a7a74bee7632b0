// The command `ct cta`: a virtual CT angiogram of a person whom `anatomy` has made, with the true arteries.
#pragma once
#include <cstdint>
#include <filesystem>

namespace crn::ct
{

struct CtaOptions {
    std::filesystem::path person, output; // the folder of `anatomy person`; the volume
    std::filesystem::path labels,
        truth; // label map of the true arteries; table of their centrelines; empty: none
    double pixel_mm = 0.8, slice_mm = 1.0;
    double low_mm = 0, high_mm = 0; // stretch of the body, in the scene's heights; equal: groins to arch
    double artery_HU = 350;
    double blur_mm = 0.5, blur_slice_mm = 0.5; // sigma of the point spread
    double noise_HU = 18;
    double breath_mm = 0.5, pulse_mm = 0.5; // how far breath and heartbeat move slices against each other
    std::uint32_t seed = 1;
};

// Throws Fault or OutputError.
void command_cta(const CtaOptions &options);

} // namespace crn::ct
