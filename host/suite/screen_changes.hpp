// Finds where a screen differs from the screen before, so that only these places are drawn again. Without a
// graphics card, a flat square of the window's height alone takes 6 ms of processor time.
//
//   ScreenChanges changes;
//   const std::vector<ScreenRect> places = changes.take(*ImGui::GetDrawData(), size, fresh);
//   keep_places(*ImGui::GetDrawData(), size, places, pictures);
//   clear these places; ImGui_ImplOpenGL3_RenderDrawData(...); show these places
//
// What is drawn at these places is the same, pixel by pixel, as if everything were drawn.
#pragma once
#include <imgui.h>
#include <vector>

namespace crn
{

// Pixels of the window, from the top left corner; `right` and `bottom` do not belong to it.
struct ScreenRect {
    int left = 0, top = 0, right = 0, bottom = 0;
    bool is_empty() const { return left >= right || top >= bottom; }
    bool operator==(const ScreenRect &) const = default;
};

struct ScreenSize {
    int width = 0, height = 0;
    bool operator==(const ScreenSize &) const = default;
};

ScreenRect common(const ScreenRect &a, const ScreenRect &b);
ScreenRect around(const ScreenRect &a, const ScreenRect &b); // an empty one does not count

class ScreenChanges
{
  public:
    // Returns the places that differ from those of the call before, without overlap; everything at the first
    // call, after forget(), and after a change of the size. `fresh` are textures with another picture.
    std::vector<ScreenRect> take(const ImDrawData &data, ScreenSize size,
                                 const std::vector<ImTextureID> &fresh);
    void forget() { lists_.clear(); } // the window has lost what it showed

  private:
    struct List {
        std::vector<ImDrawCmd> commands;
        std::vector<ImDrawVert> vertices;
        std::vector<ImDrawIdx> indices;
    };
    static List copy_of(const ImDrawList &list);

    ScreenSize size_;
    std::vector<List> lists_; // of the screen before
};

// Changes the commands so that they draw at these places only. Textures in `pictures` have no transparent
// pixel, so nothing is drawn under them.
void keep_places(ImDrawData &data, ScreenSize size, const std::vector<ScreenRect> &places,
                 const std::vector<ImTextureID> &pictures);

} // namespace crn
