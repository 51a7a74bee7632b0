#include "tools/lab/ct/instrument_scan.hpp"
#include "host/model/instrument.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <set>

namespace crn::ct
{

namespace
{

Material material_of(const std::string &name, const std::string &where)
{
    const std::optional<Material> material = material_from_name(name);
    if (!material)
        throw Fault(where + ": nobody knows the material " + name + ": give one of " + material_names());
    return *material;
}

} // namespace

std::vector<ScanStretch> stretches_of(const std::string &instrument_path)
{
    const Instrument instrument = read_instrument(instrument_path);
    const double length_mm = instrument.length_m * 1e3;
    std::set<double> borders = {0, length_mm};
    for (const InstrumentLayer &layer : instrument.layers)
        borders.insert({layer.arc_begin_m * 1e3, layer.arc_end_m * 1e3});
    const auto knots_begin = instrument.table.knots, knots_end = knots_begin + instrument.table.knots_count;
    for (auto knot = knots_begin; knot != knots_end; ++knot) borders.insert(knot->arc_um * 1e-3);
    std::vector<ScanStretch> stretches;
    for (auto border = borders.begin(); std::next(border) != borders.end(); ++border) {
        ScanStretch stretch;
        stretch.arc_begin_mm = *border;
        stretch.arc_end_mm = std::min(length_mm, *std::next(border));
        if (stretch.arc_end_mm - stretch.arc_begin_mm < 1e-6) continue;
        const double middle_mm = 0.5 * (stretch.arc_begin_mm + stretch.arc_end_mm);
        const auto after = std::find_if(knots_begin, knots_end,
                                        [&](const auto &knot) { return knot.arc_um * 1e-3 > middle_mm; });
        const auto &knot = after == knots_begin ? *knots_begin : *(after - 1);
        stretch.radius_mm = knot.radius_outer_um * 1e-3;
        stretch.bore_mm = knot.radius_inner_um * 1e-3;
        for (const InstrumentLayer &layer : instrument.layers)
            if (layer.arc_begin_m * 1e3 <= middle_mm && middle_mm < layer.arc_end_m * 1e3)
                stretch.layers.push_back(
                    {material_of(layer.material, instrument_path), layer.fill, layer.radius_share});
        stretches.push_back(stretch);
    }
    return stretches;
}

std::vector<ScanStretch> plain_stretch(double radius_mm, double bore_mm, const std::string &material)
{
    return {{0, 1e6, radius_mm, bore_mm, {{material_of(material, "--material"), 1, 1}}}};
}

} // namespace crn::ct
