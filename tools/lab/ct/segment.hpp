// Finds the instrument's centreline, the instrument's surface and the lumen in scans, and writes them to
// files with pictures of every step.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/lab/ct/centreline.hpp"
#include "tools/lab/ct/lumen.hpp"
#include "tools/lab/ct/page.hpp"
#include <filesystem>

namespace crn::ct
{

struct SegmentOptions {
    LineOptions line;
    LumenOptions lumen;
    bool wants_lumen = true;
};

// Finds the instrument in one scan; writes instrument.ply and a picture into the page's folder. Throws Fault.
InstrumentLine segment_line(const Volume &volume, LineOptions options, Page &page, const Report &report);
// Writes centreline.csv, report.json, pictures of the centreline, and the page, which begins with the text
// `facts`.
void write_line(const InstrumentLine &line, const Volume &volume, Page &page, const std::string &facts);
// Returns the results as text in two lines, "volume ..." and "instrument ...".
std::string line_facts(const InstrumentLine &line, const Volume &volume);

struct LumenSurface {
    bake::Mesh mesh; // closed, mm, scene's axes
    Lumen lumen;
    std::vector<std::string> notes;
};
// Finds the lumen from scans that show one phantom at one position; writes lumen.ply and pictures into the
// page's folder. Throws Fault.
LumenSurface segment_lumen(const std::vector<LumenScan> &scans, const LumenOptions &options, Page &page,
                           const Report &report);
std::string lumen_facts(const LumenSurface &surface);

// Finds the instrument's centreline and the lumen in one scan, and writes the page index.html.
struct Segmentation {
    InstrumentLine line;
    bake::Mesh lumen; // closed, mm, scene's axes; empty where it was not requested
};
Segmentation segment_scan(const Volume &volume, const SegmentOptions &options,
                          const std::filesystem::path &folder, const Report &report);

// States how far two polylines are apart: the mean and maximum distance from the first polyline's points to
// the second polyline, and the distance between the two tips.
struct Apart {
    double mean_mm = 0, max_mm = 0, tip_mm = 0;
    double offset_mm = 0; // for a surface: mean with its sign, + outside the reference
};
Apart lines_apart(const std::vector<Eigen::Vector3d> &line, const std::vector<Eigen::Vector3d> &reference);
// Returns the mean and the maximum distance from points of the first surface to the second surface, which
// must be closed; the mean is weighted by area on the first surface.
Apart surfaces_apart(const bake::Mesh &surface, const bake::Mesh &reference);

} // namespace crn::ct
