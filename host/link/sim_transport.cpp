#include "host/link/sim_transport.hpp"
#include "firmware/port/sim/sim.h"
#include <new>

namespace crn
{

void SimTransport::Close::operator()(crn_sim *sim) const
{
    crn_sim_destroy(sim);
}

SimTransport::SimTransport(std::uint32_t scene_slot_bytes) : sim_(crn_sim_create(scene_slot_bytes))
{
    if (!sim_) throw std::bad_alloc();
}

SimTransport::~SimTransport() = default;

void SimTransport::write(std::span<const std::uint8_t> bytes)
{
    crn_sim_write(sim_.get(), bytes.data(), bytes.size());
}

std::size_t SimTransport::read(std::span<std::uint8_t> bytes)
{
    return crn_sim_read(sim_.get(), bytes.data(), bytes.size());
}

void SimTransport::pass_time_ms(std::uint32_t milliseconds)
{
    crn_sim_timer(sim_.get(), milliseconds);
}

bool SimTransport::share_scene(std::span<const std::uint8_t> scene, std::uint32_t crc32)
{
    return crn_sim_share_scene(sim_.get(), scene.data(), static_cast<std::uint32_t>(scene.size()), crc32);
}

std::size_t SimTransport::snapshot_bytes()
{
    return crn_sim_snapshot_bytes();
}

bool SimTransport::take_snapshot(std::span<std::uint8_t> bytes)
{
    return crn_sim_take_snapshot(sim_.get(), bytes.data(), bytes.size());
}

bool SimTransport::put_snapshot(std::span<const std::uint8_t> bytes)
{
    return crn_sim_put_snapshot(sim_.get(), bytes.data(), bytes.size());
}

void SimTransport::attach_rig()
{
    const crn_port_inputs inputs = crn_sim_healthy_inputs();
    crn_sim_set_inputs(sim_.get(), &inputs);
    crn_sim_timer(sim_.get(), 1);
}

} // namespace crn
