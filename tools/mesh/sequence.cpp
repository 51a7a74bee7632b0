#include "tools/mesh/sequence.hpp"
#include "host/base/number_text.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace crn::mesh
{

namespace
{

namespace fs = std::filesystem;
using Vec3 = Eigen::Vector3d;

constexpr size_t triangles_max = 4'000'000;

/* Holds the content of one frame's file: all its vertices, and the faces of each body. */
struct Frame {
    struct Group {
        std::string name;
        std::vector<std::array<uint32_t, 3>> triangles;
    };
    std::vector<Vec3> vertices;
    std::vector<Group> groups;
};

[[noreturn]] void fail(const fs::path &file, size_t line, const std::string &what)
{
    throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + what);
}

/* Reads the vertex number of a face's corner, in the form "7", "7/1", "7//3", or "-1" for the latest
 * vertex. */
uint32_t corner(const std::string &word, size_t vertices, const fs::path &file, size_t line)
{
    long long number = 0;
    try {
        size_t used = 0;
        number = std::stoll(word, &used);
        if (used < word.size() && word[used] != '/') number = 0;
    } catch (const std::exception &) {
        number = 0;
    }
    const long long index = number < 0 ? static_cast<long long>(vertices) + number : number - 1;
    if (number == 0 || index < 0 || index >= static_cast<long long>(vertices))
        fail(file, line,
             "'" + word + "' names no vertex; there are " + std::to_string(vertices) + " up to here");
    return static_cast<uint32_t>(index);
}

Vec3 vertex(std::istringstream &words, const fs::path &file, size_t line)
{
    Vec3 at;
    if (!(words >> at.x() >> at.y() >> at.z()) || !at.allFinite())
        fail(file, line, "a vertex needs three finite numbers");
    return at;
}

std::vector<std::string> lines_of(const fs::path &file)
{
    std::ifstream stream(file);
    if (!stream) throw std::runtime_error(file.string() + ": cannot be read");
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

void add_face(Frame &frame, std::istringstream &words, const fs::path &file, size_t line)
{
    std::vector<uint32_t> corners;
    for (std::string word; words >> word;) corners.push_back(corner(word, frame.vertices.size(), file, line));
    if (corners.size() < 3) fail(file, line, "a face needs at least three corners");
    if (frame.groups.empty()) frame.groups.push_back({"body", {}});
    for (size_t i = 1; i + 1 < corners.size(); i++)
        frame.groups.back().triangles.push_back({corners[0], corners[i], corners[i + 1]});
    if (frame.groups.back().triangles.size() > triangles_max)
        fail(file, line, "more than 4 million triangles");
}

Frame read_frame(const fs::path &file)
{
    const std::vector<std::string> lines = lines_of(file);
    const bool has_objects =
        std::any_of(lines.begin(), lines.end(), [](const std::string &l) { return l.rfind("o ", 0) == 0; });
    Frame frame;
    for (size_t i = 0; i < lines.size(); i++) {
        std::istringstream words(lines[i]);
        std::string key, name;
        if (!(words >> key)) continue;
        if (key == "v") frame.vertices.push_back(vertex(words, file, i + 1));
        if (key == "f") add_face(frame, words, file, i + 1);
        if (key == (has_objects ? "o" : "g")) {
            words >> name;
            frame.groups.push_back({name, {}});
        }
    }
    std::erase_if(frame.groups, [](const Frame::Group &group) { return group.triangles.empty(); });
    if (frame.groups.empty()) throw std::runtime_error(file.string() + ": has no faces");
    return frame;
}

std::vector<fs::path> obj_files(const fs::path &folder)
{
    if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": no such folder");
    std::vector<fs::path> files;
    for (const fs::directory_entry &entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".obj") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    if (files.size() != sequence_frames)
        throw std::runtime_error(folder.string() + ": holds " + std::to_string(files.size()) +
                                 " .obj files; a beat has " + std::to_string(sequence_frames) + " frames");
    return files;
}

/* Checks that a frame of the sequence has the same bodies, faces and number of vertices as the first
 * frame. */
void compare(const Frame &first, const Frame &other, const fs::path &first_file, const fs::path &file)
{
    const std::string start = file.string() + ": ", end = " than " + first_file.filename().string() +
                                                          "; every frame needs the same topology";
    if (other.groups.size() != first.groups.size())
        throw std::runtime_error(start + "has other bodies" + end);
    for (size_t i = 0; i < first.groups.size(); i++) {
        const Frame::Group &a = first.groups[i], &b = other.groups[i];
        if (a.name != b.name)
            throw std::runtime_error(start + "has another body (" + b.name + ", not " + a.name + ")" + end);
        if (a.triangles.size() != b.triangles.size())
            throw std::runtime_error(start + b.name + " has " + std::to_string(b.triangles.size()) +
                                     ", not " + std::to_string(a.triangles.size()) + " triangles: other" +
                                     end);
        const auto differs = std::mismatch(a.triangles.begin(), a.triangles.end(), b.triangles.begin());
        if (differs.first != a.triangles.end())
            throw std::runtime_error(start + b.name + ", triangle " +
                                     std::to_string(differs.first - a.triangles.begin()) +
                                     " has other corners" + end);
    }
    if (other.vertices.size() != first.vertices.size())
        throw std::runtime_error(start + "has " + std::to_string(other.vertices.size()) + ", not " +
                                 std::to_string(first.vertices.size()) + " vertices: others" + end);
}

/* Stores in each body the vertices that its faces use, in the order of their first use. */
std::vector<SequenceBody> split(const std::vector<Frame> &frames)
{
    std::vector<SequenceBody> bodies;
    for (const Frame::Group &group : frames[0].groups) {
        SequenceBody body{group.name, {}, {}};
        std::map<uint32_t, uint32_t> renamed;
        std::vector<uint32_t> used;
        for (std::array<uint32_t, 3> triangle : group.triangles) {
            for (uint32_t &corner : triangle) {
                const auto [place, is_new] = renamed.emplace(corner, static_cast<uint32_t>(used.size()));
                if (is_new) used.push_back(corner);
                corner = place->second;
            }
            body.triangles.push_back(triangle);
        }
        for (const Frame &frame : frames) {
            std::vector<Vec3> vertices;
            for (uint32_t vertex : used) vertices.push_back(frame.vertices[vertex]);
            body.frames.push_back(std::move(vertices));
        }
        bodies.push_back(std::move(body));
    }
    return bodies;
}

Vec3 normal_of(const SequenceBody &body, size_t frame, size_t triangle)
{
    const auto &t = body.triangles[triangle];
    const std::vector<Vec3> &v = body.frames[frame];
    return (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
}

SequenceReport check_body(const SequenceBody &body)
{
    /* If the last frame of a heartbeat does not continue to the first frame, the vertices move much farther
     * between these two frames than between any other neighbouring frames. */
    constexpr double JUMP = 2.0;
    SequenceReport report;
    report.body = body.name;
    report.vertices = body.frames[0].size();
    report.triangles = body.triangles.size();
    for (size_t frame = 0; frame < body.frames.size(); frame++) {
        const size_t next = (frame + 1) % body.frames.size();
        double &step = next == 0 ? report.wrap_max : report.step_max;
        for (size_t i = 0; i < report.vertices; i++)
            step = std::max(step, (body.frames[next][i] - body.frames[frame][i]).norm());
        for (size_t t = 0; t < report.triangles; t++) {
            if (normal_of(body, frame, t).dot(normal_of(body, next, t)) >= 0.0) continue;
            if (report.inverted++ > 0) continue;
            report.inverted_frame = next;
            report.inverted_triangle = t;
        }
    }
    if (report.inverted > 0)
        report.fault = std::to_string(report.inverted) + " inverted faces; the first is triangle " +
                       std::to_string(report.inverted_triangle) + ", turned in frame " +
                       std::to_string(report.inverted_frame);
    else if (report.wrap_max > JUMP * report.step_max)
        report.fault = "jumps by " + crn::number_text(report.wrap_max, 3) +
                       " from the last frame to the first, elsewhere by at most " +
                       crn::number_text(report.step_max, 3) + " per frame: is a frame missing at one end?";
    return report;
}

} // namespace

Sequence read_sequence(const fs::path &folder)
{
    const std::vector<fs::path> files = obj_files(folder);
    Sequence sequence;
    std::vector<Frame> frames;
    for (const fs::path &file : files) {
        frames.push_back(read_frame(file));
        compare(frames.front(), frames.back(), files.front(), file);
        sequence.files.push_back(file.string());
    }
    sequence.bodies = split(frames);
    return sequence;
}

std::vector<SequenceReport> check_sequence(const Sequence &sequence)
{
    std::vector<SequenceReport> reports;
    for (const SequenceBody &body : sequence.bodies) reports.push_back(check_body(body));
    return reports;
}

} // namespace crn::mesh
