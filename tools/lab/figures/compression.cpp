#include "tools/lab/figures/compression.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>

namespace vcsim3
{
namespace
{

constexpr double reach_m = 0.5;
constexpr int spare_elements = 6; // these stay in the inserter
constexpr double axial_max_N = 10000.0;

// Both solvers with one interface. The run of a solver ends when the relative error of the rod's length is
// not a number.
class BaselineRun
{
  public:
    explicit BaselineRun(Simulation simulation) : simulation_(std::move(simulation)) {}

    void tick(double feed_m) { simulation_.tick(feed_m); }
    double handle_N() const { return simulation_.handle_axial_N(); }
    double length_error_now() const
    {
        return is_sound_within(simulation_.rod(), reach_m) ? length_error(simulation_.rod()) : std::nan("");
    }
    double depth_max_m() const
    {
        double most = 0.0;
        for (const Contact &contact : simulation_.contacts()) most = std::max(most, contact.depth_m);
        return most;
    }
    std::vector<Vector> positions() const
    {
        const Rod &rod = simulation_.rod();
        const int count = std::min(rod.free_count + 1, rod.node_count());
        return {rod.position.begin(), rod.position.begin() + count};
    }
    std::vector<bool> touching() const
    {
        std::vector<bool> touching(positions().size(), false);
        for (const Contact &contact : simulation_.contacts()) touching[contact.node] = true;
        return touching;
    }
    std::vector<std::uint8_t> save() const { return to_bytes(simulation_.save()); }

  private:
    Simulation simulation_;
};

class DirectRun
{
  public:
    explicit DirectRun(DirectRod rod) : rod_(std::move(rod)) {}

    void tick(double feed_m) { rod_.tick(feed_m); }
    double handle_N() const { return rod_.handle_axial_N(); }
    double length_error_now() const { return rod_.length_error(); }
    double depth_max_m() const { return rod_.depth_max_m(); }
    std::vector<Vector> positions() const { return rod_.positions(); }
    std::vector<bool> touching() const { return rod_.touching(); }
    std::vector<std::uint8_t> save() const { return rod_.save(); }

  private:
    DirectRod rod_;
};

// Adds the values of one tick to the result. The result of an experiment holds means over the last ticks of
// pushing and over the last ticks of holding, and the largest values of the run.
template <class Run>
void record(const Run &run, int tick, int push, int all, int window, CompressionResult &result)
{
    const double error = run.length_error_now(), percent = -100.0 * error;
    result.is_sound = std::abs(error) < 0.5;
    result.largest_pct = std::max(result.largest_pct, percent);
    result.depth_max_mm = std::max(result.depth_max_mm, run.depth_max_m() * 1e3);
    if (tick < push && tick >= push - window) {
        result.pushing_pct += percent / std::min(window, push);
        result.handle_N += run.handle_N() / std::min(window, push);
    }
    if (tick < all - window) return;
    result.holding_pct += percent / std::min(window, all);
    const std::vector<bool> touching = run.touching();
    result.shape.resize(touching.size(), {Vector::Zero(), false});
    for (std::size_t i = 0; i < touching.size(); i++) result.shape[i].is_touching |= touching[i];
}

template <class Run>
CompressionResult follow(Run run, const std::string &name, const std::string &token, const Protocol &protocol,
                         const Watch &watch)
{
    CompressionResult result;
    result.name = name;
    result.token = token;
    const int push = protocol.push_ticks(), all = push + protocol.hold_ticks();
    const int window = std::max(1, static_cast<int>(std::lround(protocol.average_s * 1e3)));
    const double feed_m = (protocol.goal_m() - protocol.start_m) / push;
    for (int tick = 0; tick < all && result.is_sound; tick++) {
        run.tick(tick < push ? feed_m : 0.0);
        record(run, tick, push, all, window, result);
        if (watch && !watch(static_cast<double>(tick + 1) / all)) throw Interrupted();
    }
    const std::vector<Vector> positions = run.positions();
    result.shape.resize(positions.size(), {Vector::Zero(), false});
    for (std::size_t i = 0; i < positions.size(); i++) {
        result.shape[i].position_m = positions[i];
        result.contacts += result.shape[i].is_touching;
    }
    result.state = run.save();
    return result;
}

} // namespace

int Protocol::push_ticks() const
{
    return static_cast<int>(std::lround((goal_m() - start_m) / speed_m_s * 1e3));
}

int Protocol::hold_ticks() const
{
    return static_cast<int>(std::lround(hold_s * 1e3));
}

DirectProperties direct_of(const Preset &preset, const Protocol &protocol)
{
    return {(protocol.element_count + spare_elements) * protocol.element_m,
            protocol.element_m,
            preset.bend_N_m2(),
            preset.twist_N_m2(),
            direct_mass_kg_per_m,
            preset.radius_m(),
            wall_friction,
            axial_max_N};
}

Simulation make_simulation(const Preset &preset, const Mode &mode, const Vessel &vessel,
                           const Protocol &protocol)
{
    SimulationSettings settings;
    settings.mode = mode;
    // Shorter elements need proportionally shorter time steps h, because the product 2/l sqrt(Kp/mass per
    // length) h must stay constant (l: length of an element, Kp: stiffness of the parallel constraint).
    settings.substeps =
        static_cast<int>(std::ceil(preset.substeps * preset_element_m / protocol.element_m - 1e-9));
    return Simulation(
        rod_of(preset, protocol.element_count + spare_elements, protocol.element_m),
        Inserter(vessel.mouth_m(), vessel.direction()),
        [&vessel](const Vector &position_m) { return vessel.sample(position_m); }, settings,
        protocol.start_m);
}

DirectRod make_direct(const Preset &preset, const Vessel &vessel, const Protocol &protocol)
{
    return DirectRod(direct_of(preset, protocol), vessel.lumen(), vessel.mouth_m(), vessel.direction(),
                     protocol.start_m);
}

CompressionResult compress_baseline(const Preset &preset, const Mode &mode, const Vessel &vessel,
                                    const Protocol &protocol, const Watch &watch)
{
    return follow(BaselineRun(make_simulation(preset, mode, vessel, protocol)), mode.name(), mode.token(),
                  protocol, watch);
}

CompressionResult compress_direct(const Preset &preset, const Vessel &vessel, const Protocol &protocol,
                                  const Watch &watch)
{
    return follow(DirectRun(make_direct(preset, vessel, protocol)), "Direct", "direct", protocol, watch);
}

std::vector<std::uint8_t> to_bytes(const std::vector<double> &numbers)
{
    std::vector<std::uint8_t> bytes(numbers.size() * sizeof(double));
    std::memcpy(bytes.data(), numbers.data(), bytes.size());
    return bytes;
}

std::vector<double> to_numbers(const std::vector<std::uint8_t> &bytes)
{
    std::vector<double> numbers(bytes.size() / sizeof(double));
    std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(double));
    return numbers;
}

} // namespace vcsim3
