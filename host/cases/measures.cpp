#include "host/cases/measures.hpp"
#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace crn
{

namespace
{

using Json = nlohmann::ordered_json;

double worst_of_tools(const Json &report, const char *key)
{
    double worst = 0.0;
    for (const Json &tool : report.at("tools")) worst = std::max(worst, tool.at(key).get<double>());
    return worst;
}

// Returns by how many bar the balloon was filled above its rated burst pressure, and 0 without a balloon.
double above_rated_bar(const Json &report)
{
    const Json &balloon = report.at("balloon");
    if (!balloon.is_object() || !balloon.contains("rated_burst_bar")) return 0.0;
    const double over_bar =
        balloon.at("pressure_max_bar").get<double>() - balloon.at("rated_burst_bar").get<double>();
    return std::max(0.0, over_bar);
}

double bursts_and_losses(const Json &report)
{
    double count = 0.0;
    const Json &balloon = report.at("balloon");
    if (balloon.is_object() && !balloon.at("burst_s").is_null()) count += 1.0;
    if (report.at("stents").is_array())
        for (const Json &stent : report.at("stents")) count += stent.at("is_lost").get<bool>() ? 1.0 : 0.0;
    return count;
}

double stents_deployed(const Json &report)
{
    double count = 0.0;
    if (report.at("stents").is_array())
        for (const Json &stent : report.at("stents")) count += stent.at("stage") == "deployed" ? 1.0 : 0.0;
    return count;
}

double count_of(const Json &list)
{
    return static_cast<double>(list.size());
}

} // namespace

const std::vector<Measure> &case_measures()
{
    static const std::vector<Measure> measures = {
        {"time_min", "time", "min"},
        {"fluoroscopy_min", "fluoroscopy", "min"},
        {"kap_Gy_cm2", "kerma-area product", "Gy cm2"},
        {"contrast_ml", "contrast medium", "ml"},
        {"hand_force_N", "largest hand force", "N"},
        {"hand_torque_mN_m", "largest hand torque", "mN m"},
        {"wall_mm", "deepest in a wall", "mm"},
        {"contact_impulse_N_s", "contact impulse", "N s"},
        {"above_rated_burst_bar", "pressure above the rated burst pressure", "bar"},
        {"balloon_pressure_bar", "highest pressure of the balloon", "bar"},
        {"bursts_and_losses", "burst balloons and lost stents", ""},
        {"stents_deployed", "deployed stents", ""},
        {"refusals", "refused requests", ""},
        {"perforations", "perforated vessels", ""},
        {"dissections", "dissected vessels", ""},
        {"blood_loss_ml", "blood lost through walls of vessels", "ml"},
        {"angioplasty_percent", "score of the angioplasty", "%"},
    };
    return measures;
}

std::vector<std::string> measure_names()
{
    std::vector<std::string> names;
    for (const Measure &measure : case_measures()) names.emplace_back(measure.name);
    return names;
}

const Measure &measure_named(const std::string &name)
{
    for (const Measure &measure : case_measures())
        if (name == measure.name) return measure;
    throw std::out_of_range("no measure '" + name + "'");
}

std::optional<double> measured(const std::string &name, const Json &report)
{
    const Json &contrast = report.at("contrast"), &balloon = report.at("balloon");
    if (name == "time_min") return report.at("ticks").get<double>() / 60e3;
    if (name == "fluoroscopy_min") return report.at("room").at("fluoroscopy_min").get<double>();
    if (name == "kap_Gy_cm2") return report.at("room").at("total").at("kap_Gy_cm2").get<double>();
    if (name == "contrast_ml") return contrast.is_object() ? contrast.at("injected_ml").get<double>() : 0.0;
    if (name == "hand_force_N") return worst_of_tools(report, "handle_force_max_N");
    if (name == "hand_torque_mN_m") return worst_of_tools(report, "handle_torque_max_mN_m");
    if (name == "wall_mm") return report.at("penetration_max_mm").get<double>();
    if (name == "contact_impulse_N_s") return report.at("contact").at("impulse_N_s").get<double>();
    if (name == "above_rated_burst_bar") return above_rated_bar(report);
    if (name == "balloon_pressure_bar")
        return balloon.is_object() ? balloon.at("pressure_max_bar").get<double>() : 0.0;
    if (name == "bursts_and_losses") return bursts_and_losses(report);
    if (name == "stents_deployed") return stents_deployed(report);
    if (name == "refusals") return count_of(report.at("refused"));
    if (name == "perforations" || name == "dissections" || name == "blood_loss_ml")
        return report.at("complications").at(name).get<double>();
    const Json &percent = report.at("score").at("percent"); // angioplasty_percent
    return percent.is_number() ? percent.get<double>() : std::optional<double>();
}

} // namespace crn
