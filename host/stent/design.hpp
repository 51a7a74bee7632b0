// Reads the design of a stent from its file (TOML, docs/stent.md), and computes from its geometry the height
// of a ring and the foreshortening.
//
//      tip <-- axis ----------------------------->      a ring is a zigzag of 2 N struts with N crowns on either side;
//        /\  /\  /\        /\  /\  /\                   some crowns of neighbouring rings are joined by links:
//       /  \/  \/  \ link /  \/  \/  \                  `facing`  crown to the crown opposite, rings mirrored
//                                                       `offset`  crown to the same crown of the next ring, rings alike
//
// Lengths are in mm, and forces in N. A radius is measured to the middle of the struts: on a balloon of
// radius r the stent's radius is r + thickness / 2.
#pragma once
#include <span>
#include <string>

namespace crn
{

enum class StentConnection { offset, facing };

struct StentDesign {
    std::string name, description;
    std::string material;             // of the struts, as in docs/xray.md
    double diameter_mm = 3.0;         // nominal, inside: diameter of the balloon
    double diameter_max_mm = 3.75;    // largest inside diameter to which it may be opened
    double crimped_diameter_mm = 1.0; // outside, on the folded balloon
    double length_mm = 18.0;          // crimped
    int rings = 12, crowns = 6, links = 2;
    StentConnection connection = StentConnection::offset;
    double strut_length_mm = 1.3, strut_width_mm = 0.09, strut_thickness_mm = 0.08;
    double recoil = 0.03; // share of the diameter lost when the balloon deflates, without a load
    double ring_stiffness_N_per_mm =
        8.0;                       // of one ring: radial force around the circumference, per mm of radius
    double retention_N = 2.0;      // force along the balloon that a crimped stent withstands
    double marker_length_mm = 1.0; // of the balloon's bands at either end of the stent

    double crimped_radius_mm() const { return (crimped_diameter_mm - strut_thickness_mm) / 2; }
    double radius_on_mm(double balloon_radius_mm) const { return balloon_radius_mm + strut_thickness_mm / 2; }
    double nominal_radius_mm() const { return radius_on_mm(diameter_mm / 2); }

    // Returns the length of a strut as seen along the stent's axis, which is the chord 2 r sin(pi / 2 N) of a
    // ring of radius r with 2 N points.
    double chord_mm(double radius_mm) const;
    // Returns the height of a ring along the axis, if the struts keep their length: sqrt(strut^2 - chord^2),
    // where `chord` is the distance between neighbouring points around the axis.
    double ring_height_mm(double radius_mm) const;
    // Returns the distance between two crowns that a link joins, which is the length that the rings of a
    // crimped stent leave for links.
    double link_length_mm() const;
    // Returns the length that a straight stent has when all its rings are opened to this radius.
    double length_at_mm(double radius_mm) const;
    double foreshortening(double radius_mm) const { return 1 - length_at_mm(radius_mm) / length_mm; }
};

// Describes a number of a stent's design, with its key in files and its allowed range. The number in the file
// is the number of the design times `per_file` (100 for percent).
struct StentNumber {
    const char *key;
    double StentDesign::*value;
    double low, high; // of the number in the file
    double per_file = 1.0;
};
std::span<const StentNumber> stent_numbers();
struct StentCount {
    const char *key;
    int StentDesign::*value;
    int low, high;
};
std::span<const StentCount> stent_counts();

// Names the key of a value that is allowed by itself but impossible together with other values of the design,
// and the reason. If the key is empty, the values of the design are possible together.
struct StentFault {
    std::string key, text;
};
StentFault stent_fault(const StentDesign &stent);
// Returns true if all values of a design are in their ranges and are possible together. Only designs that do
// not come from a file need this check, because reading a file includes the same checks.
bool is_possible(const StentDesign &stent);

// Throws FileError with file, line, key, the cause and the remedy.
StentDesign read_stent(const std::string &path);

} // namespace crn
