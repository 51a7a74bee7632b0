#include "tools/timi/timi.hpp"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace anatomy
{

namespace
{

constexpr double FRAMES_PER_S = 30.0, IODINE_MG_PER_ML = 350.0, TIP_MM = 4.0, CATHETER_RADIUS_MM = 1.0;
constexpr double RISE_S = 0.3;         // a hand needs this to reach its speed
constexpr double TOUCHES_SHARE = 0.25; // of undiluted medium along the wall: both borders are seen
constexpr double SEEN_MG_PER_CM2 =
    3.0; // iodine that dims the beam by 2 % at 55 keV, about twice a cine frame's noise

size_t branch_named(const crn::VesselTree &tree, const std::string &name)
{
    for (size_t b = 0; b < tree.branches.size(); b++)
        if (tree.branches[b].name == name) return b;
    throw std::invalid_argument("the tree has no vessel '" + name + "'");
}

/* Returns the cell at a length of a branch, measured from its first cell. */
size_t cell_at(const crn::FlowCells &cells, size_t branch, double mm)
{
    size_t cell = cells.branch_begin(branch);
    for (double behind = cells[cell].length_mm; behind < mm && cell + 1 < cells.branch_begin(branch + 1);)
        behind += cells[++cell].length_mm;
    return cell;
}

double length_mm(const crn::FlowCells &cells, size_t branch)
{
    double sum = 0.0;
    for (size_t i = cells.branch_begin(branch); i < cells.branch_begin(branch + 1); i++)
        sum += cells[i].length_mm;
    return sum;
}

/* An injection by hand through a catheter in the artery's beginning. */
class HandInjection
{
  public:
    HandInjection(const crn::VesselTree &tree, const TimiArtery &artery, const TimiCase &circumstances)
        : flow(tree), now_(circumstances), speed_(artery.ml_s * circumstances.speed), left_ml_(artery.ml)
    {
        const crn::FlowCells &cells = flow.cells();
        const size_t ostium = branch_named(tree, artery.ostium), tip = cell_at(cells, ostium, TIP_MM);
        first_ = tip + 1;
        std::vector<crn::ToolBall> catheter;
        for (size_t i = cells.branch_begin(ostium); i <= tip; i++)
            catheter.push_back({cells.middle_m(i), CATHETER_RADIUS_MM * 1e-3});
        flow.set_tools(catheter);
        const crn::CatheterMouth mouth{cells.middle_m(tip), 1.0};
        flow.set_mouths({&mouth, 1});
    }

    void step(int ms)
    {
        const double ml_s = left_ml_ > 0.0 ? speed_ * std::min(1e-3 * ms / RISE_S, 1.0) : 0.0;
        left_ml_ -= ml_s * 1e-3;
        const double beat_ms = 60e3 / now_.rate_per_min;
        crn::FlowDrive drive = crn::flow_drive(crn::steady_beat(
            static_cast<std::uint32_t>(ms + std::lround(now_.start_share * beat_ms)), now_.rate_per_min));
        for (const crn::VesselBed bed : {crn::VesselBed::left_coronary, crn::VesselBed::right_coronary})
            drive.openness[static_cast<std::size_t>(bed)] *= now_.flow;
        flow.step(drive, {ml_s, IODINE_MG_PER_ML});
    }

    bool touches_borders() const { return flow.wall_mg_per_ml(first_) >= TOUCHES_SHARE * IODINE_MG_PER_ML; }

    crn::ContrastFlow flow;

  private:
    TimiCase now_;
    double speed_, left_ml_;
    size_t first_ = 0; // the cell behind the tip
};

} // namespace

const std::vector<TimiArtery> &timi_arteries()
{
    static const std::vector<TimiArtery> all = {
        {"LAD", "LM", "LAD", 1.0, 7.1, 2.1, 36.2, 2.6},
        {"LCx", "LM", "OM1", 1.0, 7.1, 2.1, 22.2, 4.1},
        {"RCA", "RCA", "PL", 0.3, 4.8, 1.7, 20.4, 3.0},
    };
    return all;
}

double timi_frames(const crn::VesselTree &tree, const TimiArtery &artery, const TimiCase &circumstances)
{
    constexpr int LONGEST_MS = 6000;
    HandInjection injection(tree, artery, circumstances);
    const crn::FlowCells &cells = injection.flow.cells();
    const size_t last = branch_named(tree, artery.landmark);
    const size_t end = cell_at(cells, last, artery.landmark_share * length_mm(cells, last));
    int begin_ms = -1;
    for (int ms = 0; ms < LONGEST_MS; ms++) {
        injection.step(ms);
        if (begin_ms < 0 && injection.touches_borders()) begin_ms = ms;
        const double mg_per_cm2 = injection.flow.iodine_mg_per_ml(end) * 0.2 * cells[end].radius_mm;
        if (begin_ms >= 0 && mg_per_cm2 >= SEEN_MG_PER_CM2)
            return std::round((ms - begin_ms) * FRAMES_PER_S * 0.1) / 100.0;
    }
    return -1.0;
}

double coronary_sinus_s(const crn::VesselTree &tree)
{
    constexpr int LONGEST_MS = 10000;
    constexpr double FULL_SHARE = 0.1; // of undiluted medium
    size_t sinus = 0;
    while (sinus < tree.small.size() && tree.small[sinus].name != "coronary_sinus") sinus++;
    if (sinus == tree.small.size()) throw std::invalid_argument("the tree has no coronary sinus");
    HandInjection injection(tree, timi_arteries().front(), {});
    int begin_ms = -1;
    for (int ms = 0; ms < LONGEST_MS; ms++) {
        injection.step(ms);
        if (begin_ms < 0 && injection.touches_borders()) begin_ms = ms;
        const double mg_per_ml =
            injection.flow.distal().piece_mg_per_ml(sinus, tree.small[sinus].points_m.size() / 2);
        if (begin_ms >= 0 && mg_per_ml >= FULL_SHARE * IODINE_MG_PER_ML) return 1e-3 * (ms - begin_ms);
    }
    return -1.0;
}

double timi_mean_frames(const crn::VesselTree &tree, const TimiArtery &artery, TimiCase now)
{
    double sum = 0.0;
    for (const double share : {0.0, 0.25, 0.5, 0.75}) {
        now.start_share = share;
        const double frames = timi_frames(tree, artery, now);
        if (frames < 0.0) return -1.0;
        sum += frames;
    }
    return 0.25 * sum;
}

} // namespace anatomy
