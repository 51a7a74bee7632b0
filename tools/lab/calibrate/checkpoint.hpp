// The state of a search as a file. A search that was stopped continues from it, here or on another machine,
// as if it had never stopped. The file is text: a head with version, hash and settings, every trial as
// hexadecimal doubles (exact), pagmo's archive, and a last line without which the file is incomplete. It is
// written under another name and renamed, after every generation.
#pragma once
#include "tools/lab/calibrate/search.hpp"

namespace crn::calibrate
{

// "FILE: cause; remedy".
class CheckpointError : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

// An FNV-1a hash over everything on which a search depends.
class Hash
{
  public:
    void add(std::string_view bytes);
    void add(double value);
    void
    add_file(const std::filesystem::path &file); // hashes its bytes, not its name. Throws CheckpointError.
    std::uint64_t value() const { return value_; }

  private:
    std::uint64_t value_ = 14695981039346656037u;
};

// Hashes the case with all its files, the evaluator, the judge and the search, but not the number of
// generations, because a search may be prolonged.
std::uint64_t hash_of(const insertion::Case &c, const Evaluator &evaluator, const Judge &judge,
                      const SearchSettings &settings);

// Throws OutputError.
void write_checkpoint(const std::string &path, std::uint64_t hash, const SearchSettings &settings,
                      const SearchState &state);
// Throws CheckpointError when the file is incomplete, of another version, or of a case or settings other than
// `hash`.
SearchState read_checkpoint(const std::string &path, std::uint64_t hash, std::size_t parameter_count);

} // namespace crn::calibrate
