// Makes the sim port (the firmware compiled for the host) available as a Transport. The firmware runs in this
// process, and the host reaches it only through bytes.
#pragma once
#include "host/link/transport.hpp"
#include <memory>

struct crn_sim;

namespace crn
{

class SimTransport final : public Transport
{
  public:
    explicit SimTransport(std::uint32_t scene_slot_bytes = 16u << 20);
    ~SimTransport() override;
    void write(std::span<const std::uint8_t> bytes) override;
    std::size_t read(std::span<std::uint8_t> bytes) override;
    void pass_time_ms(std::uint32_t milliseconds) override;
    bool has_own_clock() const override { return false; }
    // Lets the device use a scene in the caller's memory; this memory must exist as long as the device.
    // Returns false if the device refuses the scene. If a host then loads the same scene, it does not send
    // the scene's bytes.
    bool share_scene(std::span<const std::uint8_t> scene, std::uint32_t crc32);
    // The next functions copy the state of a LOCKSTEP session and restore such a copy, each within
    // microseconds (sim.h). After a state has been restored, the Link of this device must be told the tick
    // (Link::continue_at). The functions that copy and restore a state return false if the device refuses.
    static std::size_t snapshot_bytes();
    bool take_snapshot(std::span<std::uint8_t> bytes);
    bool put_snapshot(std::span<const std::uint8_t> bytes);
    // Attaches a rig with three tracks, whose sensors are healthy and whose user's hands are at rest.
    void attach_rig();

  private:
    struct Close {
        void operator()(crn_sim *sim) const;
    };
    std::unique_ptr<crn_sim, Close> sim_;
};

} // namespace crn
