#include "tools/anatomy/small/twigs.hpp"
#include "tools/anatomy/output.hpp"
#include <algorithm>
#include <map>

namespace anatomy
{

const Vessel *named(const std::vector<Vessel> &vessels, const std::string &name)
{
    const auto found = std::find_if(vessels.begin(), vessels.end(),
                                    [&](const Vessel &vessel) { return vessel.name == name; });
    return found == vessels.end() ? nullptr : &*found;
}

void add_twigs(const Growth &growth, const std::vector<Vessel> &stems, Bed bed_of_all,
               std::vector<SmallVessel> &vessels)
{
    const std::vector<Twig> twigs = growth.twigs();
    std::vector<std::string> stem_of;
    std::map<std::string, int> ends;
    for (const Twig &twig : twigs) {
        stem_of.push_back(twig.stem.empty() ? stem_of[twig.parent] : twig.stem);
        ends[stem_of.back()]++;
    }
    double flow_ml_min = 0.0;
    int stated = 0;
    for (const Vessel &stem : stems)
        if (stem.flow_ml_min > 0 && ends.count(stem.name) > 0) {
            flow_ml_min += stem.flow_ml_min;
            stated += ends[stem.name];
        }
    // Where no flow is stated, as in a vessel that only divides, an end gets half of the usual flow.
    const double usual_ul_s = stated > 0 ? flow_ml_min / stated * 1e3 / 60.0 : 1.0;
    const size_t first = vessels.size();
    for (size_t i = 0; i < twigs.size(); i++) {
        const Vessel &stem = *named(stems, stem_of[i]);
        SmallVessel vessel;
        vessel.name = std::to_string(first + i);
        vessel.parent =
            twigs[i].stem.empty() ? std::to_string(first + twigs[i].parent) : file_stem(stem.name);
        vessel.bed = bed_of_all == Bed::body ? stem.bed : bed_of_all;
        vessel.flow_ul_s =
            stem.flow_ml_min > 0 ? stem.flow_ml_min / ends[stem.name] * 1e3 / 60.0 : 0.5 * usual_ul_s;
        vessel.points = twigs[i].points;
        vessels.push_back(std::move(vessel));
    }
}

void append(std::vector<SmallVessel> part, std::vector<SmallVessel> &vessels)
{
    const auto is_number = [](const std::string &name) {
        return !name.empty() && name[0] >= '0' && name[0] <= '9';
    };
    const size_t first = vessels.size();
    for (SmallVessel &vessel : part) {
        for (std::string *name : {&vessel.name, &vessel.parent})
            if (is_number(*name)) *name = std::to_string(first + std::stoul(*name));
        vessels.push_back(std::move(vessel));
    }
}

} // namespace anatomy
