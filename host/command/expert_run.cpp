#include "host/command/expert_run.hpp"
#include "firmware/core/core.h"
#include "host/base/digest.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/base/user_folders.hpp"
#include "host/cases/programs.hpp"
#include <filesystem>
#include <unistd.h>

namespace crn
{
namespace
{

namespace fs = std::filesystem;

std::string expert_key(const Case &lesson)
{
    Digest digest;
    digest.add(read_text_file(lesson.file));
    digest.add(read_text_file(lesson.expert));
    for (const std::string &tool : lesson.offered) digest.add(read_text_file(split_preset(tool).first));
    for (const std::string &stent : lesson.stents) digest.add(read_text_file(stent));
    digest.add(recipe_key(lesson.recipe));
    digest.add(std::to_string(int{CRN_CORE_VERSION}));
    return digest.hex();
}

} // namespace

std::string expert_recording(const Case &lesson, const std::function<bool()> &goes_on)
{
    if (cache_folder().empty())
        throw std::runtime_error("there is no folder for the expert's run: set HOME or XDG_CACHE_HOME");
    const fs::path folder = cache_folder() / "experts", file = folder / (expert_key(lesson) + ".rec");
    std::error_code failure;
    if (fs::exists(file, failure)) return file.string();
    fs::create_directories(folder, failure);
    const fs::path part = folder / (file.stem().string() + "." + std::to_string(::getpid()) + ".part.rec");
    const ProgramResult done = run_program({sibling_program("cournand"), "case", "play", lesson.file,
                                            "--script", "expert", "--record", part.string(), "--quiet"},
                                           goes_on);
    if (done.was_stopped || done.code != 0 || !fs::exists(part, failure)) {
        fs::remove(part, failure);
        if (done.was_stopped) throw SceneStopped("cancelled");
        throw std::runtime_error("the expert's run cannot be recorded: " + done.refused);
    }
    fs::rename(part, file, failure);
    if (failure) throw OutputError(file.string(), failure.value());
    return file.string();
}

} // namespace crn
