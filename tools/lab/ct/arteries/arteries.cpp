#include "tools/lab/ct/arteries/arteries.hpp"
#include "tools/lab/ct/arteries/ascending.hpp"
#include "tools/lab/ct/arteries/bright.hpp"
#include "tools/lab/ct/arteries/repair.hpp"
#include "tools/lab/ct/arteries/trace.hpp"
#include <algorithm>

namespace crn::ct
{

namespace
{

using Eigen::Vector2d;

constexpr double stack_least_mm = 12;

// The voxels inside the discs of a stack, and between them, with their own widths.
void add_stack(const Volume &scan, const Bright &bright, const Stack &stack, std::vector<Source> &sources)
{
    constexpr double share = 0.8; // of the radius
    for (std::size_t n = 0; n < stack.size(); ++n) {
        const Disc &disc = stack[n], &next = stack[std::min(n + 1, stack.size() - 1)];
        const int last = n + 1 < stack.size() ? next.slice : disc.slice + 1;
        for (int k = disc.slice; k < last; ++k) {
            const double part = static_cast<double>(k - disc.slice) / (last - disc.slice);
            const Vector2d middle = disc.middle + part * (next.middle - disc.middle);
            const Ball ball{scan.scene({middle.x(), middle.y(), 1.0 * k}),
                            share * std::min(disc.radius_mm, next.radius_mm)};
            for_ball(scan, ball, [&](std::size_t at) {
                if (slice_of(scan, at) == k && bright.inside[at]) sources.push_back({at, bright.widths[at]});
            });
        }
    }
}

Mask mask_from(const Volume &scan, const std::vector<Source> &sources)
{
    Mask mask(scan.count(), 0);
    for (const Source &source : sources) mask[source.at] = 1;
    return mask;
}

// What growing gives: arteries that may be in pieces, and what was taken from them.
struct Grown {
    Mask artery, leaks, bone;
    Mask tubes; // where a click says that an artery is
};

// Grows from the sources through what is bright and not known as an artery already, and over bridges.
Grown grow_arteries(const Volume &scan, const Bright &bright, const Mask &known, std::vector<Source> sources,
                    const std::vector<std::size_t> &gates, const std::vector<Click> &clicks)
{
    Mask inside = bright.inside;
    for (std::size_t at = 0; at < known.size(); ++at) inside[at] = inside[at] && !known[at];
    Grown grown;
    const auto grow = [&] {
        Growth growth = grow_apart(scan, inside, bright.widths, bright.tubes, sources, bright.pieces);
        grown.leaks = cut_leaks(scan, bright.widths, gates, {}, growth);
        grown.artery = known.empty() ? Mask(scan.count(), 0) : known;
        grown.bone.assign(scan.count(), 0);
        for (std::size_t at = 0; at < growth.side.size(); ++at) {
            if (growth.is_artery(at)) grown.artery[at] = 1;
            grown.bone[at] = growth.side[at] == static_cast<unsigned char>(Side::other);
        }
    };
    grow();
    std::vector<Tube> tubes;
    for (const Click &click : clicks) {
        if (click.kind != ClickKind::bridge) continue;
        tubes.push_back(bridge_of(scan, bright, grown.artery, click));
        sources.push_back({tubes.back().to, bright.widths[tubes.back().to]});
        grow(); // the next bridge may lead on from what this one reaches
    }
    grown.tubes.assign(scan.count(), 0);
    for (const Tube &tube : tubes) mark_tube(scan, tube, grown.tubes);
    for (std::size_t at = 0; at < scan.count(); ++at) {
        grown.tubes[at] = grown.tubes[at] && !grown.artery[at];
        if (grown.tubes[at]) grown.artery[at] = 1;
    }
    return grown;
}

constexpr unsigned char heart_mark = 2; // among the leaks

// Marks the leaks that reach the root of the aorta.
void mark_heart(const Volume &scan, const Eigen::Vector3d &root_mm, Mask &leaks)
{
    constexpr double reach_mm = 30.0; // from the lowest disc of the ascending aorta over the sinuses
    std::vector<std::size_t> queue;
    for_ball(scan, {root_mm, reach_mm}, [&](std::size_t at) {
        if (leaks[at] == 1) queue.push_back(at);
    });
    flood_diagonally(scan, leaks, std::move(queue), 1, heart_mark);
}

LabelMap labels_of(const Volume &scan, const Grown &grown, const Mask &aorta)
{
    LabelMap labels{scan.like(0), artery_names()};
    labels.volume.name = "arteries";
    for (std::size_t at = 0; at < scan.count(); ++at) {
        const int label = grown.artery[at]  ? (aorta[at]                        ? label_aorta
                                               : grown.tubes[at] == thread_mark ? label_thread
                                               : grown.tubes[at]                ? label_bridge
                                                                                : label_artery)
                          : grown.leaks[at] ? (grown.leaks[at] == heart_mark ? label_heart : label_organ)
                          : grown.bone[at]  ? label_bone
                                            : 0;
        labels.volume.hu[at] = static_cast<float>(label);
    }
    return labels;
}

// Whether even blood at a click is brighter than what was taken for the aorta, which is then none: the marrow
// of a long bone is as round. A thin artery is darker than the aorta, by partial volume; a plaque is not
// even.
bool is_other_blood(const std::vector<Stack> &stacks, const Stack &clicked)
{
    constexpr double brighter = 1.2, even = 0.15;
    if (stacks.empty()) return true;
    const Disc &disc = clicked.front();
    return disc.noise_HU < even * disc.mean_HU &&
           disc.mean_HU > brighter * contrast_of(stacks.front()).mean_HU;
}

// Without an aorta, the blood enters where the arteries are widest at the scan's lower or upper border, or
// where they are widest if none reaches a border.
Eigen::Vector3d widest_place(const Volume &scan, const Bright &bright, const Mask &artery)
{
    constexpr double border_mm = 3.0;
    const int slices = static_cast<int>(std::ceil(border_mm / scan.spacing_mm[2]));
    std::size_t widest = scan.count();
    bool is_at_border = false;
    for (std::size_t at = 0; at < artery.size(); ++at) {
        if (!artery[at]) continue;
        const int slice = slice_of(scan, at);
        const bool is_near = slice < slices || slice >= scan.size[2] - slices;
        if (widest == scan.count() || is_near > is_at_border ||
            (is_near == is_at_border && bright.widths[at] > bright.widths[widest]))
            widest = at, is_at_border = is_near;
    }
    return place_at(scan, widest);
}

} // namespace

NamesTable artery_names()
{
    return {{label_aorta, "aorta"}, {label_artery, "artery"},    {label_heart, "heart"},
            {label_bone, "bone"},   {label_bridge, bridge_name}, {label_thread, thread_name},
            {label_organ, "organ"}};
}

FoundArteries find_arteries(const Volume &scan, const Mask &body, const std::vector<Click> &clicks,
                            Findings &findings, const Report &report)
{
    report("find the aorta", 0);
    const std::vector<Stack> stacks = round_stacks(scan, stack_least_mm);
    FoundArteries found;
    const Stack clicked = clicked_start(scan, clicks);
    found.has_aorta = clicked.empty() || !is_other_blood(stacks, clicked);
    found.descending = found.has_aorta ? descending_aorta(stacks, scan.name) : clicked;
    const Contrast contrast = contrast_of(found.descending);
    report("find the aorta", 1);
    report("separate arteries", 0);
    Bright bright = bright_of(scan, body, contrast);
    take_out(scan, cuts_of(clicks), bright);
    report("separate arteries", 0.3);
    std::vector<Source> sources;
    add_stack(scan, bright, found.descending, sources);
    if (found.has_aorta)
        found.ascending = ascending_aorta(
            scan, grow_apart(scan, bright.inside, bright.widths, bright.tubes, sources, bright.pieces),
            stacks, found.descending);
    add_stack(scan, bright, found.ascending, sources);
    const Mask start = mask_from(scan, sources);
    report("separate arteries", 0.6);
    const std::vector<std::size_t> gates = gate_below(scan, found.ascending);
    Mask unaided;
    if (has_artery_click(clicks)) unaided = grow_arteries(scan, bright, {}, sources, gates, {}).artery;
    for (const Source &source : sources_of(scan, bright, clicks)) sources.push_back(source);
    Grown grown = grow_arteries(scan, bright, {}, std::move(sources), gates, clicks);
    trace_clicked(scan, bright, contrast, clicks, unaided, start, grown.artery, grown.tubes, findings);
    join_clicked(scan, bright, clicks, start, grown.artery, grown.tubes, findings);
    keep_connected(scan, start, grown.artery);
    found.root_mm = found.has_aorta ? place_of(scan, found.ascending.empty() ? found.descending.back()
                                                                             : found.ascending.front())
                                    : widest_place(scan, bright, grown.artery);
    if (!found.ascending.empty()) mark_heart(scan, found.root_mm, grown.leaks);
    found.labels = labels_of(scan, grown, found.has_aorta ? start : Mask(scan.count(), 0));
    report("separate arteries", 1);
    return found;
}

void mend_arteries(const Volume &scan, const Mask &body, const Contrast &contrast,
                   const std::vector<Click> &clicks, LabelMap &labels, Findings &findings)
{
    if (std::all_of(clicks.begin(), clicks.end(), [](const Click &click) {
            return click.kind == ClickKind::entry || click.kind == ClickKind::name;
        }))
        return;
    Bright bright = bright_of(scan, body, contrast);
    Mask artery = mask_of(labels, labels.numbers(is_artery)), before = artery;
    Mask aorta = mask_of(labels, labels.numbers([](const std::string &name) { return name == "aorta"; }));
    const std::vector<Ball> cuts = cuts_of(clicks);
    take_out(scan, cuts, bright);
    for (const Ball &ball : cuts) for_ball(scan, ball, [&](std::size_t at) { artery[at] = aorta[at] = 0; });
    keep_largest(scan, aorta);
    Grown grown = grow_arteries(scan, bright, artery, sources_of(scan, bright, clicks), {}, clicks);
    trace_clicked(scan, bright, contrast, clicks, artery, aorta, grown.artery, grown.tubes, findings);
    join_clicked(scan, bright, clicks, aorta, grown.artery, grown.tubes, findings);
    keep_connected(scan, aorta, grown.artery);
    const int added = labels.names.rbegin()->first + 1;
    labels.names[added] = "artery";
    labels.names[added + 1] = bridge_name;
    labels.names[added + 2] = thread_name;
    for (std::size_t at = 0; at < before.size(); ++at) {
        if (before[at] && !grown.artery[at]) labels.volume.hu[at] = 0;
        if (!before[at] && grown.artery[at])
            labels.volume.hu[at] = static_cast<float>(added + grown.tubes[at]);
    }
}

} // namespace crn::ct
