// Tests that scenes and recordings are found by their names. The shipped scene must be unpacked only once,
// and either completely or not at all.
#include "host/base/pending_file.hpp"
#include "host/base/tests/folder.hpp"
#include "host/base/text.hpp"
#include "host/cases/unpack.hpp"
#include "host/command/cli.hpp"
#include "host/command/names.hpp"
#include "host/command/start.hpp"
#include <algorithm>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
namespace fs = std::filesystem;

namespace
{

const char archive[] = "shared/examples/scenes/aorta.tar.xz";
const UnpackWatch goes_on = [](std::size_t, std::size_t) { return true; };

template <typename Call> std::string error_of(Call call)
{
    try {
        return "accepted as " + std::string(call());
    } catch (const std::runtime_error &error) {
        return error.what();
    }
}

void expect_text(const std::string &text, const std::string &wanted)
{
    if (text.find(wanted) == text.npos) fail_msg("'%s' is not in: %s", wanted.c_str(), text.c_str());
}

// A user whose folders are empty, in a current folder without out/.
struct User {
    User()
    {
        for (const char *name : {"XDG_DATA_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"})
            setenv(name, home.path.c_str(), 1);
    }
    ~User()
    {
        for (const char *name : {"XDG_DATA_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"}) unsetenv(name);
    }
    std::string write(const std::string &name, const std::string &bytes = "x") const
    {
        const fs::path path = fs::path(home.path) / "cournand" / name;
        fs::create_directories(path.parent_path());
        write_whole_file(path.string(), bytes);
        return path.string();
    }
    tests::Folder home{"names"};
};

} // namespace

static void the_scene_that_ships_is_unpacked_with_its_bodies(void **)
{
    const User user;
    const fs::path folder = fs::path(user.home.path) / "a" / "b";
    unpack_scene(archive, folder, goes_on);
    assert_true(fs::file_size(folder / "aorta.scene") > 1000000);
    assert_true(fs::file_size(folder / "aorta.bodies") > 1000000);
    assert_int_equal(std::distance(fs::directory_iterator(folder.parent_path()), fs::directory_iterator()),
                     1);
    unpack_scene(archive, folder, goes_on); // as a second program would at the same time
}

static void a_damaged_archive_leaves_nothing(void **)
{
    const User user;
    std::string bytes = read_text_file(archive);
    const std::string cut = user.write("cut.tar.xz", bytes.substr(0, bytes.size() / 2));
    bytes[bytes.size() / 2] ^= 1;
    const std::string flipped = user.write("flipped.tar.xz", bytes);
    const std::string empty = user.write("empty.tar.xz", "");
    for (const std::string &path : {cut, flipped, empty, user.home.path + "/gone.tar.xz"}) {
        const fs::path folder = fs::path(user.home.path) / "out" / "x";
        expect_text(error_of([&] { return unpack_scene(path, folder, goes_on), ""; }), "cannot be unpacked");
        assert_false(fs::exists(folder));
        std::error_code ignored;
        assert_true(fs::is_empty(folder.parent_path(), ignored) || ignored);
    }
}

static void a_cache_that_cannot_be_written_is_named(void **)
{
    const User user;
    const std::string file = user.write("file");
    expect_text(error_of([&] { return unpack_scene(archive, fs::path(file) / "x", goes_on), ""; }),
                "XDG_CACHE_HOME");
}

static void a_users_own_scene_comes_first(void **)
{
    const User user;
    const std::string own = user.write("scenes/aorta.scene");
    assert_string_equal(scene_path("aorta").c_str(), own.c_str());
    assert_string_equal(scene_path("./aorta").c_str(), "./aorta");
    assert_string_equal(scene_path("gone.scene").c_str(), "gone.scene");
    assert_string_equal(scene_path("").c_str(), "");
}

static void a_scene_that_is_not_there_has_a_suggestion_or_a_remedy(void **)
{
    const User user;
    assert_string_equal(error_of([] { return scene_path("aotra"); }).c_str(),
                        "there is no scene 'aotra', did you mean 'aorta'?");
    const std::string made = error_of([] { return scene_path("real_coronaries"); });
    if (!made.starts_with("accepted")) expect_text(made, "make coronary-real");
}

static void recordings_have_names_and_the_newest_is_last(void **)
{
    const User user;
    expect_text(error_of([] { return recording_path("last"); }), "no recording is kept");
    const std::string old = user.write("2026-01-01_10-00-00.rec"),
                      next = user.write("2026-01-01_10-00-00.2.rec");
    fs::last_write_time(old, fs::last_write_time(next) - std::chrono::hours(1));
    assert_string_equal(recording_path("last").c_str(), next.c_str());
    assert_string_equal(recording_path("2026-01-01_10-00-00").c_str(), old.c_str());
    assert_string_equal(recording_path("2026-01-01_10-00-00.2").c_str(), next.c_str());
    assert_string_equal(recording_path("out/x.rec").c_str(), "out/x.rec");
    expect_text(error_of([] { return recording_path("lsat"); }), "did you mean 'last'?");
    const std::string kept = kept_recording();
    assert_true(fs::path(kept).parent_path() == fs::path(old).parent_path() && !fs::exists(kept));
}

static void the_newest_twenty_recordings_are_kept(void **)
{
    const User user;
    const auto now = fs::file_time_type::clock::now();
    for (int i = 0; i < 25; ++i) // number 0 is the oldest
        fs::last_write_time(user.write("old_" + std::to_string(i) + ".rec"),
                            now - std::chrono::hours(25 - i));
    const fs::path folder = fs::path(kept_recording()).parent_path();
    assert_int_equal(kept_recording_files().size(), kept_recordings_max - 1); // one more comes
    assert_false(fs::exists(folder / "old_5.rec"));
    assert_true(fs::exists(folder / "old_6.rec") && fs::exists(folder / "old_24.rec"));
}

static void info_takes_a_name_of_any_kind(void **)
{
    const User user;
    user.write("2026-01-01_10-00-00.rec");
    for (const auto &[name, ending] :
         {std::pair{"j_wire", "j_wire.toml"}, std::pair{"demo", "demo.session"},
          std::pair{"renal_6_0x18", "renal_6_0x18.toml"}, std::pair{"last", "2026-01-01_10-00-00.rec"}})
        if (!any_path(name).ends_with(ending)) fail_msg("%s: %s", name, any_path(name).c_str());
    assert_true(any_path("j_wire:vcsim3-fit").ends_with("j_wire.toml:vcsim3-fit"));
    expect_text(error_of([] { return any_path("j_wrie"); }), "did you mean 'j_wire'?");
}

static void every_type_lists_its_names(void **)
{
    const User user;
    for (const auto &[type, name] :
         {std::pair{"SCENE", "heart"}, std::pair{"SCENE", "lad_pci"}, std::pair{"INSTRUMENT", "j_wire"},
          std::pair{"STENT", "renal_6_0x18"}, std::pair{"SESSION", "demo"}, std::pair{"SCENE", "aorta"},
          std::pair{"NAME", "aorta"}}) {
        const std::vector<std::string> names = names_of_type(type);
        if (std::find(names.begin(), names.end(), name) == names.end()) fail_msg("%s lacks %s", type, name);
    }
    assert_true(names_of_type("RECORDING").empty() && names_of_type("FILE").empty());
}

static void the_text_without_a_display_fits_a_screen(void **)
{
    const std::string text = start_text("build/bin/cournand");
    assert_true(std::count(text.begin(), text.end(), '\n') <= 23);
    expect_text(text, "    build/bin/cournand run demo\n");
    for (std::size_t at = 0, end = 0; at < text.size(); at = end + 1) {
        end = std::min(text.find('\n', at), text.size());
        assert_true(end - at <= 90);
    }
}

// Each word of the option --line must be the name of a file, or a number in the session's table of tools; any
// other word is wrong usage.
static void the_option_line_names_tools_of_the_table(void **)
{
    const std::vector<std::string> tools = {"a/wire.toml", "b/guide.toml:preset", "guide.toml", "x.toml"};
    const auto line = [&](const std::vector<std::string> &words) { return line_numbers(words, "", tools); };
    assert_true(line({"wire", "nothing", "3"}) == (LineNumbers{1, 0, 3}));
    assert_true(line_numbers({}, "", {"a/wire.toml"}).empty()); // all of them
    const auto error = [&](const std::vector<std::string> &words) {
        return error_of([&] { return std::to_string(line(words).size()); });
    };
    expect_text(error({}), "4 tools are named: say with --line");
    expect_text(error({"wir"}), "no tool 'wir'");
    expect_text(error({"wir"}), "wire");
    expect_text(error({"guide"}), "two tools 'guide': write 2 or 3");
    expect_text(error({"wire", "1"}), "names the tool 'wire' twice");
    expect_text(error({"nothing"}), "names no tool");
    expect_text(error({"1", "2", "3", "4"}), "at most 3 positions");
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_option_line_names_tools_of_the_table),
        cmocka_unit_test(the_scene_that_ships_is_unpacked_with_its_bodies),
        cmocka_unit_test(a_damaged_archive_leaves_nothing),
        cmocka_unit_test(a_cache_that_cannot_be_written_is_named),
        cmocka_unit_test(a_users_own_scene_comes_first),
        cmocka_unit_test(a_scene_that_is_not_there_has_a_suggestion_or_a_remedy),
        cmocka_unit_test(recordings_have_names_and_the_newest_is_last),
        cmocka_unit_test(the_newest_twenty_recordings_are_kept),
        cmocka_unit_test(info_takes_a_name_of_any_kind),
        cmocka_unit_test(every_type_lists_its_names),
        cmocka_unit_test(the_text_without_a_display_fits_a_screen),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
