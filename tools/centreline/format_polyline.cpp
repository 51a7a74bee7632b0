// In a Wavefront OBJ file the centrelines are polylines, with one object per branch. The OBJ format has no
// radius, so the files that this project writes give the radius in a comment after each point.
#include "host/base/number_text.hpp"
#include "tools/centreline/formats.hpp"

#include <cmath>

namespace crn::centreline
{
namespace
{

constexpr double unknown_radius_mm = 1e-3;

class Reader
{
  public:
    Reader(const std::string &name, bool needs_radii) : name_(name), needs_radii_(needs_radii) {}

    void take(const TextLine &line)
    {
        where_ = name_ + ":" + std::to_string(line.number) + ": ";
        const std::vector<std::string_view> words = words_of(line.text);
        if (words.empty()) return;
        if (words[0] == "v") point(words);
        if (words[0] == "l") chain(words);
        if (words[0] == "o" || words[0] == "g") {
            next_ = Branch{};
            next_.name = plain_name(std::string(line.text.substr(line.text.find(words[0]) + 1)));
            next_.name.erase(0, next_.name.find_first_not_of(' '));
            is_new_ = true;
        }
        if (words[0] != "#" || words.size() < 3) return;
        if (words[1] == "radius_mm" && !points_.empty()) points_.back().radius_mm = number(words[2]);
        if (words[1] == "speed_mm_s" && !points_.empty()) points_.back().speed_mm_s = number(words[2]);
        if (words[1] == "leaves" && words.size() == 4) {
            next_.parent = static_cast<int>(whole(words[2]));
            next_.parent_sphere = static_cast<std::size_t>(whole(words[3]));
        }
    }

    Tree finish()
    {
        if (tree_.branches.empty())
            throw Fault(name_ +
                        ": holds no line ('l 1 2 3'): export the centreline as a polyline, not a surface");
        for (Branch &branch : tree_.branches)
            for (Sphere &sphere : branch.spheres) {
                if (sphere.radius_mm != 0) continue;
                if (needs_radii_)
                    throw Fault(name_ +
                                ": has points without '# radius_mm R': measure the radii in the mesh "
                                "with `centreline convert " +
                                name_ + " --radii-from MESH -o tree.csv`");
                sphere.radius_mm = unknown_radius_mm;
            }
        check_tree(tree_, name_);
        return std::move(tree_);
    }

  private:
    double number(std::string_view word) const
    {
        const double value = number_of(word);
        if (std::isfinite(value)) return value;
        throw Fault(where_ + "'" + std::string(word.substr(0, 40)) + "' is no number: correct it");
    }

    long long whole(std::string_view word) const
    {
        const double value = number(word.substr(0, word.find('/')));
        if (value == std::floor(value) && std::abs(value) < 1e9) return static_cast<long long>(value);
        throw Fault(where_ + "'" + std::string(word.substr(0, 40)) + "' is no whole number: correct it");
    }

    void point(const std::vector<std::string_view> &words)
    {
        if (words.size() < 4) throw Fault(where_ + "a point needs three numbers: v x y z");
        if (points_.size() == spheres_max)
            throw Fault(where_ + "more than " + std::to_string(spheres_max) + " points: thin them");
        Sphere sphere;
        sphere.centre_mm = {number(words[1]), number(words[2]), number(words[3])};
        points_.push_back(sphere);
    }

    // The elements "l 1 2" and "l 2 3" of one object form one branch, because other programs write each
    // segment of a polyline separately.
    void chain(const std::vector<std::string_view> &words)
    {
        std::vector<std::size_t> order;
        for (std::size_t i = 1; i < words.size(); ++i) {
            const long long index = whole(words[i]), count = static_cast<long long>(points_.size());
            const long long from_0 = index < 0 ? count + index : index - 1;
            if (index == 0 || from_0 < 0 || from_0 >= count)
                throw Fault(where_ + "point " + std::to_string(index) + " does not exist, there are " +
                            std::to_string(count) +
                            ": numbers begin at 1, and points stand before their line");
            order.push_back(static_cast<std::size_t>(from_0));
        }
        if (order.size() < 2) throw Fault(where_ + "a line needs two points: l 1 2");
        const bool goes_on = !is_new_ && !tree_.branches.empty() && order.front() == last_;
        if (!goes_on) {
            if (tree_.branches.size() == branches_max)
                throw Fault(where_ + "more than " + std::to_string(branches_max) + " lines: split the file");
            tree_.branches.push_back(next_);
            next_.parent = -1;
        }
        for (std::size_t i = goes_on ? 1 : 0; i < order.size(); ++i)
            tree_.branches.back().spheres.push_back(points_[order[i]]);
        total_ += order.size();
        if (total_ > spheres_max) throw Fault(where_ + "the lines have too many points: thin them");
        last_ = order.back();
        is_new_ = false;
    }

    const std::string &name_;
    bool needs_radii_, is_new_ = true;
    std::string where_;
    Branch next_;
    std::vector<Sphere> points_;
    std::size_t last_ = 0, total_ = 0;
    Tree tree_;
};

} // namespace

Tree read_polyline(const std::string &text, const std::string &name, bool needs_radii)
{
    Reader reader(name, needs_radii);
    for (const TextLine &line : lines_of(text)) reader.take(line);
    return reader.finish();
}

std::string polyline_text(const Tree &tree)
{
    std::string text = "# Vessel tree of inscribed spheres, millimetres\n";
    std::size_t next = 1;
    for (const Branch &branch : tree.branches) {
        text += "o " + plain_name(branch.name) + "\n";
        if (branch.parent >= 0)
            text += "# leaves " + std::to_string(branch.parent) + " " + std::to_string(branch.parent_sphere) +
                    "\n";
        std::string line = "l";
        for (const Sphere &s : branch.spheres) {
            text += "v " + trimmed_text(s.centre_mm.x(), file_decimals) + " " +
                    trimmed_text(s.centre_mm.y(), file_decimals) + " " +
                    trimmed_text(s.centre_mm.z(), file_decimals) + "\n# radius_mm " +
                    trimmed_text(s.radius_mm, file_decimals) + "\n";
            if (s.speed_mm_s != 0) text += "# speed_mm_s " + trimmed_text(s.speed_mm_s, file_decimals) + "\n";
            line += " " + std::to_string(next++);
        }
        text += line + "\n";
    }
    return text;
}

} // namespace crn::centreline
