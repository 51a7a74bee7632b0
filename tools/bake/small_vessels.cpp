#include "tools/bake/small_vessels.hpp"
#include "host/base/text.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/fault.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

namespace crn::bake
{
namespace
{

constexpr std::size_t columns = 8;
constexpr std::string_view head = "vessel,parent,bed,flow_ul_s,x_mm,y_mm,z_mm,radius_mm";
constexpr std::array<std::string_view, 5> beds = {"systemic", "left_coronary", "right_coronary", "kidney",
                                                  "gut"};

class Reader
{
  public:
    Reader(const std::string &file, VesselTree &tree) : file_(file), tree_(tree)
    {
        for (std::size_t b = 0; b < tree.branches.size(); ++b)
            numbers_[tree.branches[b].name] = static_cast<int>(b);
    }

    void line(std::string_view text)
    {
        ++line_;
        if (line_ == 1 && text != head) fail("must begin with the line " + std::string(head));
        if (line_ == 1 || text.empty()) return;
        const std::array<std::string_view, columns> fields = split(text);
        if (fields[0].empty()) fail("has no name in column 'vessel'");
        if (tree_.small.empty() || fields[0] != name_) begin(fields);
        add_point(fields);
    }

    void end()
    {
        finish();
        for (const Joint &joint : joints_) {
            const auto other = numbers_.find(joint.other);
            line_ = joint.line;
            if (other == numbers_.end()) fail("there is no vessel '" + joint.other + "' that it could join");
            tree_.small[joint.vessel].joins = other->second;
        }
        std::string error;
        if (!check_vessel_tree(tree_, error)) throw Fault(file_ + ": " + error);
    }

  private:
    [[noreturn]] void fail(const std::string &what) const
    {
        throw Fault(file_ + ":" + std::to_string(line_) + ": " + what);
    }

    std::array<std::string_view, columns> split(std::string_view text) const
    {
        std::array<std::string_view, columns> fields;
        for (std::size_t i = 0; i < columns; ++i) {
            const std::size_t comma = text.find(',');
            if ((comma == std::string_view::npos) != (i + 1 == columns))
                fail("needs " + std::to_string(columns) + " fields with commas between them");
            fields[i] = text.substr(0, comma);
            if (i + 1 < columns) text.remove_prefix(comma + 1);
        }
        return fields;
    }

    double number(std::string_view field, std::string_view column, double least, double most) const
    {
        double value = 0.0;
        const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
        if (error != std::errc() || end != field.data() + field.size() || !(value >= least && value <= most))
            fail("'" + std::string(field) + "' in column '" + std::string(column) + "' is no number from " +
                 std::to_string(least) + " to " + std::to_string(most));
        return value;
    }

    void begin(const std::array<std::string_view, columns> &fields)
    {
        finish();
        name_ = fields[0];
        const bool is_number = name_[0] >= '0' && name_[0] <= '9';
        if (numbers_.count(name_) > 0) fail("there is a vessel '" + name_ + "' already");
        if (tree_.small.size() >= CRN_SCENE_SMALL_MAX)
            fail("there are over " + std::to_string(int{CRN_SCENE_SMALL_MAX}) + " small vessels");
        VesselBranch vessel;
        if (!is_number) vessel.name = name_;
        if (vessel.name.size() >= CRN_SCENE_BRANCH_NAME_BYTES)
            fail("the name '" + name_ + "' has over " + std::to_string(CRN_SCENE_BRANCH_NAME_BYTES - 1) +
                 " letters: give a shorter one");
        read_bed(fields[2], vessel);
        if (!fields[3].empty()) vessel.flow_ml_s = 1e-3 * number(fields[3], "flow_ul_s", 0.0, 1e5);
        const auto parent = numbers_.find(std::string(fields[1]));
        if (parent != numbers_.end())
            vessel.parent = parent->second;
        else if (!vessel.is_vein || !fields[1].empty())
            fail("there is no vessel '" + std::string(fields[1]) + "' before this one, its parent");
        numbers_[name_] = static_cast<int>(tree_.branches.size() + tree_.small.size());
        tree_.small.push_back(std::move(vessel));
    }

    void read_bed(std::string_view text, VesselBranch &vessel)
    {
        constexpr std::string_view vein = "_vein", into = "into ";
        if (text.starts_with(into)) {
            joints_.push_back({tree_.small.size(), std::string(text.substr(into.size())), line_});
            return;
        }
        vessel.is_vein = text.ends_with(vein);
        if (vessel.is_vein) text.remove_suffix(vein.size());
        for (std::size_t i = 0; i < beds.size(); ++i)
            if (beds[i] == text) {
                vessel.bed = static_cast<VesselBed>(i);
                return;
            }
        fail("'" + std::string(text) +
             "' in column 'bed' is none of systemic, left_coronary, right_coronary, "
             "kidney and gut, with or without _vein, nor 'into' and the name of an artery");
    }

    // Rounds to the precision of the body file; a point on the one before it is left out.
    void add_point(const std::array<std::string_view, columns> &fields)
    {
        VesselBranch &vessel = tree_.small.back();
        Eigen::Vector3d at_m;
        for (int axis = 0; axis < 3; ++axis)
            at_m[axis] = 1e-6 * std::round(1e3 * number(fields[static_cast<std::size_t>(4 + axis)],
                                                        "x_mm, y_mm, z_mm", -1800.0, 1800.0));
        if (!vessel.points_m.empty() && vessel.points_m.back() == at_m) return;
        vessel.points_m.push_back(at_m);
        vessel.radii_m.push_back(1e-6 * std::round(1e3 * number(fields[7], "radius_mm", 0.01, 100.0)));
    }

    // Joins the last vessel to the nearest point of its parent.
    void finish()
    {
        if (tree_.small.empty()) return;
        VesselBranch &vessel = tree_.small.back();
        if (vessel.points_m.size() < 2) fail("vessel '" + name_ + "' needs two points that differ");
        if (vessel.parent < 0) return;
        const VesselBranch &branch = tree_.numbered(static_cast<std::size_t>(vessel.parent));
        double least = 1e300;
        for (std::size_t i = 0; i < branch.points_m.size(); ++i) {
            const double square = (branch.points_m[i] - vessel.points_m[0]).squaredNorm();
            if (!(square < least)) continue;
            least = square;
            vessel.parent_point = i;
        }
    }

    // A vessel that joins another one, which may come later in the file.
    struct Joint {
        std::size_t vessel;
        std::string other;
        int line;
    };

    const std::string &file_;
    VesselTree &tree_;
    std::vector<Joint> joints_;
    std::map<std::string, int> numbers_;
    std::string name_;
    int line_ = 0;
};

} // namespace

void add_small_vessels(std::string_view text, const std::string &file, VesselTree &tree)
{
    Reader reader(file, tree);
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        reader.line(text.substr(begin, end - begin));
        begin = end + 1;
    }
    reader.end();
}

void read_small_vessels(const std::filesystem::path &file, VesselTree &tree)
{
    add_small_vessels(read_text_file(file.string()), file.string(), tree);
}

} // namespace crn::bake
