#include "tools/anatomy/varied/coronaries.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "tools/anatomy/chance.hpp"
#include "tools/anatomy/heart_beat.hpp"
#include "tools/anatomy/varied/plausible.hpp"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace anatomy
{

namespace
{

constexpr unsigned CORONARY_ATTEMPTS_MAX = 300;
constexpr double CORONARY_FILLET_MM = 1.0, LEAST_MM = 1.05; // no drawn artery is narrower
constexpr double APEX_HEIGHT = 0.03;                        // the LAD turns round the apex at this height

double to_decimals(double value, double unit)
{
    return std::round(value / unit) * unit;
}

/* Returns height and angle of a point about the axis of the left ventricle, the angle within 180 degrees of
 * `near_deg`.
 */
HeartMark mark_of(const Vec3 &point, double near_deg)
{
    const HeartAxes &axes = heart_axes();
    const Vec3 across = axes.across(point);
    double angle_deg =
        std::atan2(across.dot(axes.lateral), across.dot(axes.anterior)) * 180 / std::numbers::pi;
    angle_deg += 360 * std::round((near_deg - angle_deg) / 360);
    return {axes.height(point), angle_deg, 0, "", ""};
}

/* A mean diameter with its standard deviation, in mm. */
struct Calibre {
    double mean_mm, deviation_mm;
};

/* The diameters by dominance: Dodge 1992 (LM, LAD, LCX and RCA), Vieweg 1976 (middle RCA); the others are
 * assumed (docs/vessels.md). The order of the arrays is that of Dominance. */
constexpr Calibre LEFT_MAIN = {4.5, 0.5}, LAD_PROXIMAL = {3.7, 0.4}, LAD_DISTAL = {1.9, 0.4};
constexpr Calibre LCX_PROXIMAL[] = {{3.4, 0.5}, {4.2, 0.6}, {3.8, 0.5}},
                  RCA_PROXIMAL[] = {{3.9, 0.6}, {2.8, 0.5}, {3.5, 0.5}},
                  RCA_MIDDLE[] = {{3.4, 0.5}, {1.9, 0.3}, {2.7, 0.4}};

/* Draws the arteries one after another, parents first. */
class Drawing
{
  public:
    Drawing(std::uint64_t seed, unsigned number, const TreeDraft &aorta, double calibre)
        : chance_(seed, number + 1), calibre_(calibre)
    {
        drawn_.draft = aorta;
        Chance first(seed, 0); // what is counted depends on the seed alone, and not on the attempt
        drawn_.seed = seed;
        drawn_.refused = number;
        const double part = first.uniform(0, 1);
        drawn_.dominance = part < 0.85    ? Dominance::right
                           : part < 0.925 ? Dominance::left
                                          : Dominance::balanced;
        drawn_.has_ramus = first.uniform(0, 1) < 0.59;
        drawn_.diagonals = first.uniform(0, 1) < 0.5 ? 2 : 3;
        drawn_.marginals = 1 + static_cast<unsigned>(first.uniform(0, 3));
        drawn_.past_apex_mm = first.uniform(0, 1) < 0.7 ? first.uniform(2, 50) : 0;
        size_ = chance_.normal(0, 1);
    }

    DrawnCoronaries make()
    {
        drawn_.draft.coronary_fillet_mm = CORONARY_FILLET_MM;
        left_main();
        anterior_descending();
        diagonals();
        if (drawn_.has_ramus) ramus();
        circumflex();
        marginals();
        right_coronary();
        right_branches();
        back_of_heart();
        share_flow();
        for (const CoronaryArtery &artery : drawn_.arteries) {
            GivenVessel given = {
                vessel_of(artery), true, artery.side.has_value(), false, {"drawn arteries", 0}};
            add_vessel(drawn_.draft, std::move(given));
        }
        drawn_.draft.title = title();
        return std::move(drawn_);
    }

  private:
    Chance chance_;
    DrawnCoronaries drawn_;
    double calibre_;  // multiplies all diameters
    double size_ = 0; // of all arteries of this heart, in standard deviations
    Vec3 fork_mm_ = Vec3::Zero();

    static Vessel vessel_of(const CoronaryArtery &artery)
    {
        Vessel vessel;
        vessel.name = artery.name;
        vessel.parent = artery.parent;
        vessel.bed = artery.side.value_or(Bed::body);
        vessel.flow_ml_min = artery.flow_ml_min;
        vessel.stations = artery.stations;
        if (artery.marks.empty()) return vessel;
        for (Station &station : heart_course(artery.marks)) vessel.stations.push_back(std::move(station));
        return vessel;
    }

    std::string title() const
    {
        return crn::formatted("Heart %llu: %s dominance, %s, %u diagonals, %u marginal%s",
                              static_cast<unsigned long long>(drawn_.seed), dominance_name(drawn_.dominance),
                              drawn_.has_ramus ? "ramus" : "no ramus", drawn_.diagonals, drawn_.marginals,
                              drawn_.marginals == 1 ? "" : "s");
    }

    CoronaryArtery &artery(const std::string &name)
    {
        return *std::find_if(drawn_.arteries.begin(), drawn_.arteries.end(),
                             [&](const CoronaryArtery &one) { return one.name == name; });
    }

    /* Draws a diameter. Large hearts have large arteries: 0.6 of a deviation is common to all arteries. */
    double diameter_mm(const Calibre &calibre)
    {
        const double z = std::clamp(0.6 * size_ + 0.8 * chance_.normal(0, 1), -2.0, 2.0);
        return std::max(LEAST_MM, calibre_ * (calibre.mean_mm + calibre.deviation_mm * z));
    }

    void add(CoronaryArtery one)
    {
        for (Station &station : one.stations) {
            station.position_mm =
                station.position_mm.unaryExpr([](double v) { return to_decimals(v, 0.01); });
            station.diameter_mm = to_decimals(station.diameter_mm, 0.01);
        }
        for (HeartMark &mark : one.marks) {
            mark.height = to_decimals(mark.height, 0.0001);
            mark.angle_deg = to_decimals(mark.angle_deg, 0.01);
            if (mark.diameter_mm > 0)
                mark.diameter_mm = to_decimals(std::max(LEAST_MM, mark.diameter_mm), 0.01);
        }
        drawn_.arteries.push_back(std::move(one));
    }

    /* Makes the course between the first and the last mark wind by a wave across itself: along `height_mm`
     * and `angle_deg`, whichever is not 0. */
    void wind(std::vector<HeartMark> &marks, double height, double angle_deg)
    {
        const double waves = chance_.uniform(0.8, 2.2), phase = chance_.uniform(0, 2 * std::numbers::pi);
        const auto last = static_cast<double>(marks.size() - 1);
        for (size_t i = 1; i + 1 < marks.size(); ++i) {
            const double part = static_cast<double>(i) / last;
            const double wave =
                std::sin(2 * std::numbers::pi * waves * part + phase) * std::sin(std::numbers::pi * part);
            marks[i].height += wave * height;
            marks[i].angle_deg += wave * angle_deg;
        }
    }

    /* Returns the mark on the course of an artery that comes nearest to a height (or, with `by_angle`, to an
     * angle), with the artery's diameter there. */
    HeartMark on_course(const std::string &name, double value, bool by_angle)
    {
        const CoronaryArtery &parent = artery(name);
        HeartMark best = parent.marks.front();
        double least = 1e9;
        for (const Station &station : heart_course(parent.marks)) {
            HeartMark mark = mark_of(station.position_mm, by_angle ? value : best.angle_deg);
            const double off = std::abs((by_angle ? mark.angle_deg : mark.height) - value);
            if (off >= least) continue;
            least = off;
            best = mark;
            best.diameter_mm = station.diameter_mm;
        }
        return best;
    }

    /* Adds an artery that leaves another one at `origin`, and runs along further marks, which are given
     * relative to its origin and stretched by `length`. */
    void branch(const std::string &name, const std::string &parent, const HeartMark &origin,
                const Calibre &calibre, const std::vector<HeartMark> &steps, double length)
    {
        CoronaryArtery one = {name, parent, std::nullopt, {}, {origin}, 0};
        const double width_mm = std::max(LEAST_MM, std::min(diameter_mm(calibre), 0.9 * origin.diameter_mm));
        one.marks.front().diameter_mm = width_mm;
        for (const HeartMark &step : steps)
            one.marks.push_back({std::max(origin.height + length * step.height, 0.06),
                                 origin.angle_deg + length * step.angle_deg, 0, "", ""});
        one.marks.back().diameter_mm = 0.65 * width_mm;
        HeartMark &named = one.marks[1];
        named.diameter_mm = 0.93 * width_mm;
        named.name = name;
        named.source = "drawn about " + crn::formatted("%.1f", calibre.mean_mm) + " mm";
        wind(one.marks, 0, chance_.uniform(0, 3));
        add(std::move(one));
    }

    void left_main()
    {
        const std::vector<Station> shipped = {{Vec3(6, 151, 18), 1.07, "", ""},
                                              {Vec3(17, 148, 14.5), 1.02, "", ""},
                                              {Vec3(24, 143.5, 13.5), 1, "", ""},
                                              {Vec3(29, 138.5, 14.5), 0.93, "", ""}};
        const double width_mm = diameter_mm(LEFT_MAIN), longer_mm = chance_.uniform(-6, 4);
        CoronaryArtery one = {"LM", "aorta", Bed::left_coronary, shipped, {}, 0};
        const Vec3 along = (shipped[3].position_mm - shipped[2].position_mm).normalized();
        one.stations.back().position_mm += longer_mm * along;
        if (longer_mm < -4) one.stations.erase(one.stations.begin() + 2); // the fork has moved there
        for (Station &station : one.stations) station.diameter_mm *= width_mm;
        one.stations[one.stations.size() - 2].name = "left main";
        one.stations[one.stations.size() - 2].source = "drawn about Dodge 1992";
        fork_mm_ = one.stations.back().position_mm.unaryExpr([](double v) { return to_decimals(v, 0.01); });
        add(std::move(one));
    }

    void anterior_descending()
    {
        const double proximal_mm = diameter_mm(LAD_PROXIMAL),
                     distal_mm = std::min(diameter_mm(LAD_DISTAL), 0.75 * proximal_mm);
        CoronaryArtery one = {"LAD", "LM", std::nullopt, {{fork_mm_, proximal_mm, "", ""}}, {}, 0};
        one.marks = {{0.76, 61, 0.98 * proximal_mm, "proximal LAD", "drawn about Dodge 1992"},
                     {0.62, 55, 0, "", ""},
                     {0.5, 36, std::sqrt(proximal_mm * distal_mm), "middle LAD", "between its neighbours"},
                     {0.4, 20, 0, "", ""},
                     {0.3, 9, 0, "", ""},
                     {0.2, 2, distal_mm, "distal LAD", "drawn about Dodge 1992"},
                     {0.1, -8, 0, "", ""}};
        if (drawn_.past_apex_mm > 0)
            turn_round_apex(one.marks);
        else if (chance_.uniform(0, 1) < 0.5)
            one.marks.back() = {0.13, -4, 0, "", ""};
        one.marks.back().diameter_mm = 0.68 * distal_mm;
        wind(one.marks, 0, chance_.uniform(0, 5));
        add(std::move(one));
    }

    /* Continues the LAD round the apex and up in the groove between the ventricles, as far as was drawn. */
    void turn_round_apex(std::vector<HeartMark> &marks)
    {
        constexpr double APART_MM = 6;
        const std::vector<HeartMark> way = {{APEX_HEIGHT, -35, 1, "", ""},
                                            {0.03, -85, 0, "", ""},
                                            {0.08, -120, 0, "", ""},
                                            {0.2, -128, 0, "", ""},
                                            {0.4, -130, 1, "", ""}};
        const std::vector<Station> course = heart_course(way);
        double past_mm = 0;
        marks.push_back(way.front());
        marks.back().diameter_mm = 0;
        Vec3 last = course.front().position_mm;
        for (const Station &station : course) {
            const double apart_mm = (station.position_mm - last).norm();
            if (apart_mm < APART_MM) continue;
            past_mm += apart_mm;
            last = station.position_mm;
            marks.push_back(mark_of(last, marks.back().angle_deg));
            if (past_mm >= drawn_.past_apex_mm) break;
        }
        drawn_.past_apex_mm = past_mm;
    }

    void diagonals()
    {
        const double heights[] = {chance_.uniform(0.57, 0.65), chance_.uniform(0.4, 0.46),
                                  chance_.uniform(0.26, 0.31)};
        const Calibre calibres[] = {{2.0, 0.3}, {1.8, 0.25}, {1.5, 0.2}};
        for (unsigned i = 0; i < drawn_.diagonals; ++i)
            branch(crn::formatted("D%u", i + 1), "LAD", on_course("LAD", heights[i], false), calibres[i],
                   {{-0.1, 10, 0, "", ""}, {-0.22, 20, 0, "", ""}, {-0.33, 28, 0, "", ""}},
                   chance_.uniform(0.8, 1.1) * (i == 2 ? 0.7 : 1));
    }

    /* The intermediate artery leaves the fork between its two other branches. */
    void ramus()
    {
        const double width_mm = diameter_mm({2.2, 0.4});
        CoronaryArtery one = {"RI", "LM", std::nullopt, {{fork_mm_, width_mm, "", ""}}, {}, 0};
        const double turn_deg = chance_.uniform(-3, 3), end = chance_.uniform(0.26, 0.45);
        one.marks = {{0.745, 70, 0.97 * width_mm, "ramus", "drawn about 2.2 mm"},
                     {0.66, 78 + turn_deg, 0, "", ""},
                     {0.55, 86 + turn_deg, 0, "", ""},
                     {0.5 * (0.55 + end), 90 + turn_deg, 0, "", ""},
                     {end, 93 + turn_deg, 0.6 * width_mm, "", ""}};
        add(std::move(one));
    }

    void circumflex()
    {
        const auto dominance = static_cast<size_t>(drawn_.dominance);
        const double width_mm = diameter_mm(LCX_PROXIMAL[dominance]);
        CoronaryArtery one = {"LCX", "LM", std::nullopt, {{fork_mm_, width_mm, "", ""}}, {}, 0};
        one.marks = {{0.79, 76, 0.95 * width_mm, "proximal LCX", "drawn about Dodge 1992"},
                     {0.755, 92, 0, "", ""},
                     {0.71, 112, 0.83 * width_mm, "middle LCX", "between its neighbours"},
                     {0.72, 132, 0, "", ""},
                     {0.77, 150, 0, "", ""}};
        double end_mm = 0.45 * width_mm;
        if (drawn_.dominance == Dominance::right) {
            one.marks.push_back(
                {0.77 + 0.06 * chance_.uniform(0.5, 1), 150 + 18 * chance_.uniform(0.5, 1), 0, "", ""});
        } else {
            one.marks.push_back({0.83, 168, 0, "", ""});
            one.marks.push_back({0.85, 185, 0, "", ""});
            one.marks.push_back({0.86, 200, 0, "", ""});
            end_mm = 0.62 * width_mm;
            if (drawn_.dominance == Dominance::left) one.marks.push_back({0.865, 216, 0, "", ""});
        }
        one.marks.back().diameter_mm = end_mm;
        wind(one.marks, chance_.uniform(0, 0.015), 0);
        add(std::move(one));
    }

    void marginals()
    {
        const double angles[] = {chance_.uniform(102, 112), chance_.uniform(128, 138),
                                 chance_.uniform(151, 156)};
        const Calibre calibres[] = {{2.3, 0.35}, {1.9, 0.3}, {1.6, 0.25}};
        for (unsigned i = 0; i < drawn_.marginals; ++i)
            branch(crn::formatted("OM%u", i + 1), "LCX", on_course("LCX", angles[i], true), calibres[i],
                   {{-0.12, 4, 0, "", ""}, {-0.27, 7, 0, "", ""}, {-0.43, 11, 0, "", ""}},
                   chance_.uniform(0.75, 1.05));
    }

    void right_coronary()
    {
        const auto dominance = static_cast<size_t>(drawn_.dominance);
        const double width_mm = diameter_mm(RCA_PROXIMAL[dominance]),
                     middle_mm = std::min(diameter_mm(RCA_MIDDLE[dominance]), 0.95 * width_mm);
        CoronaryArtery one = {"RCA",
                              "aorta",
                              Bed::right_coronary,
                              {{Vec3(0, 151, 22), 1.07 * width_mm, "", ""},
                               {Vec3(-6, 149.5, 32), 1.03 * width_mm, "", ""},
                               {Vec3(-9, 143, 39), 1.01 * width_mm, "", ""}},
                              {},
                              0};
        one.marks = {{0.96, 345, width_mm, "proximal RCA", "drawn about Dodge 1992"},
                     {1, 322, 0, "", ""},
                     {0.99, 302, middle_mm, "middle RCA", "drawn about Vieweg 1976"},
                     {0.93, 283, 0, "", ""}};
        if (drawn_.dominance == Dominance::left) {
            one.marks.back() = {0.94, 286, 0.75 * middle_mm, "", ""};
        } else {
            one.marks.push_back({0.86, 264, 0.93 * middle_mm, "distal RCA", "between its neighbours"});
            one.marks.push_back({0.82, 247, 0, "", ""});
            one.marks.push_back({0.87, 231, 0.8 * middle_mm, "", ""});
        }
        wind(one.marks, chance_.uniform(0, 0.02), 0);
        add(std::move(one));
    }

    /* The conus branch, and the acute marginal artery on the sharp edge of the right ventricle. */
    void right_branches()
    {
        branch("CB", "RCA", on_course("RCA", 340, true), {1.2, 0.15},
               {{-0.09, 6, 0, "", ""}, {-0.18, 11, 0, "", ""}, {-0.28, 15, 0, "", ""}},
               chance_.uniform(0.7, 1));
        branch("AM", "RCA", on_course("RCA", chance_.uniform(289, 297), true), {1.5, 0.25},
               {{-0.16, 8, 0, "", ""}, {-0.34, 13, 0, "", ""}, {-0.51, 20, 0, "", ""}},
               chance_.uniform(0.6, 1));
    }

    void back_of_heart()
    {
        const std::string posterior = drawn_.dominance == Dominance::left ? "LCX" : "RCA",
                          lateral = drawn_.dominance == Dominance::right ? "RCA" : "LCX";
        // The PDA ends above a LAD that comes up behind the apex.
        const double lad_end = drawn_.past_apex_mm > 0 ? artery("LAD").marks.back().height : 0;
        const double down = std::max(0.28, lad_end + 0.12);
        back_branch("PDA", posterior, {2.1, 0.3},
                    {{0.76, 228, 0, "", ""}, {0.6, 228, 0, "", ""}, {down, 228, 0, "", ""}});
        if (lateral == "RCA")
            back_branch("PL", lateral, {1.9, 0.3},
                        {{0.84, 216, 0, "", ""}, {0.74, 205, 0, "", ""}, {0.58, 198, 0, "", ""}});
        else
            back_branch("PL", lateral, {1.9, 0.3},
                        {{0.74, 203, 0, "", ""}, {0.62, 204, 0, "", ""}, {0.5, 204, 0, "", ""}});
    }

    /* Adds an artery that leaves the end of its parent; a left dominant circumflex artery gives off its PL
     * before. */
    void back_branch(const std::string &name, const std::string &parent, const Calibre &calibre,
                     const std::vector<HeartMark> &further)
    {
        const bool is_before_end = name == "PL" && drawn_.dominance == Dominance::left;
        HeartMark origin = is_before_end ? on_course(parent, 198, true) : artery(parent).marks.back();
        const double width_mm = std::max(LEAST_MM, std::min(diameter_mm(calibre), 0.95 * origin.diameter_mm));
        CoronaryArtery one = {name, parent, std::nullopt, {}, {origin}, 0};
        one.marks.front().diameter_mm = width_mm;
        one.marks.insert(one.marks.end(), further.begin(), further.end());
        one.marks[1].diameter_mm = 0.9 * width_mm;
        one.marks[1].name = name == "PDA" ? "posterior descending" : "posterolateral";
        one.marks[1].source = crn::formatted("drawn about %.1f mm", calibre.mean_mm);
        one.marks.back().diameter_mm = 0.6 * width_mm;
        one.marks.back().height += chance_.uniform(-0.05, 0.05);
        wind(one.marks, 0, chance_.uniform(0, 4));
        add(std::move(one));
    }

    /* Shares the flow at rest among the ends of the arteries by the power 7/3 of their diameters (Huo and
     * Kassab, 2009). An artery that ends in its branches has no flow of its own. */
    void share_flow()
    {
        const double total_ml_min = chance_.normal(186, 31);
        std::vector<double> weights;
        double sum = 0;
        for (const CoronaryArtery &one : drawn_.arteries) {
            const bool ends_in_branches = one.name == "LM" ||
                                          (one.name == "RCA" && drawn_.dominance != Dominance::left) ||
                                          (one.name == "LCX" && drawn_.dominance != Dominance::right);
            const double end_mm = one.marks.empty() ? 0 : one.marks.back().diameter_mm;
            weights.push_back(ends_in_branches ? 0 : std::pow(end_mm, 7.0 / 3));
            sum += weights.back();
        }
        for (size_t i = 0; i < weights.size(); ++i)
            drawn_.arteries[i].flow_ml_min = to_decimals(total_ml_min * weights[i] / sum, 0.1);
    }
};

} // namespace

const char *dominance_name(Dominance dominance)
{
    const char *names[] = {"right", "left", "balanced"};
    return names[static_cast<size_t>(dominance)];
}

std::string end_of_lad(const DrawnCoronaries &drawn)
{
    return drawn.past_apex_mm > 0 ? crn::formatted("%.0f mm beyond the apex", drawn.past_apex_mm)
                                  : "before the apex";
}

DrawnCoronaries drawn_coronaries(std::uint64_t seed)
{
    static const TreeDraft aorta = read_vessel_draft(shipped_vessel_file("aorta.toml"));
    return drawn_coronaries(seed, aorta, 1.0);
}

DrawnCoronaries drawn_coronaries(std::uint64_t seed, const TreeDraft &aorta, double calibre)
{
    for (unsigned number = 0; number < CORONARY_ATTEMPTS_MAX; ++number) {
        try {
            DrawnCoronaries drawn = Drawing(seed, number, aorta, calibre).make();
            if (broken_coronary_rule(tree_of(drawn.draft, "heart.toml").vessels).empty()) return drawn;
        } catch (const std::domain_error &) { // a course left the heart
        } catch (const crn::FileError &) {    // an artery begins outside the aorta
        }
    }
    throw std::runtime_error(crn::formatted(
        "anatomy --seed %llu: no plausible coronary arteries in %u attempts; choose another seed",
        static_cast<unsigned long long>(seed), CORONARY_ATTEMPTS_MAX));
}

} // namespace anatomy
