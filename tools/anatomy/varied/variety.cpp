#include "tools/anatomy/varied/variety.hpp"
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "tools/anatomy/chance.hpp"
#include "tools/anatomy/varied/plausible.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace anatomy
{

namespace
{

constexpr unsigned ATTEMPTS_MAX = 200;
constexpr double ARCH_MM = 150;       // the arch lies above this height
constexpr double CURVE_STEP_MM = 1.0; // of curves that are measured
constexpr double ENTRY_MM = -300;     // height of the introducer's end in the shipped tree
constexpr const char *AORTA = "aorta", *TRUNK = "brachiocephalic artery",
                     *CAROTID = "left common carotid artery";
constexpr std::array<const char *, 2> ILIACS = {"right iliac artery", "left iliac artery"};
constexpr std::array<const char *, 2> RENALS = {"right renal artery", "left renal artery"};

const Vessel *found(const std::vector<Vessel> &vessels, const std::string &name)
{
    const auto at =
        std::find_if(vessels.begin(), vessels.end(), [&](const Vessel &one) { return one.name == name; });
    return at == vessels.end() ? nullptr : &*at;
}

Vessel &vessel_in(TreeDraft &draft, const std::string &name)
{
    for (GivenVessel &given : draft.vessels)
        if (given.vessel.name == name) return given.vessel;
    throw std::invalid_argument("the shipped aorta.toml has no vessel '" + name + "'");
}

std::vector<Vessel> vessels_of(const TreeDraft &draft)
{
    std::vector<Vessel> vessels;
    for (const GivenVessel &given : draft.vessels) vessels.push_back(given.vessel);
    return vessels;
}

/* The two limbs of the arch at the height of the pulmonary artery. */
struct ArchEnds {
    Vec3 ascending, descending;
};

ArchEnds arch_ends(const std::vector<Vessel> &vessels)
{
    constexpr double HEIGHT_MM = 172;
    const Vessel *aorta = found(vessels, AORTA);
    if (!aorta) throw std::invalid_argument("the tree has no vessel 'aorta'");
    ArchEnds ends{Vec3::Zero(), Vec3::Zero()};
    bool is_ascending = true;
    const Curve curve = vessel_curve(*aorta, CURVE_STEP_MM);
    for (size_t i = 1; i < curve.size(); ++i) {
        const double before = curve[i - 1].position_mm.y(), now = curve[i].position_mm.y();
        if ((before - HEIGHT_MM) * (now - HEIGHT_MM) > 0) continue;
        (is_ascending ? ends.ascending : ends.descending) = curve[i].position_mm;
        is_ascending = false;
    }
    return ends;
}

/* Holds the basis of every drawn tree: the shipped tree, its measured values, and the courses of the
   brachiocephalic artery for the three arch types, with the height at which each begins. */
struct Shipped {
    TreeDraft draft;
    Solid bones;
    TreeSpaces spaces;
    std::array<std::vector<Station>, 3> trunks;
    std::array<double, 3> drop_widths;
};

Shipped read_shipped()
{
    Shipped shipped;
    const std::array<const char *, 3> names = {"aorta.toml", "arch_type_2.toml", "arch_type_3.toml"};
    for (size_t i = 0; i < names.size(); ++i) {
        TreeDraft draft = read_vessel_draft(shipped_vessel_file(names[i]));
        shipped.trunks[i] = vessel_in(draft, TRUNK).stations;
        shipped.drop_widths[i] = arch_figures(vessels_of(draft)).drop_widths;
        if (i == 0) shipped.draft = std::move(draft);
    }
    shipped.bones = trunk_bones();
    shipped.spaces = spaces_of(vessels_of(shipped.draft), shipped.bones);
    return shipped;
}

/* Returns what is shipped, moved with the spine of a person with these bones. */
Shipped moved_shipped(const Shipped &shipped, const SkeletonShape &skeleton)
{
    Shipped moved = shipped;
    for (GivenVessel &given : moved.draft.vessels)
        given.vessel = moved_with_spine({given.vessel}, skeleton.bend).front();
    for (std::vector<Station> &trunk : moved.trunks)
        for (Station &station : trunk)
            station.position_mm = moved_with_spine(skeleton.bend, station.position_mm);
    moved.bones = trunk_bones(skeleton);
    moved.spaces = spaces_of(vessels_of(moved.draft), moved.bones);
    return moved;
}

/* The shares of the arch types and of the common trunk are rounded values of published CT series
 * (docs/vessels.md). */
ArchFigures drawn_arch(Chance &chance, const AortaWish &wish)
{
    ArchFigures arch;
    const double part = chance.uniform(0, 1);
    arch.type = wish.type.value_or(part < 0.55 ? ArchType::I : part < 0.85 ? ArchType::II : ArchType::III);
    const double low[] = {0.3, 1.1, 2.05}, high[] = {0.9, 1.9, 2.5};
    const auto type = static_cast<size_t>(arch.type);
    arch.drop_widths = chance.uniform(low[type], high[type]);
    arch.has_common_trunk = chance.uniform(0, 1) < 0.155 || wish.has_common_trunk;
    return arch;
}

/* Interpolates, or slightly extrapolates, the course of the brachiocephalic artery from the courses of the
   shipped arches. */
void set_trunk(TreeDraft &draft, const Shipped &shipped, double drop_widths)
{
    const size_t i = drop_widths < shipped.drop_widths[1] ? 0 : 1;
    const double part =
        (drop_widths - shipped.drop_widths[i]) / (shipped.drop_widths[i + 1] - shipped.drop_widths[i]);
    std::vector<Station> &stations = vessel_in(draft, TRUNK).stations;
    for (size_t k = 0; k < stations.size(); ++k) {
        const Station &a = shipped.trunks[i].at(k), &b = shipped.trunks[i + 1].at(k);
        stations[k].position_mm = a.position_mm + part * (b.position_mm - a.position_mm);
        stations[k].diameter_mm = a.diameter_mm + part * (b.diameter_mm - a.diameter_mm);
    }
}

/* Makes the left common carotid artery leave the brachiocephalic artery, at the fraction `part` of that
 * artery's first 25 mm.
 */
void set_common_trunk(TreeDraft &draft, double part)
{
    const Curve trunk = vessel_curve(vessel_in(draft, TRUNK), CURVE_STEP_MM);
    const double arc_mm = 18 + 7 * part;
    const auto at =
        std::find_if(trunk.begin(), trunk.end(), [&](const CurvePoint &one) { return one.arc_mm > arc_mm; });
    Vessel &carotid = vessel_in(draft, CAROTID);
    carotid.parent = TRUNK;
    std::vector<Station> &stations = carotid.stations;
    stations[0].position_mm = at->position_mm;
    const Vec3 beyond = stations[2].position_mm;
    stations[1].position_mm = 0.45 * at->position_mm + 0.55 * beyond + Vec3(0, 4, 3);
    stations[1].name.clear();
    stations[1].source.clear();
}

/* Makes an iliac artery wind around its original course. The winding decreases to zero towards both ends, so
 * the origin and the groin stay in place.
 */
void wind(Vessel &vessel, double amplitude_mm, Chance &chance)
{
    constexpr double START_MM = 15, STATIONS_APART_MM = 14;
    const Curve curve = vessel_curve(vessel, CURVE_STEP_MM);
    const auto end = std::find_if(curve.begin(), curve.end(),
                                  [](const CurvePoint &one) { return one.position_mm.y() < ENTRY_MM + 15; });
    const double length_mm = (end == curve.end() ? curve.back() : *end).arc_mm - START_MM;
    const double waves = chance.uniform(1.2, 2.6), phase = chance.uniform(0, 2 * std::numbers::pi),
                 plane = chance.uniform(0, std::numbers::pi);
    const auto offset = [&](size_t i) -> Vec3 {
        const double part = (curve[i].arc_mm - START_MM) / length_mm;
        if (part <= 0 || part >= 1) return Vec3::Zero();
        const Vec3 along = curve_tangent(curve, i);
        const Vec3 across = along.cross(Vec3::UnitZ()).normalized();
        const Vec3 direction = std::cos(plane) * across + std::sin(plane) * along.cross(across);
        const double window = std::pow(std::sin(std::numbers::pi * part), 2);
        return amplitude_mm * window * std::sin(2 * std::numbers::pi * waves * part + phase) * direction;
    };
    std::vector<Station> wound;
    size_t next = 0;
    double last_mm = -STATIONS_APART_MM;
    for (size_t i = 0; i < curve.size() && next < vessel.stations.size(); ++i) {
        const Station &given = vessel.stations[next];
        const double ahead_mm = (curve[i].position_mm - given.position_mm).norm();
        if (ahead_mm < 1e-9) { // the point of this station
            wound.push_back(given);
            ++next;
        } else if (curve[i].arc_mm - last_mm >= STATIONS_APART_MM && ahead_mm > STATIONS_APART_MM / 2) {
            wound.push_back({curve[i].position_mm, 2 * curve[i].radius_mm, "", ""});
        } else {
            continue;
        }
        last_mm = curve[i].arc_mm;
        wound.back().position_mm += offset(i);
    }
    vessel.stations = std::move(wound);
}

void turn_about_origin(Vessel &vessel, double up_deg, double forward_deg)
{
    constexpr double DEG = std::numbers::pi / 180;
    const Vec3 origin = vessel.stations.front().position_mm;
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(up_deg * DEG, Vec3::UnitZ()) * Eigen::AngleAxisd(forward_deg * DEG, Vec3::UnitY()))
            .toRotationMatrix();
    for (Station &station : vessel.stations)
        station.position_mm = origin + turn * (station.position_mm - origin);
}

/* Displaces all points of space smoothly by a sum of a few waves. All vessels move together, so branches stay
 * connected with their parents. The aortic valve and the groins stay in place. */
class Drift
{
  public:
    Drift(const Vec3 &valve_mm, Chance &chance) : valve_mm_(valve_mm), lift_mm_(chance.normal(0, 3.5))
    {
        for (Wave &wave : waves_) {
            const auto direction = [&] {
                return Vec3(chance.normal(0, 1), chance.normal(0, 1), chance.normal(0, 1));
            };
            wave.number = direction().normalized() * (2 * std::numbers::pi / chance.uniform(140, 260));
            wave.shift_mm = 1.6 * direction();
            wave.phase = chance.uniform(0, 2 * std::numbers::pi);
        }
    }

    Vec3 moved(const Vec3 &p) const
    {
        Vec3 shift = Vec3(0, lift_mm_ * smooth_step(ARCH_MM, ARCH_MM + 70, p.y()), 0);
        for (const Wave &wave : waves_) shift += std::sin(wave.number.dot(p) + wave.phase) * wave.shift_mm;
        const double from_valve = smooth_step(10, 60, (p - valve_mm_).norm());
        const double above_groin = smooth_step(ENTRY_MM + 10, ENTRY_MM + 70, p.y());
        return p + from_valve * above_groin * shift;
    }

  private:
    struct Wave {
        Vec3 number, shift_mm;
        double phase = 0;
    };
    Vec3 valve_mm_;
    double lift_mm_;
    std::array<Wave, 4> waves_;
};

/* Moves the ascending and the descending aorta apart or together, with all vessels beside them. An arch
 * unfolds with age: it becomes wider, and its top rises. The aortic valve stays, and the aorta below the
 * heart does. */
void unfold(TreeDraft &draft, double width)
{
    constexpr double RISE = 0.3; // of the top, in parts of the growth in width; assumed
    const ArchEnds ends = arch_ends(vessels_of(draft));
    const Vec3 middle = 0.5 * (ends.ascending + ends.descending);
    Vec3 across = ends.descending - ends.ascending;
    across.y() = 0;
    const double width_mm = across.norm();
    across /= width_mm;
    for (GivenVessel &given : draft.vessels)
        for (Station &station : given.vessel.stations) {
            Vec3 &p = station.position_mm;
            const double off = (p - middle).dot(across);
            const double share = off < 0 ? smooth_step(142, 196, p.y()) : smooth_step(40, 170, p.y());
            const double above_neck = 1.0 - smooth_step(235, 300, p.y());
            const double rise_mm = RISE * (width - 1) * width_mm * smooth_step(170, 225, p.y()) * above_neck;
            p +=
                (width - 1) * share * above_neck * std::clamp(off, -0.6 * width_mm, 0.6 * width_mm) * across +
                Vec3(0, rise_mm, 0);
        }
}

/* Returns the direction away from the nearest bone. */
Vec3 away_from(const Solid &bones, const Vec3 &p)
{
    constexpr double PROBE_MM = 0.5;
    Vec3 away;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 step = PROBE_MM * Vec3::Unit(axis);
        away[axis] = bones.distance(p + step) - bones.distance(p - step);
    }
    return away.norm() > 1e-6 ? away.normalized() : Vec3::Zero();
}

/* Moves a vessel that is too close to a bone away from the bone. Where its course between two stations
 * (points of the centreline) comes too close, both move. The groins stay. */
void give_way_to_bones(Vessel &vessel, double wanted_mm, const Solid &bones)
{
    constexpr double SPARE_MM = 0.4, STEP_MM = 4.0;
    constexpr int ROUNDS = 6;
    for (int round = 0; round < ROUNDS; ++round) {
        std::vector<Vec3> moves(vessel.stations.size(), Vec3::Zero());
        size_t next = 1; // the station behind the point
        for (const CurvePoint &point : vessel_curve(vessel, STEP_MM)) {
            const Vec3 &p = point.position_mm;
            while (next + 1 < vessel.stations.size() && (p - vessel.stations[next].position_mm).norm() < 1e-6)
                ++next;
            if (p.y() < ENTRY_MM + 15) continue;
            const double lacking_mm = wanted_mm + SPARE_MM + point.radius_mm - bones.distance(p);
            if (lacking_mm <= 0) continue;
            const Vec3 move = lacking_mm * away_from(bones, p);
            for (const size_t i : {next - 1, next}) {
                if (vessel.stations[i].position_mm.y() < ENTRY_MM + 15) continue;
                const double off_mm = (vessel.stations[i].position_mm - p).norm();
                const double span_mm =
                    (vessel.stations[next].position_mm - vessel.stations[next - 1].position_mm).norm();
                const double share = std::clamp(1.0 - off_mm / span_mm, 0.0, 1.0);
                if ((share * move).squaredNorm() > moves[i].squaredNorm()) moves[i] = share * move;
            }
        }
        double most_mm = 0;
        for (size_t i = 0; i < moves.size(); ++i) {
            vessel.stations[i].position_mm += moves[i];
            most_mm = std::max(most_mm, moves[i].norm());
        }
        if (most_mm == 0) return;
    }
}

double tortuosity(const Vessel &vessel)
{
    const Curve curve = vessel_curve(vessel, CURVE_STEP_MM);
    const CurvePoint *end = &curve.back();
    for (const CurvePoint &point : curve)
        if (point.position_mm.y() < ENTRY_MM) {
            end = &point;
            break;
        }
    return end->arc_mm / (end->position_mm - curve.front().position_mm).norm();
}

double rounded(double value)
{
    return std::round(value * 100) / 100; // the file has two decimals
}

/* Gives the aorta the wished diameters, times the individual factor: the root, the ascending, the descending
 * and the infrarenal aorta have their own, and the diameters between follow in proportion. */
void set_calibre(DrawnAorta &drawn, const AortaCalibre &calibre, Chance &chance)
{
    const AortaCalibre shipped;
    for (GivenVessel &given : drawn.draft.vessels) {
        const std::string &name = given.vessel.name;
        const bool is_aorta = name == AORTA;
        const bool is_renal = std::find(RENALS.begin(), RENALS.end(), name) != RENALS.end();
        const double own = std::sqrt(drawn.aorta_scale) * chance.normal(1, 0.06);
        bool is_ascending = true;
        for (Station &station : given.vessel.stations) {
            const double y = station.position_mm.y();
            is_ascending = is_ascending && station.position_mm.z() > 0;
            double scale = own * (is_renal ? calibre.renals : calibre.branches);
            if (is_aorta) {
                const double root = calibre.annulus_mm / shipped.annulus_mm,
                             ascending = calibre.ascending_mm / shipped.ascending_mm,
                             descending = calibre.descending_mm / shipped.descending_mm,
                             infrarenal = calibre.infrarenal_mm / shipped.infrarenal_mm;
                const double up = smooth_step(140, 186, y), down = smooth_step(-60, 120, y);
                scale = is_ascending ? std::lerp(root, drawn.aorta_scale * ascending, up)
                                     : drawn.aorta_scale * std::lerp(infrarenal, descending, down);
            }
            station.diameter_mm = std::max(1.0, rounded(scale * station.diameter_mm));
            if (!station.name.empty())
                station.source = "drawn by sex, age and height about: " + station.source;
        }
    }
}

void scale_diameters(DrawnAorta &drawn, const AortaWish &wish, Chance &chance)
{
    drawn.aorta_scale = chance.normal(1, 0.08);
    if (wish.calibre) return set_calibre(drawn, *wish.calibre, chance);
    for (GivenVessel &given : drawn.draft.vessels) {
        const bool is_aorta = given.vessel.name == AORTA;
        const double scale =
            is_aorta ? drawn.aorta_scale : std::sqrt(drawn.aorta_scale) * chance.normal(1, 0.06);
        for (Station &station : given.vessel.stations) {
            station.diameter_mm = rounded(scale * station.diameter_mm);
            if (!station.name.empty()) station.source = "drawn about: " + station.source;
        }
    }
}

/* Returns the amplitude with which an iliac artery winds to be as long as is asked for. */
double amplitude_for(const Vessel &straight, double wanted, const Chance &chance)
{
    constexpr double AMPLITUDE_MAX_MM = 34;
    double low = 0, high = AMPLITUDE_MAX_MM;
    for (int i = 0; i < 14; ++i) {
        const double middle = 0.5 * (low + high);
        Vessel wound = straight;
        Chance same = chance; // a copy: the same winding each time
        wind(wound, middle, same);
        (tortuosity(wound) < wanted ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

DrawnAorta attempt(const Shipped &shipped, std::uint64_t seed, unsigned number, const AortaWish &wish)
{
    // The arch depends only on the seed, and not on the attempt, so that the rules do not change how often
    // each arch type occurs.
    Chance first(seed, 0), chance(seed, number + 1);
    DrawnAorta drawn;
    drawn.seed = seed;
    drawn.refused = number;
    drawn.draft = shipped.draft;
    drawn.arch = drawn_arch(first, wish);
    set_trunk(drawn.draft, shipped, drawn.arch.drop_widths);
    if (drawn.arch.has_common_trunk) set_common_trunk(drawn.draft, chance.uniform(0, 1));
    for (const char *iliac : ILIACS) {
        Vessel &vessel = vessel_in(drawn.draft, iliac);
        const double drawn_mm = chance.uniform(0, 14);
        wind(vessel, wish.tortuosity ? amplitude_for(vessel, *wish.tortuosity, chance) : drawn_mm, chance);
    }
    for (const char *renal : RENALS)
        turn_about_origin(vessel_in(drawn.draft, renal), chance.normal(0, 8), chance.normal(0, 8));
    if (wish.arch_width != 1.0) unfold(drawn.draft, wish.arch_width);
    const Drift drift(vessel_in(drawn.draft, AORTA).stations.front().position_mm, chance);
    for (GivenVessel &given : drawn.draft.vessels)
        for (Station &station : given.vessel.stations) station.position_mm = drift.moved(station.position_mm);
    scale_diameters(drawn, wish, chance);
    for (size_t i = 0; i < drawn.draft.vessels.size(); ++i) {
        Vessel &vessel = drawn.draft.vessels[i].vessel;
        give_way_to_bones(vessel, std::min(shipped.spaces.to_bone_mm[i], TO_BONE_MM), shipped.bones);
        for (Station &station : vessel.stations)
            station.position_mm = station.position_mm.unaryExpr(&rounded);
    }
    return drawn;
}

} // namespace

ArchFigures arch_figures(const std::vector<Vessel> &vessels)
{
    const Vessel *aorta = found(vessels, AORTA), *trunk = found(vessels, TRUNK),
                 *carotid = found(vessels, CAROTID);
    if (!aorta || !trunk || !carotid)
        throw std::invalid_argument(
            "the tree has no arch: it needs the vessels aorta, brachiocephalic artery and left "
            "common carotid artery");
    const Curve arch = vessel_curve(*aorta, CURVE_STEP_MM);
    double top_mm = -1e9;
    for (const CurvePoint &point : arch)
        if (point.position_mm.y() > ARCH_MM)
            top_mm = std::max(top_mm, point.position_mm.y() + point.radius_mm);
    const auto is_outside = [&](const CurvePoint &point) {
        return std::all_of(arch.begin(), arch.end(), [&](const CurvePoint &other) {
            return (point.position_mm - other.position_mm).norm() > other.radius_mm;
        });
    };
    const Curve branch = vessel_curve(*trunk, CURVE_STEP_MM);
    const auto origin = std::find_if(branch.begin(), branch.end(), is_outside);
    if (origin == branch.end())
        throw std::invalid_argument("the brachiocephalic artery lies inside the aorta");
    ArchFigures arch_of;
    arch_of.drop_widths = (top_mm - origin->position_mm.y()) / carotid->stations.front().diameter_mm;
    arch_of.type = arch_of.drop_widths < 1   ? ArchType::I
                   : arch_of.drop_widths < 2 ? ArchType::II
                                             : ArchType::III;
    arch_of.has_common_trunk = carotid->parent == TRUNK;
    return arch_of;
}

const char *arch_type_name(ArchType type)
{
    const char *names[] = {"I", "II", "III"};
    return names[static_cast<size_t>(type)];
}

namespace
{

/* Returns whether every vessel still begins inside its parent after it was moved. */
bool begins_in_parents(const TreeDraft &draft)
{
    try {
        tree_of(draft, "drawn vessels");
        return true;
    } catch (const crn::FileError &) {
        return false;
    }
}

} // namespace

double arch_width_mm(const std::vector<Vessel> &vessels)
{
    const ArchEnds ends = arch_ends(vessels);
    return std::hypot(ends.ascending.x() - ends.descending.x(), ends.ascending.z() - ends.descending.z());
}

DrawnAorta drawn_aorta(std::uint64_t seed, const AortaWish &wish)
{
    constexpr double TORTUOSITY_OFF = 0.03; // of what is asked for
    static const Shipped shipped_man = read_shipped();
    const Shipped shipped =
        wish.skeleton == SkeletonShape{} ? shipped_man : moved_shipped(shipped_man, wish.skeleton);
    const TreeSpaces &usual = shipped.spaces;
    for (unsigned number = 0; number < ATTEMPTS_MAX; ++number) {
        AortaWish tried = wish;
        // A width that the first attempts do not reach is approached less and less.
        constexpr unsigned PATIENT = 8;
        if (number > PATIENT)
            tried.arch_width = std::lerp(wish.arch_width, 1.0, std::min(1.0, (number - PATIENT) / 60.0));
        DrawnAorta drawn = attempt(shipped, seed, number, tried);
        const std::vector<Vessel> vessels = vessels_of(drawn.draft);
        const ArchFigures measured = arch_figures(vessels);
        if (measured.type != drawn.arch.type || !broken_rule(vessels, usual, shipped.bones).empty() ||
            !begins_in_parents(drawn.draft))
            continue;
        drawn.arch = measured;
        drawn.right_tortuosity = tortuosity(vessel_in(drawn.draft, ILIACS[0]));
        drawn.left_tortuosity = tortuosity(vessel_in(drawn.draft, ILIACS[1]));
        if (wish.tortuosity && std::max(std::abs(drawn.right_tortuosity - *wish.tortuosity),
                                        std::abs(drawn.left_tortuosity - *wish.tortuosity)) > TORTUOSITY_OFF)
            continue;
        drawn.draft.title =
            crn::formatted("Aorta %llu: arch of type %s%s", static_cast<unsigned long long>(seed),
                           arch_type_name(measured.type), measured.has_common_trunk ? ", common trunk" : "");
        return drawn;
    }
    throw std::runtime_error(
        crn::formatted("anatomy --seed %llu: no plausible tree in %u attempts; choose another seed%s",
                       static_cast<unsigned long long>(seed), ATTEMPTS_MAX,
                       wish.tortuosity ? ", or a --tortuosity nearer to 1.15" : ""));
}

} // namespace anatomy
