// VMTK writes centrelines as VTK polydata (.vtp), where every line is a branch whose points have a value
// MaximumInscribedSphereRadius. The .vtp files that this project writes also state, for each line, which
// branch the line leaves and at which sphere.
#include "host/base/number_text.hpp"
#include "tools/centreline/vtk_array.hpp"

#include <cmath>

namespace crn::centreline
{
namespace
{

constexpr const char *radius_array = "MaximumInscribedSphereRadius";

// Holds one Piece element of a .vtp file and its contents.
class Piece
{
  public:
    Piece(const VtkFile &file, const pugi::xml_node &node)
        : file_(file), node_(node), points_(count("NumberOfPoints")), lines_(count("NumberOfLines"))
    {
    }

    void add_to(Tree &tree) const
    {
        if (lines_ == 0) return;
        const std::vector<double> at = file_.values(node_.child("Points").child("DataArray"), 3 * points_);
        const pugi::xml_node radius = named("PointData", radius_array);
        if (!radius)
            file_.fail(std::string("has no point array ") + radius_array +
                       ": make the centreline with VMTK (vmtkcenterlines), which measures it");
        const std::vector<double> radii = file_.values(radius, points_);
        const std::vector<double> speeds = optional("PointData", "FlowSpeed_mm_s", points_),
                                  manual = optional("PointData", "Manual", points_),
                                  parents = optional("CellData", "ParentBranch", lines_),
                                  places = optional("CellData", "ParentSphere", lines_);
        const std::vector<std::string> names = branch_names();
        const std::vector<double> ends = file_.values(line_array("offsets"), lines_);
        const double total = ends.back();
        if (!(total >= 0 && total <= static_cast<double>(spheres_max)))
            file_.fail("has lines of " + trimmed_text(total, file_decimals) + " points, at most " +
                       std::to_string(spheres_max) + " are read: thin them");
        const std::vector<double> order =
            file_.values(line_array("connectivity"), static_cast<std::size_t>(total));
        std::size_t begin = 0;
        for (std::size_t line = 0; line < lines_; ++line) {
            Branch branch;
            if (line < names.size()) branch.name = names[line];
            if (!parents.empty()) branch.parent = static_cast<int>(whole(parents[line], -1, branches_max));
            if (!places.empty() && branch.parent >= 0)
                branch.parent_sphere = static_cast<std::size_t>(whole(places[line], 0, spheres_max));
            const std::size_t end =
                whole(ends[line], static_cast<double>(begin), static_cast<double>(order.size()));
            for (std::size_t k = begin; k < end; ++k) {
                const std::size_t p = whole(order[k], 0, static_cast<double>(points_) - 1);
                Sphere sphere{{at[3 * p], at[3 * p + 1], at[3 * p + 2]}, radii[p]};
                if (!speeds.empty()) sphere.speed_mm_s = speeds[p];
                if (!manual.empty()) sphere.is_manual = manual[p] != 0;
                branch.spheres.push_back(sphere);
            }
            begin = end;
            tree.branches.push_back(std::move(branch));
        }
    }

  private:
    std::size_t count(const char *attribute) const
    {
        const double value = number_of(node_.attribute(attribute).value());
        const double most = std::string(attribute) == "NumberOfLines" ? branches_max : spheres_max;
        if (value == std::floor(value) && value >= 0 && value <= most) return static_cast<std::size_t>(value);
        file_.fail(std::string("Piece has ") + attribute + " = '" + node_.attribute(attribute).value() +
                   "': a whole number up to " + trimmed_text(most, file_decimals) + " is needed");
    }

    // The value -1, which stands for "no parent", is returned as the largest std::size_t; stored as an int,
    // this number becomes -1 again.
    std::size_t whole(double value, double low, double high) const
    {
        if (value == std::floor(value) && value >= low && value <= high)
            return static_cast<std::size_t>(static_cast<long long>(value));
        file_.fail("has the index " + trimmed_text(value, file_decimals) + ", expected " +
                   trimmed_text(low, file_decimals) + " to " + trimmed_text(high, file_decimals) +
                   ": the file is damaged, export it again");
    }

    pugi::xml_node named(const char *place, const std::string &name) const
    {
        for (const pugi::xml_node &array : node_.child(place))
            if (array.attribute("Name").value() == name) return array;
        return {};
    }

    pugi::xml_node line_array(const std::string &name) const
    {
        const pugi::xml_node array = named("Lines", name);
        if (!array) file_.fail("has lines without the array '" + name + "': export the file again");
        return array;
    }

    std::vector<double> optional(const char *place, const std::string &name, std::size_t wanted) const
    {
        const pugi::xml_node array = named(place, name);
        return array ? file_.values(array, wanted) : std::vector<double>{};
    }

    // VTK stores a string as the numeric codes of its letters, followed by a 0.
    std::vector<std::string> branch_names() const
    {
        std::vector<std::string> names;
        std::string name;
        for (std::string_view word : words_of(named("CellData", "BranchName").child_value())) {
            const double letter = number_of(word);
            if (letter > 0 && letter < 256 && name.size() < 256) {
                name += static_cast<char>(static_cast<int>(letter));
                continue;
            }
            names.push_back(plain_name(name));
            name.clear();
        }
        return names;
    }

    const VtkFile &file_;
    pugi::xml_node node_;
    std::size_t points_, lines_;
};

std::string array_text(const std::string &type, const std::string &name, const std::string &values,
                       int components = 1)
{
    return "        <DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
           std::to_string(components) + "\" format=\"ascii\">\n" + values + "\n        </DataArray>\n";
}

} // namespace

Tree read_polydata(const std::string &text, const std::string &name)
{
    const VtkFile file(text, name);
    Tree tree;
    for (const pugi::xml_node &piece : file.document().child("VTKFile").child("PolyData").children("Piece")) {
        Piece(file, piece).add_to(tree);
        if (tree.branches.size() > branches_max || sphere_count(tree) > spheres_max)
            file.fail("has too many lines or points: split the file");
    }
    if (tree.branches.empty()) file.fail("holds no line: give a centreline, not a surface");
    check_tree(tree, name);
    return tree;
}

std::string polydata_text(const Tree &tree)
{
    std::string points, radii, speeds, manual, order, ends, parents, places, groups, names;
    std::size_t next = 0;
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        const Branch &branch = tree.branches[b];
        for (const Sphere &s : branch.spheres) {
            for (int k = 0; k < 3; ++k)
                points += trimmed_text(s.centre_mm[k], file_decimals) + (k < 2 ? " " : "\n");
            radii += trimmed_text(s.radius_mm, file_decimals) + " ";
            speeds += trimmed_text(s.speed_mm_s, file_decimals) + " ";
            manual += s.is_manual ? "1 " : "0 ";
            order += std::to_string(next++) + " ";
        }
        ends += std::to_string(next) + " ";
        parents += std::to_string(branch.parent) + " ";
        places += std::to_string(branch.parent_sphere) + " ";
        groups += std::to_string(b) + " ";
        for (char c : branch.name) names += std::to_string(static_cast<unsigned char>(c)) + " ";
        names += "0 ";
    }
    const std::string lines = std::to_string(tree.branches.size());
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt32\">\n  <PolyData>\n    <Piece NumberOfPoints=\"" +
           std::to_string(next) + "\" NumberOfVerts=\"0\" NumberOfLines=\"" + lines +
           "\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n      <PointData>\n" +
           array_text("Float64", radius_array, radii) + array_text("Float64", "FlowSpeed_mm_s", speeds) +
           array_text("UInt8", "Manual", manual) + "      </PointData>\n      <CellData>\n" +
           array_text("Int32", "GroupIds", groups) + array_text("Int32", "ParentBranch", parents) +
           array_text("Int32", "ParentSphere", places) +
           "        <Array type=\"String\" Name=\"BranchName\" NumberOfTuples=\"" + lines +
           "\" format=\"ascii\">\n" + names + "\n        </Array>\n      </CellData>\n      <Points>\n" +
           array_text("Float64", "Points", points, 3) + "      </Points>\n      <Lines>\n" +
           array_text("Int64", "connectivity", order) + array_text("Int64", "offsets", ends) +
           "      </Lines>\n    </Piece>\n  </PolyData>\n</VTKFile>\n";
}

} // namespace crn::centreline
