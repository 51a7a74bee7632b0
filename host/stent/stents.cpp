#include "host/stent/stents.hpp"
#include "host/stent/figures.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>

namespace seld
{

void Stents::add(const StentDesign &design, double mount_arc_mm)
{
    if (!stents_.empty() && stents_.back().is_on_balloon()) stents_.pop_back();
    stents_.emplace_back(design, mount_arc_mm);
}

// The older ones first: what is let go in this picture lies on where they are now.
void Stents::step(const StentWall *wall, const BalloonPose *balloon)
{
    std::vector<StentSleeve> sleeves;
    const bool is_mounted = !stents_.empty() && stents_.back().is_on_balloon();
    for (std::size_t i = 0; i < stents_.size(); ++i) {
        const bool is_own = i + 1 == stents_.size();
        const double layer_mm = is_mounted && !is_own ? stents_.back().design().strut_thickness_mm : 0.0;
        const StentBalloon inside{balloon, layer_mm};
        const bool has_inside = balloon && !is_own;
        stents_[i].step({wall, is_own ? balloon : nullptr, std::span(&inside, has_inside ? 1 : 0), sleeves});
        if (stents_[i].stage() == StentStage::deployed) sleeves.push_back(stents_[i].sleeve());
    }
}

std::vector<StentHold> Stents::holds(const VesselWall &vessel, std::size_t lesion,
                                     std::uint32_t stations) const
{
    constexpr double steps = 256;
    std::vector<StentHold> result;
    const VesselWall::Stretch stretch = vessel.lesion_mm(lesion);
    if (stretch.is_empty() || stations < 2) return result;
    std::vector<std::uint32_t> open(stations, 0);
    for (const Stent &stent : stents_) {
        if (stent.stage() != StentStage::deployed) continue;
        const StentFigures figures = stent_figures(stent, nullptr);
        std::vector<double> along;
        for (const StentRing &ring : figures.rings) along.push_back(vessel.along_of(ring.centre_mm));
        const double reach = stent.design().strut_length_mm / 2;
        for (std::uint32_t k = 0; k < stations; ++k) {
            const double at = stretch.from_mm + (stretch.to_mm - stretch.from_mm) * k / (stations - 1);
            std::size_t nearest = 0;
            for (std::size_t i = 1; i < along.size(); ++i)
                if (std::abs(along[i] - at) < std::abs(along[nearest] - at)) nearest = i;
            const double pitch = figures.length_mm / stent.design().rings;
            if (std::abs(along[nearest] - at) > std::max(reach, pitch / 2)) continue;
            const double outside = figures.rings[nearest].diameter_mm / 2 + stent.design().strut_thickness_mm;
            const double narrow = vessel.narrow_radius_mm(at), wide = vessel.healthy_radius_mm(at);
            if (!(wide > narrow)) continue;
            const double share = std::clamp((outside - narrow) / (wide - narrow), 0.0, 1.0);
            open[k] = std::max(open[k], static_cast<std::uint32_t>(std::lround(share * steps)));
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

} // namespace seld
