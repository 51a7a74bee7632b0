// Tests which parts of a window are drawn again: nothing if nothing has changed, and otherwise every part
// that has changed, moved or disappeared. If only these parts are drawn, the window must have the same pixels
// as one that is drawn completely.
#include "host/suite/screen_changes.hpp"
#include <array>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::ScreenRect;

constexpr crn::ScreenSize size{64, 48};
const auto letters = reinterpret_cast<ImTextureID>(std::uintptr_t{1});
const auto picture = reinterpret_cast<ImTextureID>(std::uintptr_t{2});

struct Context {
    Context()
    {
        ImGui::CreateContext();
        ImGuiIO &io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = {static_cast<float>(size.width), static_cast<float>(size.height)};
        unsigned char *bytes = nullptr;
        int width = 0, height = 0;
        io.Fonts->GetTexDataAsAlpha8(&bytes, &width, &height);
        io.Fonts->SetTexID(letters);
    }
    ~Context() { ImGui::DestroyContext(); }
    Context(const Context &) = delete;
    Context &operator=(const Context &) = delete;
};

using Draw = std::function<void(ImDrawList &)>;

ImDrawData &composed(const Draw &draw)
{
    ImGui::NewFrame();
    draw(*ImGui::GetBackgroundDrawList());
    ImGui::Render();
    return *ImGui::GetDrawData();
}

std::vector<ScreenRect> changes(crn::ScreenChanges &screen, const Draw &draw,
                                const std::vector<ImTextureID> &fresh = {})
{
    return screen.take(composed(draw), size, fresh);
}

bool covers(const std::vector<ScreenRect> &places, const ScreenRect &wanted)
{
    for (int y = wanted.top; y < wanted.bottom; ++y)
        for (int x = wanted.left; x < wanted.right; ++x) {
            int times = 0;
            for (const ScreenRect &place : places) times += !common(place, {x, y, x + 1, y + 1}).is_empty();
            if (times != 1) return false;
        }
    return true;
}

Draw box(float left, float top, ImU32 colour = IM_COL32(200, 0, 0, 255))
{
    return [=](ImDrawList &list) { list.AddRectFilled({left, top}, {left + 8.0f, top + 6.0f}, colour); };
}

void nothing_is_drawn_if_nothing_has_changed(void **)
{
    const Context context;
    crn::ScreenChanges screen;
    changes(screen, box(4, 4));
    assert_true(changes(screen, box(4, 4)).empty());
}

void the_first_screen_is_drawn_wholly(void **)
{
    const Context context;
    crn::ScreenChanges screen;
    assert_true(covers(changes(screen, box(4, 4)), {0, 0, size.width, size.height}));
}

void a_window_that_lost_its_picture_is_drawn_wholly(void **)
{
    const Context context;
    crn::ScreenChanges screen;
    changes(screen, box(4, 4));
    screen.forget();
    assert_true(covers(changes(screen, box(4, 4)), {0, 0, size.width, size.height}));
}

void the_old_and_the_new_place_of_a_box_are_drawn(void **)
{
    const Context context;
    crn::ScreenChanges screen;
    changes(screen, box(4, 4));
    const std::vector<ScreenRect> places = changes(screen, box(40, 30));
    assert_true(covers(places, {4, 4, 12, 10}));
    assert_true(covers(places, {40, 30, 48, 36}));
}

void the_place_of_a_box_that_is_gone_is_drawn(void **)
{
    const Context context;
    crn::ScreenChanges screen;
    changes(screen, [](ImDrawList &list) {
        box(4, 4)(list);
        box(40, 30)(list);
    });
    assert_true(covers(changes(screen, box(4, 4)), {40, 30, 48, 36}));
}

void only_the_box_with_another_colour_is_drawn(void **)
{
    const Context context;
    crn::ScreenChanges screen;
    const auto both = [](ImU32 colour) {
        return [colour](ImDrawList &list) {
            box(4, 4)(list);
            box(40, 30, colour)(list);
        };
    };
    changes(screen, both(IM_COL32(0, 200, 0, 255)));
    const std::vector<ScreenRect> places = changes(screen, both(IM_COL32(0, 0, 200, 255)));
    assert_int_equal(places.size(), 1);
    assert_true((places[0] == ScreenRect{40, 30, 48, 36}));
}

void a_texture_with_another_picture_is_drawn(void **)
{
    const Context context;
    crn::ScreenChanges screen;
    const auto image = [](ImDrawList &list) { list.AddImage(picture, {10, 10}, {30, 30}); };
    changes(screen, image);
    assert_true(changes(screen, image).empty());
    assert_true(covers(changes(screen, image, {picture}), {10, 10, 30, 30}));
}

// Simulates a window with one number per pixel: drawing over a pixel changes its number, and an opaque
// picture replaces it.
using Pixels = std::array<std::uint32_t, std::size_t{size.width} * size.height>;

void paint(Pixels &pixels, const ImDrawData &data, std::uint32_t shown)
{
    for (int l = 0; l < data.CmdListsCount; ++l) {
        const ImDrawList &list = *data.CmdLists[l];
        for (const ImDrawCmd &command : list.CmdBuffer) {
            const int left = static_cast<int>(command.ClipRect.x),
                      width = static_cast<int>(command.ClipRect.z - command.ClipRect.x);
            const int below = static_cast<int>(static_cast<float>(size.height) - command.ClipRect.w);
            const int height = static_cast<int>(command.ClipRect.w - command.ClipRect.y);
            for (unsigned i = 0; i + 6 <= command.ElemCount; i += 6) {
                const auto corner = [&](unsigned k) -> const ImDrawVert & {
                    const ImDrawIdx index = list.IdxBuffer[static_cast<int>(command.IdxOffset + i + k)];
                    return list.VtxBuffer[static_cast<int>(command.VtxOffset + index)];
                };
                const ImVec2 low = corner(0).pos, high = corner(2).pos;
                for (int y = 0; y < size.height; ++y)
                    for (int x = 0; x < size.width; ++x) {
                        const float fx = static_cast<float>(x) + 0.5f, fy = static_cast<float>(y) + 0.5f;
                        const int up = size.height - 1 - y;
                        const bool is_in = fx >= low.x && fx < high.x && fy >= low.y && fy < high.y;
                        if (!is_in || x < left || x >= left + width || up < below || up >= below + height)
                            continue;
                        std::uint32_t &pixel = pixels[static_cast<std::size_t>(y * size.width + x)];
                        pixel = command.TextureId == picture ? shown : pixel * 31u + corner(0).col;
                    }
            }
        }
    }
}

void the_parts_have_the_same_pixels_as_the_whole(void **)
{
    const Context context;
    crn::ScreenChanges screen;
    std::mt19937 chance(1);
    const auto some = [&](int least, int most) {
        return static_cast<float>(least +
                                  static_cast<int>(chance() % static_cast<unsigned>(most - least + 1)));
    };
    struct Box {
        float left, top, width, height;
        ImU32 colour;
        bool is_picture;
    };
    std::vector<Box> boxes;
    const auto any_box = [&] {
        return Box{some(-4, 60) + 0.3f,
                   some(-4, 44),
                   some(1, 30),
                   some(1, 24) + 0.6f,
                   IM_COL32(chance() % 200, 0, 0, 255),
                   chance() % 3 == 0};
    };
    Pixels kept{};
    std::uint32_t shown = 1;
    for (int frame = 0; frame < 400; ++frame) {
        if (boxes.size() < 3 || (boxes.size() < 12 && chance() % 4 == 0)) boxes.push_back(any_box());
        if (chance() % 9 == 0) boxes.erase(boxes.begin());
        if (chance() % 2 == 0 && !boxes.empty()) boxes[chance() % boxes.size()] = any_box();
        const bool is_fresh = chance() % 3 == 0;
        if (is_fresh) ++shown;
        ImDrawData &data = composed([&](ImDrawList &list) {
            list.PushClipRect({2.4f, 1.7f}, {60.2f, 45.9f});
            for (const Box &b : boxes) {
                const ImVec2 low{b.left, b.top}, high{b.left + b.width, b.top + b.height};
                if (b.is_picture)
                    list.AddImage(picture, low, high);
                else
                    list.AddRectFilled(low, high, b.colour);
            }
            list.PopClipRect();
        });
        Pixels whole{};
        paint(whole, data, shown);
        const std::vector<ScreenRect> places = screen.take(
            data, size, is_fresh ? std::vector<ImTextureID>{picture} : std::vector<ImTextureID>{});
        keep_places(data, size, places, {picture});
        for (const ScreenRect &place : places)
            for (int y = place.top; y < place.bottom; ++y)
                for (int x = place.left; x < place.right; ++x)
                    kept[static_cast<std::size_t>(y * size.width + x)] = 0;
        paint(kept, data, shown);
        for (std::size_t i = 0; i < whole.size(); ++i) assert_int_equal(kept[i], whole[i]);
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_drawn_if_nothing_has_changed),
        cmocka_unit_test(the_first_screen_is_drawn_wholly),
        cmocka_unit_test(a_window_that_lost_its_picture_is_drawn_wholly),
        cmocka_unit_test(the_old_and_the_new_place_of_a_box_are_drawn),
        cmocka_unit_test(the_place_of_a_box_that_is_gone_is_drawn),
        cmocka_unit_test(only_the_box_with_another_colour_is_drawn),
        cmocka_unit_test(a_texture_with_another_picture_is_drawn),
        cmocka_unit_test(the_parts_have_the_same_pixels_as_the_whole),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
