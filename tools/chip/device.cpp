#include "tools/chip/device.hpp"
#include "shared/scene/scene.h"
#include <algorithm>
#include <cstring>

namespace chip
{

namespace
{

class ChipTransport final : public crn::Transport
{
  public:
    explicit ChipTransport(ChipDevice &device) : device_(device) { device_.processor().call("chip_start"); }

    void write(std::span<const std::uint8_t> bytes) override
    {
        const std::span<std::uint8_t> input = device_.processor().memory_of("chip_in");
        while (!bytes.empty()) {
            const std::size_t count = std::min(bytes.size(), input.size());
            std::copy_n(bytes.begin(), count, input.begin());
            device_.processor().call("chip_receive", static_cast<std::uint32_t>(count), device_.observer());
            take_output();
            bytes = bytes.subspan(count);
        }
    }

    std::size_t read(std::span<std::uint8_t> bytes) override
    {
        const std::size_t count = std::min(bytes.size(), output_.size() - given_);
        std::copy_n(output_.begin() + static_cast<std::ptrdiff_t>(given_), count, bytes.begin());
        given_ += count;
        return count;
    }

    void pass_time_ms(std::uint32_t) override {}
    bool has_own_clock() const override { return false; }

  private:
    void take_output()
    {
        if (given_ == output_.size()) {
            output_.clear();
            given_ = 0;
        }
        const std::uint32_t count = device_.processor().word_of("chip_out_count");
        const std::span<std::uint8_t> sent = device_.processor().memory_of("chip_out").first(count);
        output_.insert(output_.end(), sent.begin(), sent.end());
        std::memset(device_.processor().memory_of("chip_out_count").data(), 0, sizeof count);
    }

    ChipDevice &device_;
    std::vector<std::uint8_t> output_;
    std::size_t given_ = 0;
};

} // namespace

ChipDevice::ChipDevice(const std::string &image)
    : processor_(image), code_(disassemble(image)), pricer_(processor_, code_, "crn_step")
{
}

std::unique_ptr<crn::Transport> ChipDevice::open()
{
    return std::make_unique<ChipTransport>(*this);
}

void ChipDevice::find_scene(std::span<const std::uint8_t> bytes)
{
    const std::span<std::uint8_t> slots = processor_.memory_of("chip_slots");
    const std::span<std::uint8_t> second = slots.subspan(slots.size() / 2);
    const bool is_second =
        bytes.size() <= second.size() && std::equal(bytes.begin(), bytes.end(), second.begin());
    const std::uint32_t base =
        processor_.address_of("chip_slots") + (is_second ? static_cast<std::uint32_t>(slots.size() / 2) : 0);
    crn_scene scene;
    if (bytes.empty() || crn_scene_open(bytes.data(), static_cast<std::uint32_t>(bytes.size()), &scene,
                                        nullptr) != CRN_SCENE_OK)
        return pricer_.set_scene({});
    const auto place = [&](const void *part) {
        return base + static_cast<std::uint32_t>(static_cast<const std::uint8_t *>(part) - bytes.data());
    };
    SceneLayout layout;
    if (scene.has_motion) {
        const auto &count = scene.motion.node_count_xyz;
        layout.motion = place(scene.motion.rows);
        layout.motion_bytes = count[0] * count[1] * count[2] * 3 * CRN_SCENE_MOTION_ROW * 2;
    }
    const NearWords near = read_near(processor_);
    layout.near_bricks = near.bricks;
    layout.near_brick_count = near.slot_count;
    pricer_.set_scene(layout);
}

} // namespace chip
