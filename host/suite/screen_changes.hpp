// Finds the rectangles in which the window differs from the frame drawn before, so that only these are drawn
// again. Without a graphics card, drawing one plain square as high as the window takes 6 ms of processor
// time.
//
//   ScreenChanges changes;
//   const std::vector<ScreenRect> places = changes.take(*ImGui::GetDrawData(), size, fresh);
//   keep_places(*ImGui::GetDrawData(), size, places, pictures);
//   clear these places; ImGui_ImplOpenGL3_RenderDrawData(...); show these places
//
// The redrawn rectangles have the same pixels as if the whole window were drawn.
#pragma once
#include <imgui.h>
#include <vector>

namespace crn
{

// Describes a rectangle of pixels, counted from the window's top left corner; column `right` and row `bottom`
// are outside it.
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
    // Returns the rectangles in which the window differs from that of the previous call; they do not overlap.
    // Returns the whole window at the first call, after forget(), and after a change of the size. `fresh`
    // lists the textures whose picture has changed since the previous call.
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

// Changes the drawing commands so that they draw only inside the rectangles `places`. The textures in
// `pictures` have no transparent pixels, so nothing is drawn under them.
void keep_places(ImDrawData &data, ScreenSize size, const std::vector<ScreenRect> &places,
                 const std::vector<ImTextureID> &pictures);

} // namespace crn
