#include "tools/patient/parts.hpp"
#include "host/base/format.hpp"
#include "host/base/output_files.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/fault.hpp"
#include "tools/centreline/fit/axes.hpp"
#include "tools/mesh/files/mesh_file.hpp"
#include "tools/patient/vtp_surface.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace crn::patient
{
namespace
{

namespace fs = std::filesystem;

struct RawPart {
    std::string name;
    fs::path file;
    bake::MeshPiece piece;
};

std::string lower(std::string text)
{
    for (char &c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return text;
}

bool has_any(const std::string &text, std::initializer_list<const char *> words)
{
    return std::any_of(words.begin(), words.end(), [&](const char *w) { return text.find(w) != text.npos; });
}

bool is_gltf(const fs::path &file)
{
    const std::string ending = lower(file.extension().string());
    return ending == ".glb" || ending == ".gltf";
}

std::vector<RawPart> read_raw(const PartsWish &wish)
{
    std::vector<RawPart> parts;
    for (const fs::path &file : wish.files) {
        std::vector<bake::MeshPiece> pieces;
        if (is_vtp(file))
            pieces.push_back(read_vtp_surface(file));
        else
            pieces = bake::read_mesh_file(file, wish.parts);
        for (bake::MeshPiece &piece : pieces) {
            if (piece.triangles.empty()) continue;
            const bool is_named = pieces.size() > 1 && !piece.name.empty();
            parts.push_back({is_named ? piece.name : file.stem().string(), file, std::move(piece)});
        }
    }
    if (parts.empty())
        throw Fault(wish.files.front().string() +
                    ": holds no triangle: export the surface, not points or lines");
    return parts;
}

// Without a wish, a file with names of arteries gives its arteries.
void choose_parts(std::vector<RawPart> &parts, const PartsWish &wish, Choices &choices)
{
    const auto arteries = std::count_if(parts.begin(), parts.end(),
                                        [](const RawPart &part) { return is_artery_name(part.name); });
    if (!wish.parts.empty()) {
        choices.add("parts", std::to_string(parts.size()), "as stated", "--part NAME");
    } else if (arteries > 0 && static_cast<std::size_t>(arteries) < parts.size()) {
        std::erase_if(parts, [](const RawPart &part) { return !is_artery_name(part.name); });
        choices.add("parts", formatted("%zu arteries by their names", parts.size()),
                    "veins, pulmonary arteries and organs are left out",
                    "--part NAME, or --part '*' for all");
    } else if (parts.size() > 1) {
        choices.add("parts", "all " + std::to_string(parts.size()), "no name says which are arteries",
                    "--part NAME");
    }
}

double extent_of(const std::vector<RawPart> &parts)
{
    Eigen::AlignedBox3f box;
    for (const RawPart &part : parts)
        for (const auto &v : part.piece.vertices) box.extend(Eigen::Vector3f(v.data()));
    return static_cast<double>(box.sizes().maxCoeff());
}

// A mean radius of the vessels, in the file's unit: twice the volume over the area, as for a tube. Open ends
// change it little, because volumes are taken about a corner of each part.
double mean_radius_of(const std::vector<RawPart> &parts)
{
    double volume = 0, area = 0;
    for (const RawPart &part : parts) {
        double own = 0;
        const auto corner = [&](std::uint32_t index) {
            const auto &v = part.piece.vertices[index];
            return Eigen::Vector3d(v[0], v[1], v[2]);
        };
        const Eigen::Vector3d origin = corner(part.piece.triangles.front()[0]);
        for (const auto &t : part.piece.triangles) {
            const Eigen::Vector3d a = corner(t[0]) - origin, b = corner(t[1]) - origin,
                                  c = corner(t[2]) - origin;
            own += a.dot(b.cross(c)) / 6;
            area += (b - a).cross(c - a).norm() / 2;
        }
        volume += std::abs(own);
    }
    return area > 0 ? 2 * volume / area : 0;
}

// Programs for flow simulations write centimetres. An aorta of 40 cm then looks like vessels of 40 mm that
// are as thin as an aorta is in centimetres, too thin for instruments.
bool is_rather_cm(const std::vector<RawPart> &parts, double extent)
{
    constexpr double short_mm = 70, thin_mm = 1.3;
    return extent <= short_mm && mean_radius_of(parts) < thin_mm;
}

std::string unit_of(const std::vector<RawPart> &parts, const PartsWish &wish, Choices &choices)
{
    const double extent = extent_of(parts);
    std::string unit = wish.unit, why = "as stated";
    if (unit.empty() &&
        std::all_of(parts.begin(), parts.end(), [](const RawPart &p) { return is_gltf(p.file); })) {
        unit = "m";
        why = "glTF files are in metres";
    } else if (unit.empty()) {
        // A patient's vessels are 15 mm to 2.5 m long. Where two units would do, the usual one is taken.
        for (const char *guess : {"mm", "m", "cm", "um"}) {
            const double mm = extent * millimetres_per(guess);
            if (mm >= 15 && mm <= 2500) {
                unit = guess;
                break;
            }
        }
        if (unit.empty())
            throw Fault(
                formatted("%s: is %.4g long, which is a patient's vessel in no unit (15 mm to 2.5 m): check "
                          "the file's scale, or state --unit",
                          parts.front().file.c_str(), extent));
        why = formatted("the mesh is %.4g long, so %.0f mm", extent, extent * millimetres_per(unit));
        if (unit == "mm" && is_rather_cm(parts, extent)) {
            unit = "cm";
            why = formatted("the mesh is %.4g long with vessels of radius %.2g, which would be too thin for "
                            "instruments in mm",
                            extent, mean_radius_of(parts));
        }
    }
    choices.add("unit", unit, why, "--unit mm, cm, m or um");
    return unit;
}

// In scans +z is the head and +y the back (LPS). Other files have +y upwards, as the scene.
std::string axes_for(const std::vector<RawPart> &parts, const PartsWish &wish, Choices &choices)
{
    std::string axes = lower(wish.axes), why = "as stated";
    if (axes == "lps" || axes == "ras") {
        axes = axes == "lps" ? "+x,+z,-y" : "-x,+z,+y";
    } else if (axes.empty() &&
               std::all_of(parts.begin(), parts.end(), [](const RawPart &p) { return is_gltf(p.file); })) {
        axes = "+x,+y,+z";
        why = "glTF files have +y upwards and +z to the front";
    } else if (axes.empty()) {
        Eigen::AlignedBox3f box;
        for (const RawPart &part : parts)
            for (const auto &v : part.piece.vertices) box.extend(Eigen::Vector3f(v.data()));
        const Eigen::Vector3f size = box.sizes();
        constexpr float longer = 1.2f;
        if (size.z() > longer * size.x() && size.z() > longer * size.y()) {
            axes = "+x,+z,-y";
            why = "z is the longest axis, so it is taken for the head's, as in scans (LPS)";
        } else if (size.x() > longer * size.y() && size.x() > longer * size.z()) {
            axes = "-y,+x,+z";
            why = "x is the longest axis, so it is taken for the head's; nothing says whether +x or -x is "
                  "the head";
        } else {
            axes = "+x,+y,+z";
            why = "the file's axes are taken for the scene's";
        }
    }
    choices.add("axes", axes, why + "; these are the patient's left, head and front",
                "--axes lps, ras or such as +x,+z,-y");
    return axes;
}

// Drops the triangles that a mesh has more than once, whichever way they look: some programs write a second
// layer for the back of a surface, or a shell twice. Returns how many were dropped. The first one of each
// stays.
std::size_t drop_doubled(bake::Mesh &mesh)
{
    std::set<bake::Triangle> seen;
    return std::erase_if(mesh.triangles, [&](bake::Triangle corners) {
        std::sort(corners.begin(), corners.end());
        return !seen.insert(corners).second;
    });
}

// Drops the parts that have the same triangles at the same places as an earlier part. Returns how many
// triangles were dropped.
std::size_t drop_doubled_parts(std::vector<Part> &parts)
{
    std::size_t dropped = 0;
    for (std::size_t p = parts.size(); p-- > 1;) {
        const bake::Mesh &mesh = parts[p].mesh;
        const bool is_doubled = std::any_of(
            parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(p), [&](const Part &other) {
                return other.mesh.triangles == mesh.triangles && other.mesh.vertices_mm == mesh.vertices_mm;
            });
        if (!is_doubled) continue;
        dropped += mesh.triangles.size();
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(p));
    }
    return dropped;
}

} // namespace

Eigen::Matrix3d axes_of(const std::string &text)
{
    return centreline::turned_axes(text, "; or lps, ras");
}

bool is_artery_name(const std::string &name)
{
    const std::string text = lower(name);
    if (has_any(text, {"vein", "vena", "venous", "pulmon", "sinus", "portal"})) return false;
    return has_any(text, {"arter", "aort", "carotid", "iliac", "femoral", "brachiocephalic", "subclavian",
                          "coronar", "marginal_branch", "ventricular_branch", "diagonal", "septal", "celiac",
                          "coeliac"});
}

std::string BranchNames::add(std::string wanted)
{
    constexpr std::size_t letters_max = CRN_SCENE_BRANCH_NAME_BYTES - 1;
    const auto cut_to = [](std::string name, std::size_t letters) {
        name.resize(std::min(name.size(), letters));
        while (!name.empty() && name.back() == '_') name.pop_back();
        return name;
    };
    wanted = cut_to(wanted, wanted.size());
    if (wanted.empty()) wanted = "vessel";
    std::string name = cut_to(wanted, letters_max);
    for (int number = 2; !used_.insert(name).second; ++number) {
        const std::string ending = "_" + std::to_string(number);
        name = cut_to(wanted, letters_max - ending.size()) + ending;
    }
    return name;
}

std::vector<std::string> short_names(const std::vector<std::string> &names, Choices *choices)
{
    std::size_t same = names.empty() ? 0 : names.front().size();
    for (const std::string &name : names) {
        std::size_t n = 0;
        while (n < same && n < name.size() && name[n] == names.front()[n]) ++n;
        same = n;
    }
    // Only whole words that begin a number of names, as "VH_M_" does; two parts may well begin alike.
    while (same > 0 && names.front()[same - 1] != '_') --same;
    const bool is_number = std::any_of(names.begin(), names.end(), [&](const std::string &name) {
        return same < name.size() && name[same] >= '0' && name[same] <= '9';
    });
    if (names.size() < 3 || is_number) same = 0;
    std::vector<std::string> made;
    BranchNames used;
    std::string cut;
    for (const std::string &name : names) {
        std::string plain;
        for (char c : lower(name.substr(same)))
            plain += (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ? c : '_';
        while (!plain.empty() && plain.front() == '_') plain.erase(0, 1);
        made.push_back(used.add(plain));
        if (plain.size() >= CRN_SCENE_BRANCH_NAME_BYTES)
            cut += (cut.empty() ? "" : ", ") + made.back() + " for " + name;
    }
    if (choices && !cut.empty())
        choices->add("cut", cut,
                     formatted("a branch's name has at most %d letters", CRN_SCENE_BRANCH_NAME_BYTES - 1),
                     "tree.csv may be changed");
    return made;
}

std::vector<Part> read_parts(const PartsWish &wish, Choices &choices, Frame &frame)
{
    std::vector<RawPart> raw = read_raw(wish);
    choose_parts(raw, wish, choices);
    frame.unit = frame.placement.unit = unit_of(raw, wish, choices);
    frame.axes = axes_for(raw, wish, choices);
    frame.placement.axes = axes_of(frame.axes);
    const double unit_mm = millimetres_per(frame.unit);
    Eigen::AlignedBox3d box;
    for (const RawPart &part : raw)
        for (const auto &v : part.piece.vertices)
            box.extend(frame.placement.place({v[0], v[1], v[2]}, unit_mm));
    constexpr double far_mm = 1000; // a scene ends 1.9 m from its origin
    if (box.center().norm() > far_mm) {
        frame.placement.offset_mm = -box.center();
        choices.add("offset", bake::place_text(frame.placement.offset_mm),
                    "the mesh lies more than a metre from the origin", "");
    }
    std::vector<Part> parts;
    std::size_t doubled = 0;
    for (RawPart &part : raw) {
        bake::Mesh mesh;
        mesh.name = raw.size() > 1 ? part.file.string() + ", part " + part.name : part.file.string();
        for (const auto &v : part.piece.vertices)
            mesh.vertices_mm.push_back(frame.placement.place({v[0], v[1], v[2]}, unit_mm));
        mesh.triangles = part.piece.triangles;
        bake::weld(mesh);
        doubled += drop_doubled(mesh);
        parts.push_back({part.name, std::move(mesh)});
    }
    doubled += drop_doubled_parts(parts);
    if (doubled > 0)
        choices.add("doubled", formatted("%zu triangles count once", doubled),
                    "they are there more than once, with the same corners", "");
    return parts;
}

} // namespace crn::patient
