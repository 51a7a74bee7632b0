// Tests that files are found by their names. The user's own files come before those that ship with the
// program, a misspelt name gets a suggestion, and a path is not changed.
#include "host/base/examples.hpp"
#include "host/base/tests/folder.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <tuple>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

std::string error_for(const ExampleKind &kind, const std::string &word)
{
    try {
        return "accepted as " + named_path(kind, word);
    } catch (const std::runtime_error &error) {
        return error.what();
    }
}

// In this test the user's own files are in the test's folder.
struct Own {
    Own() { setenv("XDG_DATA_HOME", files.path.c_str(), 1); }
    ~Own() { unsetenv("XDG_DATA_HOME"); }
    std::string write(const std::string &kind, const std::string &name)
    {
        const std::filesystem::path folder = std::filesystem::path(files.path) / "cournand" / kind;
        std::filesystem::create_directories(folder);
        std::ofstream(folder / name) << "x";
        return (folder / name).string();
    }
    tests::Folder files{"examples"};
};

} // namespace

static void a_name_finds_the_file_that_comes_with_the_program(void **)
{
    const Own own;
    for (const auto &[kind, name, path] :
         {std::tuple{instrument_files, "j_wire", "shared/examples/instruments/j_wire.toml"},
          std::tuple{stent_files, "coronary_3_0x18", "shared/examples/stents/coronary_3_0x18.toml"},
          std::tuple{session_files, "demo", "shared/examples/sessions/demo.session"},
          std::tuple{anatomy_files, "heart", "shared/examples/anatomies/heart.toml"}}) {
        const std::string found = named_path(kind, name);
        if (!std::filesystem::equivalent(found, path)) fail_msg("%s: %s", name, found.c_str());
    }
}

static void a_users_own_file_comes_first(void **)
{
    Own own;
    const std::string path = own.write("instruments", "j_wire.toml");
    assert_string_equal(named_path(instrument_files, "j_wire").c_str(), path.c_str());
    const std::string other = named_path(instrument_files, "bentson");
    if (!std::filesystem::equivalent(other, "shared/examples/instruments/bentson.toml"))
        fail_msg("%s", other.c_str());
}

static void a_relative_data_folder_is_ignored(void **)
{
    // By the XDG Base Directory Specification a relative path is invalid, and the program ignores it.
    setenv("XDG_DATA_HOME", "shared", 1);
    for (const std::filesystem::path &folder : example_folders(instrument_files))
        if (folder.string().starts_with("shared/cournand")) fail_msg("%s", folder.c_str());
    unsetenv("XDG_DATA_HOME");
}

static void a_preset_stays_behind_the_name(void **)
{
    const std::string path = named_path(instrument_files, "j_wire");
    assert_string_equal(named_path(instrument_files, "j_wire:vcsim3-fit").c_str(),
                        (path + ":vcsim3-fit").c_str());
}

static void a_path_stays_a_path(void **)
{
    for (const char *path : {"", "a/j_wire", "./j_wire", "j_wire.toml", "gone.session", "shared",
                             "a:b.session", "a:b/j_wire.toml"})
        assert_string_equal(named_path(instrument_files, path).c_str(), path);
}

static void a_misspelt_name_has_a_suggestion(void **)
{
    Own own;
    own.write("instruments", "my_wire.toml");
    own.write("instruments", "notes.txt");
    assert_string_equal(error_for(instrument_files, "j_wre").c_str(),
                        "there is no instrument 'j_wre', did you mean 'j_wire'?");
    const std::string said = error_for(instrument_files, "completely_different");
    if (said.find("known: ") == said.npos || said.find("my_wire") == said.npos ||
        said.find("notes") != said.npos)
        fail_msg("%s", said.c_str());
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_name_finds_the_file_that_comes_with_the_program),
        cmocka_unit_test(a_users_own_file_comes_first),
        cmocka_unit_test(a_relative_data_folder_is_ignored),
        cmocka_unit_test(a_preset_stays_behind_the_name),
        cmocka_unit_test(a_path_stays_a_path),
        cmocka_unit_test(a_misspelt_name_has_a_suggestion),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
