// Collects the load on the vessel wall in a session: the sum of all contact forces, read at regular ticks,
// and its integral over time.
#pragma once
#include "shared/wire/wire.h"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace crn
{

struct ContactSample {
    std::uint32_t tick = 0;
    float force_N = 0; // sum of the magnitudes of all nodes' contacts
};

// Returns the sum of the magnitudes of all contact forces on the tools in use.
inline double contact_sum_N(const crn_wire_contacts &contacts)
{
    constexpr double N_per_q22 = 1.0 / (1 << 22);
    double sum_N = 0.0;
    for (std::uint16_t i = 0; i < contacts.contacts_count; i++) {
        const crn_wire_contact &one = contacts.contacts[i];
        sum_N += N_per_q22 * std::sqrt(std::pow(one.force_x_N_q22, 2) + std::pow(one.force_y_N_q22, 2) +
                                       std::pow(one.force_z_N_q22, 2));
    }
    return sum_N;
}

struct ContactFigures {
    static constexpr std::uint32_t look_every_ticks = 16, sample_every_ticks = 160;

    bool is_known = false; // whether the contacts were read
    double impulse_N_s = 0.0, force_max_N = 0.0;
    std::vector<ContactSample> series; // every sample_every_ticks

    // Adds the sum of the contact forces at this tick to the integral over time, as the force of the last
    // look_every_ticks ticks.
    double wall_way_max_m = 0.0, wall_widened_max_m = 0.0; // of walls that give way
    std::uint32_t wall_way_max_tick = 0;

    void take(const crn_wire_contacts &contacts)
    {
        if (contacts.wall_way_um * 1e-6 > wall_way_max_m) {
            wall_way_max_m = contacts.wall_way_um * 1e-6;
            wall_way_max_tick = contacts.tick;
        }
        wall_widened_max_m = std::max(wall_widened_max_m, contacts.wall_widened_um * 1e-6);
        const double sum_N = contact_sum_N(contacts);
        is_known = true;
        impulse_N_s += sum_N * look_every_ticks * 1e-3;
        force_max_N = std::max(force_max_N, sum_N);
        if (contacts.tick % sample_every_ticks == 0)
            series.push_back({contacts.tick, static_cast<float>(sum_N)});
    }
};

} // namespace crn
