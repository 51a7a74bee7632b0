#include "tools/lab/ct/arteries/scan_copy.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <nlohmann/json.hpp>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

constexpr const char *scan_name = "scan.ct", *notes_name = "scan.json";

LabelFiles label_files(const fs::path &folder)
{
    return {folder / "labels.nii.gz", folder / "labels.csv"};
}

} // namespace

CtVolume ct_of(const Volume &scan)
{
    CtVolume ct;
    ct.size = {scan.size[0], scan.size[2], scan.size[1]};
    ct.spacing_mm = {scan.spacing_mm[0], scan.spacing_mm[2], scan.spacing_mm[1]};
    // The scan's rows go to the back, the scene's to the front.
    ct.first_mm = scan.scene({0.0, scan.size[1] - 1.0, 0.0});
    ct.permille.resize(ct.count());
    for (int k = 0; k < scan.size[2]; ++k)
        for (int j = 0; j < scan.size[1]; ++j)
            for (int i = 0; i < scan.size[0]; ++i)
                ct.permille[ct.index(i, k, scan.size[1] - 1 - j)] = static_cast<std::uint16_t>(std::clamp(
                    scan.hu[scan.at(i, j, k)] + 1000.5f, 0.0f, static_cast<float>(ct_permille_max)));
    return ct;
}

Volume volume_of(const CtVolume &ct)
{
    Volume scan;
    scan.size = {ct.size[0], ct.size[2], ct.size[1]};
    scan.spacing_mm = {ct.spacing_mm[0], ct.spacing_mm[2], ct.spacing_mm[1]};
    const Eigen::Vector3d front(ct.first_mm.x(), ct.first_mm.y(),
                                ct.first_mm.z() + (ct.size[2] - 1) * ct.spacing_mm[2]);
    scan.origin_mm = lps_from_scene(front);
    scan.hu.resize(scan.count());
    for (int k = 0; k < scan.size[2]; ++k)
        for (int j = 0; j < scan.size[1]; ++j)
            for (int i = 0; i < scan.size[0]; ++i)
                scan.hu[scan.at(i, j, k)] =
                    static_cast<float>(ct.permille[ct.index(i, k, scan.size[1] - 1 - j)]) - 1000.0f;
    return scan;
}

bool is_copy(const fs::path &file)
{
    return file.filename() == scan_name;
}

ScanCopy read_copy(const fs::path &file)
{
    ScanCopy copy;
    CtVolume ct;
    std::string error;
    if (!read_ct_volume(file.string(), ct, error)) throw Fault(error);
    copy.scan = volume_of(ct);
    copy.scan.name = file.string();
    try {
        const nlohmann::json text =
            nlohmann::json::parse(read_text_file((file.parent_path() / notes_name).string()), nullptr, false);
        if (text.is_object() && text.contains("notes"))
            for (const auto &note : text["notes"])
                if (note.is_string()) copy.notes.push_back(note.get<std::string>());
    } catch (const FileError &) { // without notes the scan is the same
    }
    return copy;
}

Volume keep_copy(const Volume &scan, const fs::path &folder, Steps &steps)
{
    const CtVolume ct = ct_of(scan);
    Volume kept = volume_of(ct);
    kept.name = scan.name;
    const std::string inputs = "2 " + checksum(kept);
    const std::vector<fs::path> files = {folder / scan_name, folder / notes_name};
    if (!steps.has("scan", inputs, files) && fs::exists(folder / scan_name) &&
        fs::exists(folder / "clicks.toml"))
        throw Fault((folder / "clicks.toml").string() +
                    ": holds clicks for another scan: give another folder, or remove this file");
    if (!steps.is_done("scan", inputs, files)) {
        const nlohmann::json text = {{"notes", scan.notes}};
        write_whole_file((folder / notes_name).string(), text.dump(2) + "\n");
        write_ct_volume((folder / scan_name).string(), ct);
        steps.finish("scan", inputs);
    }
    return kept;
}

std::optional<LabelFiles> kept_labels(const fs::path &folder)
{
    const LabelFiles files = label_files(folder);
    if (fs::exists(files.map) && fs::exists(files.names)) return files;
    return std::nullopt;
}

void keep_labels(const LabelMap &labels, const fs::path &map, const fs::path &folder)
{
    std::error_code ignored;
    if (fs::equivalent(map, label_files(folder).map, ignored)) return;
    std::string table = "id,structure\n";
    for (const auto &[number, name] : labels.names) {
        std::string plain = name;
        std::replace_if(
            plain.begin(), plain.end(), [](char letter) { return letter == ',' || letter == '"'; }, '_');
        table += std::to_string(number) + "," + plain + "\n";
    }
    write_whole_file(label_files(folder).names.string(), table);
    write_volume(labels.volume, label_files(folder).map);
}

void forget_labels(const fs::path &folder)
{
    std::error_code ignored;
    fs::remove(label_files(folder).map, ignored);
    fs::remove(label_files(folder).names, ignored);
}

} // namespace crn::ct
