#include "host/stent/stents.hpp"
#include "host/stent/figures.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>

namespace crn
{

void Stents::add(const StentDesign &design, double mount_arc_mm)
{
    take_out();
    stents_.emplace_back(design, mount_arc_mm);
}

void Stents::take_out()
{
    if (!stents_.empty() && stents_.back().is_on_balloon()) stents_.pop_back();
}

void Stents::step(const StentWall *wall, const BalloonPose *balloon)
{
    step(std::vector<const StentWall *>(stents_.size(), wall), balloon);
}

// Stents that were deployed earlier are stepped first, because a stent that is deployed now lies on their
// present inner side.
void Stents::step(std::span<const StentWall *const> walls, const BalloonPose *balloon)
{
    std::vector<StentSleeve> sleeves;
    const bool is_mounted = !stents_.empty() && stents_.back().is_on_balloon();
    for (std::size_t i = 0; i < stents_.size(); ++i) {
        const bool is_own = i + 1 == stents_.size();
        const double layer_mm = is_mounted && !is_own ? stents_.back().design().strut_thickness_mm : 0.0;
        const StentBalloon inside{balloon, layer_mm};
        const bool has_inside = balloon && !is_own;
        const StentWall *wall = i < walls.size() ? walls[i] : nullptr;
        stents_[i].step({wall, is_own ? balloon : nullptr, std::span(&inside, has_inside ? 1 : 0), sleeves});
        if (stents_[i].stage() == StentStage::deployed) sleeves.push_back(stents_[i].sleeve());
    }
}

namespace
{

// Describes a ring of a stent that holds the surrounding wall open with its outer side.
struct HoldingRing {
    double along_mm = 0.0, radius_mm = 0.0;
};

// Returns the rings of a stent that are opened and lie in the given vessel.
std::vector<HoldingRing> holding_rings(const Stent &stent, const VesselWall &vessel)
{
    std::vector<HoldingRing> rings;
    const bool is_deployed = stent.stage() == StentStage::deployed;
    if (!stent.was_placed() || (!is_deployed && !stent.is_on_balloon())) return rings;
    const StentFigures figures = stent_figures(stent, nullptr);
    const int around = 2 * stent.design().crowns;
    for (int ring = 0; ring < stent.design().rings; ++ring) {
        const StentRing &now = figures.rings[static_cast<std::size_t>(ring)];
        const VesselWall::Foot foot = vessel.foot_of(now.centre_mm);
        if (!now.is_opened || foot.off_mm > vessel.healthy_radius_mm(foot.along_mm)) continue;
        double kept = 0.0; // radius of the struts' axis after the balloon has deflated
        for (int k = 0; k < around; ++k)
            kept += stent.free_radius_mm(stent.points()[stent.lattice().point(ring, k)]) / around;
        const double thickness = stent.design().strut_thickness_mm;
        rings.push_back(
            {foot.along_mm, is_deployed ? now.diameter_mm / 2 + thickness : kept + thickness / 2});
    }
    return rings;
}

} // namespace

std::vector<StentHold> Stents::holds(const VesselWall &vessel, std::size_t lesion, std::uint32_t stations,
                                     std::span<const double> open_now) const
{
    constexpr double steps = 256;
    std::vector<StentHold> result;
    const VesselWall::Stretch stretch = vessel.places_mm(lesion);
    if (stretch.is_empty() || stations < 2) return result;
    std::vector<std::uint32_t> open(stations, 0);
    for (const Stent &stent : stents_) {
        const double pitch = stent.design().length_mm / stent.design().rings;
        const double reach = std::max(stent.design().strut_length_mm, pitch) / 2;
        const std::vector<HoldingRing> rings = holding_rings(stent, vessel);
        for (std::uint32_t k = 0; !rings.empty() && k < stations; ++k) {
            const double at = stretch.from_mm + (stretch.to_mm - stretch.from_mm) * k / (stations - 1);
            const auto nearest =
                std::min_element(rings.begin(), rings.end(), [&](const HoldingRing &a, const HoldingRing &b) {
                    return std::abs(a.along_mm - at) < std::abs(b.along_mm - at);
                });
            if (std::abs(nearest->along_mm - at) > reach) continue;
            const double narrow = vessel.narrow_radius_mm(at), wide = vessel.healthy_radius_mm(at);
            if (!(wide > narrow)) continue;
            const double share = std::clamp((nearest->radius_mm - narrow) / (wide - narrow), 0.0, 1.0);
            auto held = static_cast<std::uint32_t>(std::lround(share * steps));
            if (k < open_now.size())
                held = std::min(held, static_cast<std::uint32_t>(std::clamp(open_now[k], 0.0, 1.0) * steps));
            open[k] = std::max(open[k], held);
        }
    }
    for (std::uint32_t k = 0; k < stations; ++k) {
        if (open[k] == 0) continue;
        const bool goes_on =
            !result.empty() && result.back().last + 1 == k && result.back().open_256 == open[k];
        if (goes_on)
            result.back().last = k;
        else
            result.push_back({k, k, open[k]});
    }
    return result;
}

std::vector<std::uint8_t> Stents::snapshot() const
{
    std::vector<std::uint8_t> bytes;
    for (const Stent &stent : stents_) {
        const std::vector<std::uint8_t> one = stent.snapshot();
        const std::uint64_t size = one.size();
        const std::size_t at = bytes.size();
        bytes.resize(at + sizeof size);
        std::memcpy(bytes.data() + at, &size, sizeof size);
        bytes.insert(bytes.end(), one.begin(), one.end());
    }
    return bytes;
}

bool Stents::restore(std::span<const std::uint8_t> bytes)
{
    std::vector<Stent> stents = stents_;
    for (Stent &stent : stents) {
        std::uint64_t size = 0;
        if (bytes.size() < sizeof size) return false;
        std::memcpy(&size, bytes.data(), sizeof size);
        bytes = bytes.subspan(sizeof size);
        if (size > bytes.size() || !stent.restore(bytes.first(size))) return false;
        bytes = bytes.subspan(size);
    }
    if (!bytes.empty()) return false;
    stents_ = std::move(stents);
    return true;
}

} // namespace crn
