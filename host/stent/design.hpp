// Stent files (TOML, docs/stent.md) -> what a stent is made of, and what its geometry alone says: height of a
// ring, foreshortening.
//
//      tip <-- axis ----------------------------->      a ring is a zigzag of 2 N struts with N crowns on either side;
//        /\  /\  /\        /\  /\  /\                   some crowns of neighbouring rings are joined by links:
//       /  \/  \/  \ link /  \/  \/  \                  `facing`  crown to the crown opposite, rings mirrored
//                                                       `offset`  crown to the same crown of the next ring, rings alike
//
// Lengths in mm, forces in N. Radii are those of the struts' axis: a balloon of radius r carries struts at r
// + thickness / 2.
#pragma once
#include <span>
#include <string>

namespace crn
{

enum class StentConnection { offset, facing };

struct StentDesign {
    std::string name, description;
    std::string material;             // of the struts, as in docs/xray.md
    double diameter_mm = 3.0;         // nominal: inside, that of the balloon
    double diameter_max_mm = 3.75;    // to which it may be opened, inside
    double crimped_diameter_mm = 1.0; // outside, on the folded balloon
    double length_mm = 18.0;          // crimped
    int rings = 12, crowns = 6, links = 2;
    StentConnection connection = StentConnection::offset;
    double strut_length_mm = 1.3, strut_width_mm = 0.09, strut_thickness_mm = 0.08;
    double recoil = 0.03; // share of the diameter lost when the balloon goes down, without a load
    double ring_stiffness_N_per_mm = 8.0; // of one ring: radial force, all round, per mm of radius
    double retention_N = 2.0;             // along the balloon, that a crimped stent withstands
    double marker_length_mm = 1.0;        // of the balloon's bands at either end of the stent

    double crimped_radius_mm() const { return (crimped_diameter_mm - strut_thickness_mm) / 2; }
    double radius_on_mm(double balloon_radius_mm) const { return balloon_radius_mm + strut_thickness_mm / 2; }
    double nominal_radius_mm() const { return radius_on_mm(diameter_mm / 2); }

    // Across a strut between its two crowns, round the axis: 2 r sin(pi / 2 N).
    double chord_mm(double radius_mm) const;
    // Of a ring along the axis when struts keep their length: sqrt(strut^2 - chord^2).
    double ring_height_mm(double radius_mm) const;
    // From a crown to the one that a link joins it with; what is left over for links when crimped.
    double link_length_mm() const;
    // Of a stent that is straight and even.
    double length_at_mm(double radius_mm) const;
    double foreshortening(double radius_mm) const { return 1 - length_at_mm(radius_mm) / length_mm; }
};

// Numbers of a stent with their keys in files and what they may be; a file's number is `per_file` of the
// design's (percent: 100).
struct StentNumber {
    const char *key;
    double StentDesign::*value;
    double low, high; // of the file's
    double per_file = 1.0;
};
std::span<const StentNumber> stent_numbers();
struct StentCount {
    const char *key;
    int StentDesign::*value;
    int low, high;
};
std::span<const StentCount> stent_counts();

// What every value by itself allows but all together do not: the key at fault and why. Empty key: nothing.
struct StentFault {
    std::string key, text;
};
StentFault stent_fault(const StentDesign &stent);
// All values in their ranges and possible together, as every design of a file is; for those that come from
// elsewhere.
bool is_possible(const StentDesign &stent);

// Throws FileError: file, line, key, what is wrong and what to do.
StentDesign read_stent(const std::string &path);

} // namespace crn
