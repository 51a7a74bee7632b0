#include "tools/lab/ct/review/patient_folder.hpp"
#include "host/base/text.hpp"
#include "tools/centreline/formats.hpp"
#include <algorithm>
#include <nlohmann/json.hpp>

namespace crn::ct
{

namespace
{

std::vector<std::string> lines_in(const nlohmann::json &report, const char *key)
{
    std::vector<std::string> lines;
    if (report.contains(key) && report[key].is_array())
        for (const nlohmann::json &line : report[key])
            if (line.is_string()) lines.push_back(line.get<std::string>());
    return lines;
}

nlohmann::json object_in(const std::filesystem::path &file)
{
    const nlohmann::json read = nlohmann::json::parse(read_text_file(file.string()), nullptr, false);
    if (!read.is_object()) throw std::runtime_error(file.string() + ": is no JSON object: make it again");
    return read;
}

} // namespace

bool PatientFolder::look()
{
    bool has_changed = false;
    for (Watched &watched : watched_) {
        std::error_code none;
        const auto time = std::filesystem::last_write_time(file(watched.name), none);
        const bool is_there = !none;
        if (is_there == watched.is_there && (!is_there || time == watched.time)) continue;
        watched.is_there = is_there;
        watched.time = time;
        has_changed = true;
        watched.trouble.clear();
        try {
            read(watched.name);
        } catch (const std::exception &error) {
            watched.trouble = error.what();
        }
    }
    trouble.clear();
    for (const Watched &watched : watched_)
        if (trouble.empty()) trouble = watched.trouble;
    return has_changed;
}

void PatientFolder::read(const std::string &name)
{
    const std::filesystem::path path = file(name.c_str());
    const bool is_there = std::filesystem::exists(path);
    if (name == "scan.ct") {
        scan = {};
        std::string error;
        if (is_there && !read_ct_volume(path.string(), scan, error)) throw std::runtime_error(error);
    } else if (name == "lumen.ply") {
        lumen = {};
        bake::MeshText text;
        text.file = path;
        text.placement.unit = "mm";
        if (is_there) lumen = bake::load_mesh(text);
    } else if (name == "tree.csv") {
        tree = {};
        if (is_there) tree = centreline::read_tree(path);
    } else if (name == "report.json") {
        const nlohmann::json report = is_there ? object_in(path) : nlohmann::json::object();
        check = lines_in(report, "check");
        assumed = lines_in(report, "assumed");
        facts = lines_in(report, "facts");
    } else {
        done_.clear();
        const nlohmann::json steps = is_there ? object_in(path) : nlohmann::json::object();
        for (auto step = steps.begin(); step != steps.end(); ++step) done_.push_back(step.key());
    }
}

std::vector<ReviewStep> PatientFolder::steps() const
{
    std::vector<ReviewStep> steps = {
        {"scan", "The scan is read and checked"},       {"arteries", "Aorta and arteries without bone"},
        {"picture", "The body, for the X-ray picture"}, {"lumen", "The lumen of the arteries"},
        {"tree", "Centrelines and names of branches"},  {"scene", "The scene for the session"}};
    for (ReviewStep &step : steps)
        step.is_done = std::find(done_.begin(), done_.end(), step.name) != done_.end();
    return steps;
}

bool PatientFolder::has_scene() const
{
    return std::find(done_.begin(), done_.end(), "scene") != done_.end() &&
           std::filesystem::exists(file("patient.scene"));
}

} // namespace crn::ct
