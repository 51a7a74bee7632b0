#include "host/effects/distal_flow.hpp"
#include "host/effects/small_flows.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace crn
{
namespace
{

using std::numbers::pi;
constexpr std::uint32_t no_outlet = std::numeric_limits<std::uint32_t>::max();

double piece_volume_ml(const VesselBranch &vessel, std::size_t piece)
{
    const double length_m = (vessel.points_m[piece + 1] - vessel.points_m[piece]).norm();
    const double a = vessel.radii_m[piece], b = vessel.radii_m[piece + 1];
    return pi * length_m * (a * a + a * b + b * b) / 3.0 * 1e6;
}

} // namespace

// Mean transit times from the small arteries to the small veins. Of the heart: the coronary sinus fills 4.2 s
// after the coronary artery (docs/contrast.md). Of the kidneys: the nephrogram peaks 4 to 6 s after the renal
// artery, and the vein fills after 4 to 8 s. The others are assumed.
BedTransit bed_transit(VesselBed bed)
{
    switch (bed) {
    case VesselBed::left_coronary:
    case VesselBed::right_coronary:
        return {4.5, 3};
    case VesselBed::kidney:
        return {4.0, 6};
    case VesselBed::gut:
        return {8.0, 2};
    case VesselBed::systemic:
        break;
    }
    return {10.0, 2};
}

// Makes the volumes outlet by outlet; in each outlet's list, a volume comes after the one that feeds it.
class DistalFlow::Builder
{
  public:
    Builder(DistalFlow &flow, const VesselTree &tree, const FlowCells &cells)
        : flow_(flow), tree_(tree), cells_(cells), flows_ml_s_(small_vessel_flows_ml_s(tree)),
          continued_(small_vessels_continued(tree)), children_(tree.small.size()),
          joining_(tree.small.size()), roots_(cells.size())
    {
    }

    void build()
    {
        sort_vessels();
        add_veins();
        flow_.outlet_of_cell_.assign(cells_.size(), no_outlet);
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            if (!(cells_[i].outlet_ml_s > 0.0)) continue;
            flow_.outlet_of_cell_[i] = static_cast<std::uint32_t>(flow_.outlets_.size());
            const double mean_ml_s = cells_[i].outlet_ml_s;
            flow_.outlets_.push_back({mean_ml_s, flow_.volumes_.size(), 0});
            for (std::size_t vessel : roots_[i]) add_vessel(vessel, -1, mean_ml_s);
            if (cells_[i].end_ml_s > 0.0)
                add_bed(cells_[i].branch, cells_[i].bed, -1, mean_ml_s, cells_[i].end_ml_s);
            flow_.outlets_.back().end = flow_.volumes_.size();
        }
        add_joints();
    }

  private:
    bool is_small(int parent) const { return parent >= static_cast<int>(tree_.branches.size()); }

    void sort_vessels()
    {
        for (std::size_t v = 0; v < tree_.small.size(); ++v) {
            const VesselBranch &vessel = tree_.small[v];
            flow_.is_vein_.push_back(vessel.is_vein ? 1 : 0);
            if (vessel.is_vein) continue;
            if (vessel.joins >= 0)
                joining_[static_cast<std::size_t>(vessel.joins) - tree_.branches.size()].push_back(v);
            const auto parent = static_cast<std::size_t>(vessel.parent);
            if (is_small(vessel.parent))
                children_[parent - tree_.branches.size()].push_back(v);
            else
                roots_[cells_.cell_at_point(parent, vessel.parent_point)].push_back(v);
        }
        flow_.first_piece_.assign(tree_.small.size(), -1);
    }

    void add_veins()
    {
        for (std::size_t v = 0; v < tree_.small.size(); ++v) {
            const VesselBranch &vessel = tree_.small[v];
            if (!vessel.is_vein) continue;
            int to = -1;
            if (is_small(vessel.parent)) {
                const std::size_t parent = static_cast<std::size_t>(vessel.parent) - tree_.branches.size();
                to = flow_.first_piece_[parent] +
                     static_cast<int>(std::max<std::size_t>(vessel.parent_point, 1)) - 1;
            }
            flow_.first_piece_[v] = static_cast<int>(flow_.veins_.size());
            for (std::size_t piece = 0; piece + 1 < vessel.points_m.size(); ++piece) {
                flow_.veins_.push_back({to, piece_volume_ml(vessel, piece)});
                to = static_cast<int>(flow_.veins_.size()) - 1;
            }
        }
    }

    // `come_ml_s` comes from the volume `from`, through which `from_ml_s` flow.
    std::size_t add_volume(int from, double from_ml_s, double come_ml_s, double volume_ml)
    {
        flow_.volumes_.push_back(
            {from, from_ml_s > 0.0 ? come_ml_s / from_ml_s : 0.0, 1.0 / volume_ml, -1, false});
        flow_.piece_ml_.push_back(volume_ml);
        return flow_.volumes_.size() - 1;
    }

    // The flow in a vessel falls where others leave it, and grows where others join it.
    void add_vessel(std::size_t v, int from, double from_ml_s)
    {
        const VesselBranch &vessel = tree_.small[v];
        const std::size_t pieces = vessel.points_m.size() - 1;
        std::vector<double> leaving_ml_s(pieces, 0.0); // at the end of each piece
        for (std::size_t child : children_[v]) leaving_ml_s[piece_before(child)] += flows_ml_s_[child];
        double through_ml_s = flows_ml_s_[v];
        flow_.first_piece_[v] = static_cast<int>(flow_.volumes_.size());
        std::vector<double> through(pieces, 0.0), joining_ml_s(pieces, 0.0); // at the beginning of each piece
        for (std::size_t other : joining_[v])
            joining_ml_s[tree_.joined_piece(tree_.small[other])] += tree_.small[other].flow_ml_s;
        for (std::size_t piece = 0; piece < pieces; ++piece) {
            from =
                static_cast<int>(add_volume(from, from_ml_s, through_ml_s, piece_volume_ml(vessel, piece)));
            through_ml_s += joining_ml_s[piece];
            from_ml_s = through[piece] = through_ml_s;
            through_ml_s -= leaving_ml_s[piece];
        }
        const int first = flow_.first_piece_[v];
        for (std::size_t child : children_[v]) {
            const std::size_t piece = piece_before(child);
            add_vessel(child, first + static_cast<int>(piece), through[piece]);
        }
        // More may join a vessel than its branches need; the rest goes into a bed at its end.
        const bool has_rest = !joining_[v].empty() && through_ml_s > 1e-6;
        if (continued_[v] && !has_rest) return;
        const double end_ml_s = std::max(through_ml_s, 0.0);
        add_bed(static_cast<int>(tree_.branches.size() + v), vessel.bed, from, from_ml_s, end_ml_s);
    }

    void add_joints()
    {
        for (std::size_t v = 0; v < tree_.small.size(); ++v) {
            if (tree_.small[v].joins < 0) continue;
            const std::size_t joined = static_cast<std::size_t>(tree_.small[v].joins) - tree_.branches.size();
            if (flow_.first_piece_[v] < 0) continue;
            const std::size_t from =
                static_cast<std::size_t>(flow_.first_piece_[v]) + tree_.small[v].points_m.size() - 2;
            if (flow_.first_piece_[joined] < 0)
                flow_.volumes_[from].is_last = true; // nothing flows there: the blood is gone
            else
                flow_.joints_.push_back({from, static_cast<std::size_t>(flow_.first_piece_[joined]) +
                                                   tree_.joined_piece(tree_.small[v])});
        }
    }

    std::size_t piece_before(std::size_t child) const
    {
        return std::max<std::size_t>(tree_.small[child].parent_point, 1) - 1;
    }

    void add_bed(int vessel, VesselBed kind, int from, double from_ml_s, double through_ml_s)
    {
        const BedTransit transit = bed_transit(kind);
        flow_.beds_.push_back({vessel, kind});
        flow_.bed_first_.push_back(flow_.volumes_.size());
        for (int i = 0; i < transit.volumes; ++i, from_ml_s = through_ml_s)
            from = static_cast<int>(
                add_volume(from, from_ml_s, through_ml_s, through_ml_s * transit.mean_s / transit.volumes));
        flow_.bed_end_.push_back(flow_.volumes_.size());
        flow_.volumes_.back().is_last = true;
        flow_.volumes_.back().vein =
            nearest_vein(tree_.numbered(static_cast<std::size_t>(vessel)).points_m.back(), kind);
    }

    int nearest_vein(const Eigen::Vector3d &place_m, VesselBed kind) const
    {
        int nearest = -1;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t v = 0; v < tree_.small.size(); ++v) {
            const VesselBranch &vein = tree_.small[v];
            if (!vein.is_vein || vein.bed != kind) continue;
            for (std::size_t i = 1; i < vein.points_m.size(); ++i) {
                const double square = (vein.points_m[i] - place_m).squaredNorm();
                if (!(square < least)) continue;
                least = square;
                nearest = flow_.first_piece_[v] + static_cast<int>(i) - 1;
            }
        }
        return nearest;
    }

    DistalFlow &flow_;
    const VesselTree &tree_;
    const FlowCells &cells_;
    std::vector<double> flows_ml_s_;
    std::vector<bool> continued_;
    std::vector<std::vector<std::size_t>> children_, joining_, roots_;
};

DistalFlow::DistalFlow(const VesselTree &tree, const FlowCells &cells)
{
    Builder(*this, tree, cells).build();
    waiting_mg_.assign(outlets_.size(), 0.0);
    waiting_ml_ = waiting_mg_;
    mg_.assign(volumes_.size(), 0.0);
    out_mg_ = out_ml_ = joined_mg_ = joined_ml_ = mg_;
    vein_mg_.assign(veins_.size(), 0.0);
    vein_in_mg_ = vein_in_ml_ = vein_mg_;
}

void DistalFlow::step()
{
    if (++waited_ms_ < step_ms) return;
    waited_ms_ = 0;
    advance_arteries();
    if (!veins_.empty()) advance_veins();
}

// If v ml flow through a volume V that is always well mixed, the implicit step leaves m / (1 + v/V) of the m
// mg that were in it or came in.
void DistalFlow::advance_arteries()
{
    std::fill(vein_in_mg_.begin(), vein_in_mg_.end(), 0.0);
    std::fill(vein_in_ml_.begin(), vein_in_ml_.end(), 0.0);
    for (const Joint &joint : joints_) {
        joined_mg_[joint.to] += joint.mg;
        joined_ml_[joint.to] += joint.ml;
    }
    for (std::size_t o = 0; o < outlets_.size(); ++o) {
        const double entering_mg = waiting_mg_[o], ml = waiting_ml_[o];
        waiting_mg_[o] = waiting_ml_[o] = 0.0;
        entered_mg_ += entering_mg;
        for (std::size_t i = outlets_[o].first; i < outlets_[o].end; ++i) {
            const Volume &volume = volumes_[i];
            const double come_mg =
                volume.split * (volume.from < 0 ? entering_mg : out_mg_[volume.from]) + joined_mg_[i];
            out_ml_[i] = volume.split * (volume.from < 0 ? ml : out_ml_[volume.from]) + joined_ml_[i];
            const double turns = out_ml_[i] * volume.per_ml, all_mg = mg_[i] + come_mg;
            out_mg_[i] = all_mg != 0.0 ? all_mg * (turns / (1.0 + turns)) : 0.0; // most volumes hold none
            mg_[i] = all_mg - out_mg_[i];
            if (!volume.is_last) continue;
            if (volume.vein < 0) {
                gone_mg_ += out_mg_[i];
            } else {
                vein_in_mg_[volume.vein] += out_mg_[i];
                vein_in_ml_[volume.vein] += out_ml_[i];
            }
        }
    }
    for (Joint &joint : joints_) {
        joint.mg = out_mg_[joint.from];
        joint.ml = out_ml_[joint.from];
        joined_mg_[joint.to] = joined_ml_[joint.to] = 0.0;
    }
}

// The pieces of veins are listed from the heart outwards.
void DistalFlow::advance_veins()
{
    for (std::size_t i = veins_.size(); i-- > 0;) {
        const double turns = vein_in_ml_[i] / veins_[i].volume_ml, all_mg = vein_mg_[i] + vein_in_mg_[i];
        const double out_mg = all_mg * (turns / (1.0 + turns));
        vein_mg_[i] = all_mg - out_mg;
        if (veins_[i].to < 0) {
            gone_mg_ += out_mg;
            continue;
        }
        vein_in_mg_[veins_[i].to] += out_mg;
        vein_in_ml_[veins_[i].to] += vein_in_ml_[i];
    }
}

double DistalFlow::piece_mg_per_ml(std::size_t vessel, std::size_t piece) const
{
    if (first_piece_[vessel] < 0) return 0.0;
    const std::size_t at = static_cast<std::size_t>(first_piece_[vessel]) + piece;
    return is_vein_[vessel] ? vein_mg_[at] / veins_[at].volume_ml : mg_[at] / piece_ml_[at];
}

double DistalFlow::bed_mg(std::size_t bed) const
{
    double sum = 0.0;
    for (std::size_t i = bed_first_[bed]; i < bed_end_[bed]; ++i) sum += mg_[i];
    return sum;
}

double DistalFlow::visible_mg() const
{
    double sum = held_mg();
    for (std::size_t bed = 0; bed < beds_.size(); ++bed)
        if (beds_[bed].kind == VesselBed::systemic) sum -= bed_mg(bed);
    return sum;
}

DistalIodine DistalFlow::iodine() const
{
    DistalIodine sum{entered_mg_, 0.0, 0.0, 0.0, gone_mg_};
    for (double mg : mg_) sum.small_mg += mg;
    for (std::size_t bed = 0; bed < beds_.size(); ++bed) sum.beds_mg += bed_mg(bed);
    sum.small_mg -= sum.beds_mg;
    for (const Joint &joint : joints_) sum.small_mg += joint.mg;
    for (double mg : vein_mg_) sum.veins_mg += mg;
    for (double mg : waiting_mg_) {
        sum.entered_mg += mg;
        sum.small_mg += mg;
    }
    return sum;
}

double DistalFlow::held_mg() const
{
    double sum = 0.0;
    for (const std::vector<double> *part : {&mg_, &vein_mg_, &waiting_mg_})
        for (double mg : *part) sum += mg;
    for (const Joint &joint : joints_) sum += joint.mg;
    return sum;
}

void DistalFlow::archive(StateArchive &state)
{
    constexpr double most_mg = 1e6;
    state.integer(waited_ms_, 0, step_ms - 1);
    state.real(entered_mg_);
    state.real(gone_mg_);
    for (std::vector<double> *part : {&waiting_mg_, &waiting_ml_, &mg_, &vein_mg_})
        state.reals(*part, -most_mg, most_mg);
    for (Joint &joint : joints_)
        for (double *value : {&joint.ml, &joint.mg}) state.real(*value, -most_mg, most_mg);
}

} // namespace crn
