// The program `importers` gives files to the file readers of this project's programs. For each file, the
// program prints one line of JSON that describes the content read from the file. The script importers.py
// reads the same file with a second, strict reader, and compares the two results (docs/testing.md).
//   importers seeds FOLDER          writes valid scans and centrelines, from which mutations begin
//   importers read < LIST           reads a line "KIND<tab>FILE" each; KIND is mesh, toml, scan or line
#include "host/base/toml.hpp"
#include "host/base/version.hpp"
#include "tools/centreline/formats.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include "tools/mesh/files/mesh_file.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <sys/resource.h>

namespace
{

using nlohmann::json;

json mesh(const std::string &file)
{
    std::size_t faces = 0, other = 0;
    double sum = 0, low = INFINITY, high = -INFINITY;
    for (const crn::bake::MeshPiece &piece : crn::bake::read_mesh_file(file, {})) {
        faces += piece.triangles.size();
        other += piece.other;
        for (const auto &triangle : piece.triangles)
            for (const std::uint32_t corner : triangle)
                for (int k = 0; k < 3; ++k) {
                    const double value = double(piece.vertices.at(corner)[static_cast<std::size_t>(k)]);
                    sum += value * (k + 1);
                    low = std::min(low, value), high = std::max(high, value);
                }
    }
    return {{"faces", faces}, {"other", other}, {"sum", sum}, {"low", low}, {"high", high}};
}

struct TomlSums {
    std::size_t keys = 0, letters = 0, values = 0;
    double sum = 0;

    void add(const toml::node &node)
    {
        if (const toml::table *table = node.as_table()) {
            for (const auto &[key, value] : *table) {
                ++keys;
                letters += key.length();
                add(value);
            }
        } else if (const toml::array *array = node.as_array()) {
            for (const toml::node &value : *array) add(value);
        } else {
            ++values;
            if (const auto *text = node.as_string()) letters += text->get().size();
            if (const auto *whole = node.as_integer()) sum += static_cast<double>(whole->get());
            if (const auto *number = node.as_floating_point())
                if (std::isfinite(number->get())) sum += number->get();
        }
    }
};

json text(const std::string &file)
{
    std::ostringstream content;
    content << std::ifstream(file, std::ios::binary).rdbuf();
    const toml::table table = crn::parse_toml(content.str(), file);
    TomlSums sums;
    sums.add(table);
    return {{"keys", sums.keys}, {"letters", sums.letters}, {"values", sums.values}, {"sum", sums.sum}};
}

json scan(const std::string &file)
{
    const crn::ct::Volume volume = crn::ct::read_volume(file);
    double sum = 0;
    for (const float value : volume.hu) sum += double(value);
    return {{"size", volume.size},
            {"spacing_mm", {volume.spacing_mm.x(), volume.spacing_mm.y(), volume.spacing_mm.z()}},
            {"sum", sum}};
}

json line(const std::string &file)
{
    const crn::centreline::Tree tree = crn::centreline::read_tree(file);
    double sum = 0, radii = 0;
    std::size_t spheres = 0;
    for (const crn::centreline::Branch &branch : tree.branches)
        for (const crn::centreline::Sphere &sphere : branch.spheres) {
            sum += sphere.centre_mm.dot(Eigen::Vector3d(1, 2, 3));
            radii += sphere.radius_mm;
            ++spheres;
        }
    return {{"branches", tree.branches.size()}, {"spheres", spheres}, {"sum", sum}, {"radii", radii}};
}

long MiB_of(int who)
{
    struct rusage usage {
    };
    ::getrusage(who, &usage);
    return usage.ru_maxrss >> 10;
}

json understood(const std::string &kind, const std::string &file)
{
    const auto began = std::chrono::steady_clock::now();
    json answer;
    try {
        answer = kind == "mesh"   ? mesh(file)
                 : kind == "toml" ? text(file)
                 : kind == "scan" ? scan(file)
                                  : line(file);
        answer["ok"] = true;
    } catch (const std::exception &fault) {
        answer = {{"ok", false}, {"message", fault.what()}};
    }
    answer["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    answer["MiB"] = std::max(MiB_of(RUSAGE_SELF), MiB_of(RUSAGE_CHILDREN)); // of the largest file so far
    return answer;
}

void write_seeds(const std::filesystem::path &folder)
{
    crn::ct::Volume volume;
    volume.size = {7, 9, 5};
    volume.spacing_mm = {0.53, 0.6, 1};
    volume.origin_mm = {-10, 20, 30};
    for (std::size_t i = 0; i < volume.count(); ++i) volume.hu.push_back(static_cast<float>(i) - 200);
    for (const char *name : {"seed.nrrd", "seed.mha", "seed.nii", "seed.nii.gz", "series"})
        crn::ct::write_volume(volume, folder / name);
    crn::centreline::Tree tree;
    tree.branches.resize(2);
    for (int i = 0; i < 6; ++i)
        tree.branches[0].spheres.push_back({{0, 10.0 * i, 0.5 * i}, 4.0 - 0.1 * i, 120});
    tree.branches[0].name = "trunk";
    tree.branches[1] = {"side", 0, 3, {tree.branches[0].spheres[3]}};
    for (int i = 1; i < 5; ++i) tree.branches[1].spheres.push_back({{6.0 * i, 30, 1.5}, 2.0, 80, i == 2});
    for (const char *name : {"seed.csv", "seed.vtp", "seed.mrk.json", "seed_line.obj"})
        crn::centreline::write_tree(folder / name, tree);
}

} // namespace

int main(int argc, char **argv)
try {
    const std::string command = argc > 1 ? argv[1] : "";
    if (command == "seeds" && argc == 3) {
        write_seeds(argv[2]);
        return 0;
    }
    if (command == "--version") {
        std::printf("%s\n", crn::version_of("importers").c_str());
        return 0;
    }
    if (command != "read" || argc != 2) {
        std::fprintf(stderr, "usage: importers seeds FOLDER | importers read < LIST\n");
        return 2;
    }
    for (std::string row; std::getline(std::cin, row);) {
        const std::size_t tab = std::min(row.find('\t'), row.size() - 1);
        const json answer = understood(row.substr(0, tab), row.substr(tab + 1));
        std::printf("%s\n", answer.dump(-1, ' ', true, json::error_handler_t::replace).c_str());
        std::fflush(stdout);
    }
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "importers: %s\n", error.what());
    return 1;
}
