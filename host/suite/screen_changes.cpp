#include "host/suite/screen_changes.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace crn
{
namespace
{

constexpr std::size_t places_max = 24; // more are drawn as one

// Refers to the vertices and indices of an ImGui draw list, or of a copy of it.
struct Mesh {
    const ImDrawVert *vertices;
    const ImDrawIdx *indices;
    const ImDrawVert &corner(const ImDrawCmd &command, unsigned index) const
    {
        return vertices[command.VtxOffset + indices[command.IdxOffset + index]];
    }
};

// Returns the rectangle of pixels to which ImGui's drawing code limits a drawing command. ImGui's drawing
// code rounds the rectangle's corner and its size separately, and counts rows from the bottom.
ScreenRect limits_of(const ImDrawCmd &command, ScreenSize size)
{
    const ImVec4 &clip = command.ClipRect;
    const int left = static_cast<int>(clip.x),
              below = static_cast<int>(static_cast<float>(size.height) - clip.w);
    const int width = static_cast<int>(clip.z - clip.x), height = static_cast<int>(clip.w - clip.y);
    const ScreenRect limits{left, size.height - below - height, left + width, size.height - below};
    return common(limits, {0, 0, size.width, size.height});
}

struct Extent {
    ImVec2 low, high;
};

Extent extent_of(const Mesh &mesh, const ImDrawCmd &command, unsigned from, unsigned count)
{
    ImVec2 low = mesh.corner(command, from).pos, high = low;
    for (unsigned i = from; i < from + count; ++i) {
        const ImVec2 &at = mesh.corner(command, i).pos;
        low = {std::min(low.x, at.x), std::min(low.y, at.y)};
        high = {std::max(high.x, at.x), std::max(high.y, at.y)};
    }
    return {low, high};
}

ScreenRect pixels_of(const Mesh &mesh, const ImDrawCmd &command, unsigned from, unsigned count)
{
    const auto [low, high] = extent_of(mesh, command, from, count);
    return {static_cast<int>(std::floor(low.x)), static_cast<int>(std::floor(low.y)),
            static_cast<int>(std::ceil(high.x)), static_cast<int>(std::ceil(high.y))};
}

ScreenRect place_of(const Mesh &mesh, const ImDrawCmd &command, ScreenSize size)
{
    if (command.ElemCount == 0) return {};
    return common(pixels_of(mesh, command, 0, command.ElemCount), limits_of(command, size));
}

bool is_like(const ImDrawCmd &a, const ImDrawCmd &b)
{
    return a.ElemCount == b.ElemCount && a.TextureId == b.TextureId && !a.UserCallback && !b.UserCallback &&
           std::memcmp(&a.ClipRect, &b.ClipRect, sizeof a.ClipRect) == 0;
}

// Returns the rectangle around the triangles that differ between two drawing commands with equally many
// triangles.
ScreenRect difference(const Mesh &before, const ImDrawCmd &old, const Mesh &after, const ImDrawCmd &command,
                      ScreenSize size)
{
    ScreenRect place;
    for (unsigned first = 0; first + 3 <= command.ElemCount; first += 3) {
        bool is_same = true;
        for (unsigned i = first; i < first + 3; ++i)
            is_same = is_same &&
                      std::memcmp(&before.corner(old, i), &after.corner(command, i), sizeof(ImDrawVert)) == 0;
        if (is_same) continue;
        place = around(place, pixels_of(before, old, first, 3));
        place = around(place, pixels_of(after, command, first, 3));
    }
    return common(place, limits_of(command, size));
}

// Adds a rectangle to the list, and joins rectangles that overlap, so that no pixel is drawn twice.
void add(std::vector<ScreenRect> &places, ScreenRect place)
{
    if (place.is_empty()) return;
    for (;;) {
        const auto found = std::find_if(places.begin(), places.end(), [&](const ScreenRect &other) {
            return !common(place, other).is_empty();
        });
        if (found == places.end()) break;
        place = around(place, *found);
        places.erase(found);
    }
    places.push_back(place);
}

// Returns the parts of the rectangle `place` that the rectangle `other` does not cover.
std::vector<ScreenRect> without(const ScreenRect &place, const ScreenRect &other)
{
    const ScreenRect hole = common(place, other);
    if (hole.is_empty()) return {place};
    std::vector<ScreenRect> parts{{place.left, place.top, place.right, hole.top},
                                  {place.left, hole.bottom, place.right, place.bottom},
                                  {place.left, hole.top, hole.left, hole.bottom},
                                  {hole.right, hole.top, place.right, hole.bottom}};
    std::erase_if(parts, [](const ScreenRect &part) { return part.is_empty(); });
    return parts;
}

// Returns the rectangle of pixels that an opaque picture covers completely; it is empty if the command draws
// no such picture.
ScreenRect covered_by(const Mesh &mesh, const ImDrawCmd &command, ScreenSize size,
                      const std::vector<ImTextureID> &pictures)
{
    const bool is_picture = std::find(pictures.begin(), pictures.end(), command.TextureId) != pictures.end();
    if (!is_picture || command.UserCallback || command.ElemCount != 6) return {};
    for (unsigned i = 0; i < 6; ++i)
        if ((mesh.corner(command, i).col & IM_COL32_A_MASK) != IM_COL32_A_MASK) return {};
    const auto [low, high] = extent_of(mesh, command, 0, 6);
    const ScreenRect inside{static_cast<int>(std::ceil(low.x)), static_cast<int>(std::ceil(low.y)),
                            static_cast<int>(std::floor(high.x)), static_cast<int>(std::floor(high.y))};
    return common(inside, limits_of(command, size));
}

} // namespace

ScreenRect common(const ScreenRect &a, const ScreenRect &b)
{
    const ScreenRect both{std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
                          std::min(a.bottom, b.bottom)};
    return both.is_empty() ? ScreenRect{} : both;
}

ScreenRect around(const ScreenRect &a, const ScreenRect &b)
{
    if (a.is_empty()) return b;
    if (b.is_empty()) return a;
    return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right),
            std::max(a.bottom, b.bottom)};
}

ScreenChanges::List ScreenChanges::copy_of(const ImDrawList &list)
{
    return {{list.CmdBuffer.begin(), list.CmdBuffer.end()},
            {list.VtxBuffer.begin(), list.VtxBuffer.end()},
            {list.IdxBuffer.begin(), list.IdxBuffer.end()}};
}

std::vector<ScreenRect> ScreenChanges::take(const ImDrawData &data, ScreenSize size,
                                            const std::vector<ImTextureID> &fresh)
{
    std::vector<List> lists;
    for (int i = 0; i < data.CmdListsCount; ++i) lists.push_back(copy_of(*data.CmdLists[i]));
    const std::vector<List> before = std::exchange(lists_, std::move(lists));
    const bool has_size = std::exchange(size_, size) == size;
    if (before.empty() || !has_size) return {{0, 0, size.width, size.height}};
    std::vector<ScreenRect> places;
    const List none;
    for (std::size_t i = 0; i < std::max(before.size(), lists_.size()); ++i) {
        const List &old = i < before.size() ? before[i] : none, &list = i < lists_.size() ? lists_[i] : none;
        const Mesh old_mesh{old.vertices.data(), old.indices.data()};
        const Mesh mesh{list.vertices.data(), list.indices.data()};
        for (std::size_t k = 0; k < std::max(old.commands.size(), list.commands.size()); ++k) {
            const ImDrawCmd *was = k < old.commands.size() ? &old.commands[k] : nullptr;
            const ImDrawCmd *is = k < list.commands.size() ? &list.commands[k] : nullptr;
            const bool is_fresh = is && std::find(fresh.begin(), fresh.end(), is->TextureId) != fresh.end();
            if (was && is && !is_fresh && is_like(*was, *is)) {
                add(places, difference(old_mesh, *was, mesh, *is, size));
                continue;
            }
            if (was) add(places, place_of(old_mesh, *was, size));
            if (is) add(places, place_of(mesh, *is, size));
        }
    }
    if (places.size() > places_max) {
        ScreenRect all;
        for (const ScreenRect &place : places) all = around(all, place);
        places = {all};
    }
    return places;
}

// The drawing commands are processed from the last to the first. Commands before a picture draw nothing in
// the pixels that the picture covers.
void keep_places(ImDrawData &data, ScreenSize size, const std::vector<ScreenRect> &places,
                 const std::vector<ImTextureID> &pictures)
{
    std::vector<ScreenRect> free = places;
    for (int i = data.CmdListsCount - 1; i >= 0; --i) {
        ImDrawList &list = *data.CmdLists[i];
        const Mesh mesh{list.VtxBuffer.Data, list.IdxBuffer.Data};
        std::vector<ImDrawCmd> kept; // from the last to the first
        for (int k = list.CmdBuffer.Size - 1; k >= 0; --k) {
            const ImDrawCmd &command = list.CmdBuffer[k];
            if (command.UserCallback) kept.push_back(command);
            const ScreenRect drawn = place_of(mesh, command, size);
            for (const ScreenRect &place : free) {
                const ScreenRect part = common(drawn, place);
                if (part.is_empty()) continue;
                kept.push_back(command);
                kept.back().ClipRect = {static_cast<float>(part.left), static_cast<float>(part.top),
                                        static_cast<float>(part.right), static_cast<float>(part.bottom)};
            }
            const ScreenRect covered = covered_by(mesh, command, size, pictures);
            if (covered.is_empty()) continue;
            std::vector<ScreenRect> rest;
            for (const ScreenRect &place : free)
                for (const ScreenRect &part : without(place, covered)) rest.push_back(part);
            free = std::move(rest);
        }
        list.CmdBuffer.resize(static_cast<int>(kept.size()));
        std::copy(kept.rbegin(), kept.rend(), list.CmdBuffer.begin());
    }
}

} // namespace crn
