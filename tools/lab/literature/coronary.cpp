// Measures blood and contrast medium in the arteries of the shipped heart, as Doppler wires and frame counts
// do.
#include "host/effects/flow_network.hpp"
#include "host/effects/lesion_figures.hpp"
#include "tools/anatomy/small/stated.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include "tools/lab/literature/experiments.hpp"
#include "tools/lab/literature/heart_flow.hpp"
#include "tools/timi/flow_tree.hpp"
#include "tools/timi/timi.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

namespace crn::literature
{

VesselTree heart_flow_tree()
{
    anatomy::VesselTree heart = anatomy::shipped_vessels("heart");
    anatomy::add_stated_branches(heart);
    return anatomy::flow_tree(heart);
}

std::size_t branch_named(const VesselTree &tree, const std::string &name)
{
    for (std::size_t k = 0; k < tree.branches.size(); k++)
        if (tree.branches[k].name == name) return k;
    throw std::runtime_error("the heart has no artery " + name);
}

namespace
{

constexpr double rate_per_min = 70;

// The velocity of the blood at one place over one beat, in steps of a millisecond. A Doppler wire shows the
// fastest blood, on the axis: twice the mean of the cross-section.
struct Doppler {
    std::vector<double> cm_s;
    std::size_t systole_ms = 0;

    double mean(std::size_t begin, std::size_t end) const
    {
        double sum = 0;
        for (std::size_t k = begin; k < end; k++) sum += cm_s[k];
        return sum / double(end - begin);
    }
    double diastole_over_systole() const { return mean(systole_ms, cm_s.size()) / mean(0, systole_ms); }
    double peak_ratio() const
    {
        const auto middle = cm_s.begin() + std::ptrdiff_t(systole_ms);
        return *std::max_element(middle, cm_s.end()) / *std::max_element(cm_s.begin(), middle);
    }
    double peak() const { return *std::max_element(cm_s.begin(), cm_s.end()); }
};

Doppler doppler(const VesselTree &tree, const std::string &branch, double share, double openness)
{
    const FlowCells cells(tree);
    FlowNetwork network(cells, blood_mPa_s);
    const std::size_t number = branch_named(tree, branch), begin = cells.branch_begin(number),
                      end = cells.branch_begin(number + 1);
    const std::size_t cell = begin + std::min(std::size_t(share * double(end - begin)), end - begin - 1);
    const double area_cm2 = M_PI * std::pow(cells[cell].radius_mm / 10, 2);
    Doppler trace;
    for (std::uint32_t ms = 0; ms < 60000 / rate_per_min; ms++) {
        const BeatPhase phase = steady_beat(ms, rate_per_min);
        FlowDrive drive = flow_drive(phase);
        for (const VesselBed bed : {VesselBed::left_coronary, VesselBed::right_coronary})
            drive.openness[std::size_t(bed)] *= openness;
        network.settle(drive);
        trace.cm_s.push_back(2 * network.inflow_ml_s(network.run_of(cell)) / area_cm2);
        trace.systole_ms += drive.is_valve_open;
    }
    return trace;
}

validate::Series series_of(const char *label, const Doppler &trace)
{
    validate::Series series{label, {}, {}};
    for (std::size_t k = 0; k < trace.cm_s.size(); k += 4) {
        series.x.push_back(double(k));
        series.y.push_back(trace.cm_s[k]);
    }
    return series;
}

Figures phasic_ratios()
{
    const VesselTree tree = heart_flow_tree();
    const Doppler left = doppler(tree, "LM", 0.5, 1), right = doppler(tree, "RCA", 0.1, 1);
    return {{{"left_rest", left.diastole_over_systole()},
             {"left_hyperaemia", doppler(tree, "LM", 0.5, hyperaemia_openness).diastole_over_systole()},
             {"right_rest", right.diastole_over_systole()},
             {"right_hyperaemia", doppler(tree, "RCA", 0.1, hyperaemia_openness).diastole_over_systole()}},
            {{"Velocity on the axis, at rest",
              "time since the valve opened (ms)",
              "velocity (cm/s)",
              {series_of("left main artery", left), series_of("right artery", right)}}}};
}

Figures peak_ratios()
{
    const VesselTree tree = heart_flow_tree();
    const Doppler left = doppler(tree, "LM", 0.5, 1), right = doppler(tree, "RCA", 0.1, 1);
    return {{{"left_main", left.peak_ratio()},
             {"right", right.peak_ratio()},
             {"left_main_diastole", left.peak()},
             {"right_diastole", right.peak()}},
            {}};
}

double reserve(const VesselTree &tree, const char *branch, double share)
{
    const Doppler rest = doppler(tree, branch, share, 1),
                  hyperaemia = doppler(tree, branch, share, hyperaemia_openness);
    return hyperaemia.mean(0, hyperaemia.cm_s.size()) / rest.mean(0, rest.cm_s.size());
}

Figures normal_reserves()
{
    const VesselTree tree = heart_flow_tree();
    return {{{"lad", reserve(tree, "LAD", 0.1)},
             {"lcx", reserve(tree, "LCX", 0.2)},
             {"rca", reserve(tree, "RCA", 0.1)}},
            {}};
}

Figures regional_reserves()
{
    const VesselTree tree = heart_flow_tree();
    Figures figures;
    for (auto [name, branch, share] :
         {std::tuple{"left_main", "LM", 0.5}, {"lad", "LAD", 0.1}, {"lcx", "LCX", 0.2}}) {
        const std::string place = name;
        figures.values[place] = reserve(tree, branch, share);
        // The catheter's wide beam shows the mean of the cross-section, half of the velocity on the axis.
        const Doppler rest = doppler(tree, branch, share, 1),
                      hyperaemia = doppler(tree, branch, share, hyperaemia_openness);
        figures.values[place + "_rest"] = rest.mean(0, rest.cm_s.size()) / 2;
        figures.values[place + "_hyperaemia"] = hyperaemia.mean(0, hyperaemia.cm_s.size()) / 2;
    }
    return figures;
}

Figures lad_velocities()
{
    const VesselTree tree = heart_flow_tree();
    return {{{"proximal", doppler(tree, "LAD", 0.1, 1).peak()},
             {"middle", doppler(tree, "LAD", 0.45, 1).peak()},
             {"distal", doppler(tree, "LAD", 0.8, 1).peak()}},
            {}};
}

Figures frame_counts()
{
    const VesselTree tree = heart_flow_tree();
    Figures figures;
    double corrected = 0;
    for (const anatomy::TimiArtery &artery : anatomy::timi_arteries()) {
        const double frames = anatomy::timi_mean_frames(tree, artery, {});
        figures.values[artery.name] = frames;
        corrected += frames / (artery.name == "LAD" ? 1.7 : 1) / 3;
    }
    figures.values["corrected"] = corrected;
    return figures;
}

Figures coronary_sinus()
{
    return {{{"filling", anatomy::coronary_sinus_s(heart_flow_tree())}}, {}};
}

Figures injection_speed()
{
    const VesselTree tree = heart_flow_tree();
    Figures figures;
    for (const anatomy::TimiArtery &artery : anatomy::timi_arteries()) {
        const double usual = anatomy::timi_mean_frames(tree, artery, {});
        figures.values[artery.name + "_slower"] =
            anatomy::timi_mean_frames(tree, artery, {.speed = 0.7}) - usual;
        figures.values[artery.name + "_faster"] =
            anatomy::timi_mean_frames(tree, artery, {.speed = 1.4}) - usual;
    }
    return figures;
}

} // namespace

std::vector<Experiment> coronary_experiments()
{
    return {{"coronary_phases", phasic_ratios},      {"coronary_peaks", peak_ratios},
            {"coronary_sinus", coronary_sinus},      {"coronary_reserve", normal_reserves},
            {"regional_reserve", regional_reserves}, {"lad_velocity", lad_velocities},
            {"timi_frames", frame_counts},           {"timi_injection", injection_speed}};
}

} // namespace crn::literature
