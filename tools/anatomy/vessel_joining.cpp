/* Joins the vessels of one or more files to a tree, and checks that the vessels fit together. */
#include "host/base/number_text.hpp"
#include "host/base/text.hpp"
#include "tools/anatomy/output.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include <algorithm>

namespace anatomy
{

namespace
{

constexpr size_t VESSELS_MAX = 200;

[[noreturn]] void fail(const FilePlace &place, const std::string &vessel, const std::string &text)
{
    throw crn::FileError(place.file, place.line, 0, "vessel '" + vessel + "': " + text);
}

std::string rounded(double value)
{
    return crn::decimals_text(value, 1);
}

/* Returns the index of the vessel that has the given name, or the size of the list when no vessel has this
 * name. Two vessel names count as equal if they would give the vessels' files the same name. */
size_t index_of(const std::vector<GivenVessel> &vessels, const std::string &name)
{
    size_t i = 0;
    while (i < vessels.size() && file_stem(vessels[i].vessel.name) != file_stem(name)) i++;
    return i;
}

std::vector<std::string> names_of(const std::vector<GivenVessel> &vessels, size_t count)
{
    std::vector<std::string> names;
    for (size_t i = 0; i < count; i++) names.push_back(vessels[i].vessel.name);
    return names;
}

/* Returns the index in the list at which the new vessel must be inserted. */
size_t place_in(const TreeDraft &draft, const GivenVessel &given)
{
    const std::string &name = given.vessel.name;
    const size_t same = index_of(draft.vessels, name);
    if (given.replaces) {
        if (same == draft.vessels.size())
            fail(given.place, name,
                 "replaces no vessel" + crn::suggestion(name, names_of(draft.vessels, draft.vessels.size())));
        if (draft.vessels[same].vessel.name != name)
            fail(given.place, name,
                 "replaces '" + draft.vessels[same].vessel.name + "': spell the name like that");
        if (draft.vessels[same].place.file == given.place.file)
            fail(given.place, name, "replaces a vessel of the same file: leave one of them out");
        if (draft.vessels[same].is_coronary != given.is_coronary)
            fail(given.place, name, "a [[vessel]] replaces a [[vessel]], and a [[coronary]] a [[coronary]]");
        return same;
    }
    if (same < draft.vessels.size()) {
        const FilePlace &other = draft.vessels[same].place;
        fail(given.place, name,
             "there is a vessel of this name already, " + other.file + ":" + std::to_string(other.line) +
                 (other.file == given.place.file ? "" : "; to replace it, write replaces = true"));
    }
    if (draft.vessels.size() >= VESSELS_MAX)
        fail(given.place, name, "there are over " + std::to_string(VESSELS_MAX) + " vessels");
    if (given.is_coronary) return draft.vessels.size();
    size_t first_coronary = 0;
    while (first_coronary < draft.vessels.size() && !draft.vessels[first_coronary].is_coronary)
        first_coronary++;
    return first_coronary;
}

void check_parent(const TreeDraft &draft, const GivenVessel &given, size_t at)
{
    const std::string &name = given.vessel.name, &parent = given.vessel.parent;
    if (at == 0) {
        if (given.is_coronary)
            fail(given.place, name, "coronary arteries need an aorta: [[vessel]] before them");
        if (!parent.empty())
            fail(given.place, name, "is the first vessel, where blood enters, and has no 'parent'");
        return;
    }
    if (parent.empty())
        fail(given.place, name,
             "'parent' is missing: the vessel in which it begins; only the first vessel has none");
    if (parent == name) fail(given.place, name, "is its own 'parent'");
    const std::vector<std::string> before = names_of(draft.vessels, at);
    if (std::find(before.begin(), before.end(), parent) != before.end()) return;
    const std::vector<std::string> all = names_of(draft.vessels, draft.vessels.size());
    if (std::find(all.begin(), all.end(), parent) != all.end())
        fail(given.place, name, "'parent': '" + parent + "' comes after this vessel: put the parent first");
    fail(given.place, name,
         "'parent': there is no vessel '" + parent + "' before this one" + crn::suggestion(parent, before));
}

/* If a coronary artery begins in the aorta, the file must state its side (left or right); any other coronary
 * artery has the side of its parent. */
void check_side(const TreeDraft &draft, const GivenVessel &given)
{
    if (!given.is_coronary) return;
    const GivenVessel &parent = draft.vessels[index_of(draft.vessels, given.vessel.parent)];
    if (parent.is_coronary && given.has_side)
        fail(given.place, given.vessel.name,
             "'side' belongs to coronary arteries that leave the aorta; this one is on the side of its "
             "parent");
    if (!parent.is_coronary && !given.has_side)
        fail(given.place, given.vessel.name, "'side' is missing: side = \"left\" or \"right\"");
}

/* Checks that a vessel begins inside its parent vessel. The vessel's first point may lie outside the parent
   vessel by up to a quarter of the vessel's diameter, because the lumens of both vessels then still
   overlap. */
void check_begins_in_parent(const TreeDraft &draft, const GivenVessel &given, const std::string &file)
{
    if (given.vessel.parent.empty()) return;
    const GivenVessel &parent = draft.vessels[index_of(draft.vessels, given.vessel.parent)];
    const Station &start = given.vessel.stations.front();
    double outside_mm = 1e9;
    for (const CurvePoint &point : vessel_curve(parent.vessel, 1.0))
        outside_mm = std::min(outside_mm, (point.position_mm - start.position_mm).norm() - point.radius_mm);
    const double reach_mm = 0.25 * start.diameter_mm;
    if (outside_mm <= reach_mm) return;
    const bool is_own = given.place.file == file || parent.place.file != file;
    fail(is_own ? given.place : parent.place, given.vessel.name,
         "begins " + rounded(outside_mm) + " mm outside of its parent '" + parent.vessel.name +
             "': its first station must lie inside");
}

/* A lumen needs its parent's lumen. */
void check_lumen(const TreeDraft &draft, const GivenVessel &given)
{
    if (given.vessel.parent.empty() && !given.vessel.is_lumen)
        fail(given.place, given.vessel.name, "blood enters here, so it needs a lumen: leave out 'lumen'");
    if (given.vessel.parent.empty() || !given.vessel.is_lumen) return;
    if (!draft.vessels[index_of(draft.vessels, given.vessel.parent)].vessel.is_lumen)
        fail(given.place, given.vessel.name,
             "its parent '" + given.vessel.parent + "' has lumen = false: write lumen = false here, too");
}

/* An artery may join one that is stated later. */
void check_joins(const TreeDraft &draft, const GivenVessel &given)
{
    const std::string &joins = given.vessel.joins;
    if (joins.empty()) return;
    std::vector<std::string> small;
    for (const GivenVessel &other : draft.vessels)
        if (!other.vessel.is_lumen && &other != &given) small.push_back(other.vessel.name);
    if (std::find(small.begin(), small.end(), joins) == small.end())
        fail(given.place, given.vessel.name,
             "joins '" + joins + "', but there is no other vessel of this name with lumen = false" +
                 crn::suggestion(joins, small));
}

void set_entry(const GivenEntry &entry, VesselTree &tree)
{
    const std::vector<Vessel> vessels = body_vessels(tree);
    std::vector<std::string> names;
    for (const Vessel &vessel : vessels) names.push_back(vessel.name);
    const auto found = std::find(names.begin(), names.end(), entry.vessel);
    const auto fail_entry = [&](const std::string &text) {
        throw crn::FileError(entry.place.file, entry.place.line, 0, "entry: " + text);
    };
    if (found == names.end())
        fail_entry("there is no vessel '" + entry.vessel + "'" + crn::suggestion(entry.vessel, names));
    const Curve curve = vessel_curve(vessels[static_cast<size_t>(found - names.begin())], 1.0);
    size_t at = 0;
    for (size_t i = 0; i < curve.size(); i++)
        if (entry.y_mm ? curve[i].position_mm.y() > *entry.y_mm
                       : curve[i].arc_mm <= curve.back().arc_mm - entry.from_end_mm)
            at = i;
    if (at == 0 || at + 1 == curve.size())
        fail_entry("'" + entry.vessel + "' does not pass this place: it is " + rounded(curve.back().arc_mm) +
                   " mm long and goes from y = " + rounded(curve.front().position_mm.y()) +
                   " to y = " + rounded(curve.back().position_mm.y()));
    tree.entry_position_mm = curve[at].position_mm;
    tree.entry_direction = -curve_tangent(curve, at);
}

/* Gives every branch of a coronary artery the bed of its parent. The beds are set when the list of vessels is
 * complete, because a later file may replace the parent by an artery of the other coronary side. */
void set_beds_of_branches(TreeDraft &draft)
{
    for (GivenVessel &given : draft.vessels) {
        if (!given.is_coronary) continue;
        const GivenVessel &parent = draft.vessels[index_of(draft.vessels, given.vessel.parent)];
        if (parent.is_coronary) given.vessel.bed = parent.vessel.bed;
    }
}

} // namespace

void add_vessel(TreeDraft &draft, GivenVessel given)
{
    const size_t at = place_in(draft, given);
    check_parent(draft, given, at);
    check_side(draft, given);
    if (given.replaces)
        draft.vessels[at] = std::move(given);
    else
        draft.vessels.insert(draft.vessels.begin() + static_cast<std::ptrdiff_t>(at), std::move(given));
}

VesselTree tree_of(TreeDraft draft, const std::string &file)
{
    set_beds_of_branches(draft);
    VesselTree tree;
    tree.title = draft.title;
    tree.is_in_patient = draft.is_in_patient;
    tree.fillet_mm = draft.fillet_mm;
    tree.coronary_fillet_mm = draft.coronary_fillet_mm.value_or(0.0);
    for (const GivenVessel &given : draft.vessels) {
        check_begins_in_parent(draft, given, file);
        check_lumen(draft, given);
        check_joins(draft, given);
        if (!given.vessel.is_lumen) {
            tree.small.push_back(given.vessel);
            continue;
        }
        tree.vessels.push_back(given.vessel);
        tree.coronary_count += given.is_coronary ? 1 : 0;
    }
    if (tree.vessels.empty()) throw crn::FileError(file, 0, 0, "has no vessel: write [[vessel]]");
    if (!draft.entry) throw crn::FileError(file, 0, 0, "'entry' is missing: [entry]");
    if ((tree.coronary_count > 0) != draft.coronary_fillet_mm.has_value())
        throw crn::FileError(file, 0, 0,
                             tree.coronary_count > 0 ? "'coronary_fillet_mm' is missing"
                                                     : "'coronary_fillet_mm' without a [[coronary]]");
    set_entry(*draft.entry, tree);
    return tree;
}

} // namespace anatomy
