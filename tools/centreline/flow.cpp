// Computes the flow conductance of each branch from the outlets towards the inlet, and then the flows from
// the inlet towards the outlets.
#include "tools/centreline/flow.hpp"

#include <cmath>

namespace crn::centreline
{
namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr double Pa_per_mmHg = 133.322;
constexpr double mm3_s_per_ml_min = 1000.0 / 60.0;

double area_mm2(const Sphere &sphere)
{
    return pi * sphere.radius_mm * sphere.radius_mm;
}

struct Network {
    const Tree &tree;
    double viscosity_mPa_s;
    std::vector<std::vector<std::size_t>> children; // of each branch
    std::vector<std::vector<double>> conductance;   // from each sphere of each branch onwards, mm^3/(s Pa)
};

// If no other branch begins at the end of a branch, this end is an outlet, which is followed by a vascular
// bed with a flow resistance.
double bed_conductance(const Branch &branch, double bed_Pa_s)
{
    return std::pow(branch.spheres.back().radius_mm, 3) / bed_Pa_s;
}

// Every branch has a higher number than its parent, so a loop from the last branch to the first treats every
// child before its parent.
void find_conductances(Network &network, double bed_Pa_s)
{
    const Tree &tree = network.tree;
    network.conductance.resize(tree.branches.size());
    for (std::size_t b = tree.branches.size(); b-- > 0;) {
        const Branch &branch = tree.branches[b];
        std::vector<double> &own = network.conductance[b];
        own.assign(branch.spheres.size(), 0.0);
        for (std::size_t child : network.children[b])
            own[tree.branches[child].parent_sphere] += network.conductance[child][0];
        if (own.back() == 0) own.back() = bed_conductance(branch, bed_Pa_s);
        for (std::size_t i = branch.spheres.size() - 1; i-- > 0;)
            own[i] += 1 / (1 / own[i + 1] + tube_resistance(branch.spheres[i], branch.spheres[i + 1],
                                                            network.viscosity_mPa_s));
    }
}

double outlet_cubes_mm3(const Network &network, std::size_t branch)
{
    const Tree &tree = network.tree;
    double sum = 0;
    bool is_outlet = true;
    for (std::size_t child : network.children[branch]) {
        sum += outlet_cubes_mm3(network, child);
        is_outlet =
            is_outlet && tree.branches[child].parent_sphere + 1 < tree.branches[branch].spheres.size();
    }
    return sum + (is_outlet ? std::pow(tree.branches[branch].spheres.back().radius_mm, 3) : 0);
}

} // namespace

// The flow resistance is R = 8 mu/pi times the integral of r^-4 along the length (mu: viscosity, r: radius).
// For a tube with end radii a and b, the mean of r^-4 over the length (r: radius) is (a^2 + a b + b^2) / (3
// a^3 b^3).
double tube_resistance(const Sphere &a, const Sphere &b, double viscosity_mPa_s)
{
    const double length = (b.centre_mm - a.centre_mm).norm(), ra = a.radius_mm, rb = b.radius_mm;
    const double mean = (ra * ra + ra * rb + rb * rb) / (3 * ra * ra * ra * rb * rb * rb);
    return 8 * viscosity_mPa_s * 1e-3 * length * mean / pi;
}

std::vector<double> set_flow(Tree &tree, const FlowSettings &settings)
{
    Network network{tree, settings.viscosity_mPa_s, {}, {}};
    network.children.resize(tree.branches.size());
    for (std::size_t b = 0; b < tree.branches.size(); ++b)
        if (tree.branches[b].parent >= 0) network.children[tree.branches[b].parent].push_back(b);
    std::vector<double> into(tree.branches.size(), 0.0);
    // Every root branch has its own inlet, so the vascular beds are computed separately for each root branch.
    std::vector<int> root(tree.branches.size());
    for (std::size_t b = 0; b < tree.branches.size(); ++b)
        root[b] = tree.branches[b].parent < 0 ? static_cast<int>(b) : root[tree.branches[b].parent];
    for (std::size_t r = 0; r < tree.branches.size(); ++r) {
        if (tree.branches[r].parent >= 0) continue;
        const double inlet = settings.inlet_ml_min > 0
                                 ? settings.inlet_ml_min * mm3_s_per_ml_min
                                 : settings.inlet_mm_s * area_mm2(tree.branches[r].spheres.front());
        const double bed = settings.pressure_mmHg * Pa_per_mmHg / inlet * outlet_cubes_mm3(network, r);
        find_conductances(network, bed);
        into[r] = inlet;
        for (std::size_t b = r; b < tree.branches.size(); ++b) {
            if (root[b] != static_cast<int>(r)) continue;
            double flow = into[b];
            std::vector<Sphere> &spheres = tree.branches[b].spheres;
            for (std::size_t i = 0; i < spheres.size(); ++i) {
                spheres[i].speed_mm_s = flow / area_mm2(spheres[i]);
                const double whole = network.conductance[b][i];
                for (std::size_t child : network.children[b])
                    if (tree.branches[child].parent_sphere == i) {
                        into[child] = into[b] > 0 ? flow * network.conductance[child][0] / whole : 0;
                    }
                double taken = 0;
                for (std::size_t child : network.children[b])
                    if (tree.branches[child].parent_sphere == i) taken += into[child];
                flow -= taken;
            }
        }
    }
    for (double &flow : into) flow /= mm3_s_per_ml_min;
    return into;
}

} // namespace crn::centreline
