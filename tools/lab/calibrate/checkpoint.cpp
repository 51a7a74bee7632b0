#include "tools/lab/calibrate/checkpoint.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "host/model/instrument.hpp"
#include <bit>
#include <cinttypes>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace crn::calibrate
{
namespace
{

constexpr const char *magic = "cournand-calibrate-checkpoint 1";

void put_number(std::string &text, double value)
{
    text += formatted(" %a", value);
}

void put_trials(std::string &text, const char *name, const std::vector<Trial> &trials)
{
    text += std::string(name) + " " + std::to_string(trials.size()) + "\n";
    for (const Trial &trial : trials) {
        for (const double share : trial.shares) put_number(text, share);
        put_number(text, trial.verdict.objective);
        put_number(text, trial.verdict.error_mm);
        put_number(text, trial.verdict.force_error);
        text += "\n";
    }
}

std::string head_text(std::uint64_t hash)
{
    return formatted("%s\nhash %016" PRIx64 "\n", magic, hash);
}

// Reads the words of a checkpoint one after the other.
struct Reader {
    const std::string &file;
    std::istringstream stream;

    [[noreturn]] void refuse() const
    {
        throw CheckpointError(file + ": is damaged; remove it, and the search starts anew");
    }
    void expect(const std::string &word)
    {
        std::string got;
        if (!(stream >> got) || got != word) refuse();
    }
    std::size_t count(std::size_t most)
    {
        std::size_t n = 0;
        if (!(stream >> n) || n > most) refuse();
        return n;
    }
    double number()
    {
        std::string word;
        if (!(stream >> word)) refuse();
        char *end = nullptr;
        const double value = std::strtod(word.c_str(), &end);
        if (*end != 0) refuse();
        return value;
    }
    std::vector<Trial> trials(const std::string &name, std::size_t parameter_count)
    {
        expect(name);
        std::vector<Trial> list(count(100'000'000));
        for (Trial &trial : list) {
            for (std::size_t i = 0; i < parameter_count; i++) trial.shares.push_back(number());
            trial.verdict.objective = number();
            trial.verdict.error_mm = number();
            trial.verdict.force_error = number();
        }
        return list;
    }
};

} // namespace

void Hash::add(std::string_view bytes)
{
    for (const char byte : bytes) value_ = (value_ ^ static_cast<unsigned char>(byte)) * 1099511628211u;
    value_ = (value_ ^ bytes.size()) * 1099511628211u; // the length makes "ab", "c" differ from "a", "bc"
}

void Hash::add(double value)
{
    char bytes[8];
    for (int i = 0; i < 8; i++) bytes[i] = static_cast<char>(std::bit_cast<std::uint64_t>(value) >> 8 * i);
    add(std::string_view(bytes, sizeof bytes));
}

void Hash::add_file(const std::filesystem::path &file)
{
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw CheckpointError(file.string() + ": cannot be read: is it there?");
    std::ostringstream bytes;
    bytes << stream.rdbuf();
    add(bytes.str());
}

std::uint64_t hash_of(const insertion::Case &c, const Evaluator &evaluator, const Judge &judge,
                      const SearchSettings &settings)
{
    Hash hash;
    hash.add_file(c.path_in(c.scene));
    const auto [instrument, preset] = split_preset(c.path_in(c.instrument).string());
    hash.add_file(instrument);
    hash.add(preset);
    for (const double number : {c.mouth_mm.x(), c.mouth_mm.y(), c.mouth_mm.z(), c.direction.x(),
                                c.direction.y(), c.direction.z(), c.gravity_m_s2.x(), c.gravity_m_s2.y(),
                                c.gravity_m_s2.z(), c.friction_kinetic, c.friction_static, c.speed_mm_per_s})
        hash.add(number);
    for (const insertion::Depth &depth : c.depths) {
        hash.add(depth.inserted_mm);
        hash.add(depth.turn_deg);
        hash.add_file(c.path_in(depth.centreline));
    }
    if (!c.force.empty()) hash.add_file(c.path_in(c.force));
    for (const Parameter &parameter : evaluator.parameters()) {
        hash.add(parameter.name);
        for (const double number : {parameter.low, parameter.high}) hash.add(number);
    }
    hash.add(evaluator.settings_text());
    hash.add(judge.settings_text());
    hash.add(std::string(method_token(settings.method)) + " " + std::to_string(settings.population) + " " +
             std::to_string(settings.seed));
    return hash.value();
}

void write_checkpoint(const std::string &path, std::uint64_t hash, const SearchSettings &settings,
                      const SearchState &state)
{
    std::string text = head_text(hash);
    text += "method " + std::string(method_token(settings.method)) + "\ngeneration " +
            std::to_string(state.generation) + "\n";
    put_trials(text, "trials", state.trials);
    put_trials(text, "population", state.population);
    text += "algorithm " + std::to_string(state.algorithm.size()) + "\n" + state.algorithm + "\nwhole\n";
    write_whole_file(path, text);
}

SearchState read_checkpoint(const std::string &path, std::uint64_t hash, std::size_t parameter_count)
{
    std::ifstream file(path, std::ios::binary);
    if (!file) throw CheckpointError(path + ": cannot be read: is it there?");
    std::ostringstream bytes;
    bytes << file.rdbuf();
    const std::string text = bytes.str(), head = head_text(hash);
    if (text.compare(0, std::string(magic).size(), magic) != 0)
        throw CheckpointError(path +
                              ": is no checkpoint of this version; remove it, and the search starts anew");
    if (text.compare(0, head.size(), head) != 0)
        throw CheckpointError(
            path + ": is of another case or of other settings (method, population, seed, bounds, insertion); "
                   "give the same ones, another output folder, or leave out --resume");
    Reader reader{path, std::istringstream(text.substr(head.size()))};
    SearchState state;
    std::string method;
    reader.expect("method");
    reader.stream >> method;
    reader.expect("generation");
    state.generation = static_cast<unsigned>(reader.count(1'000'000));
    state.trials = reader.trials("trials", parameter_count);
    state.population = reader.trials("population", parameter_count);
    reader.expect("algorithm");
    state.algorithm.resize(reader.count(100'000'000));
    reader.stream.get();
    reader.stream.read(state.algorithm.data(), static_cast<std::streamsize>(state.algorithm.size()));
    reader.expect("whole");
    return state;
}

} // namespace crn::calibrate
