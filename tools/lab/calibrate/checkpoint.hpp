// A checkpoint is a file that holds the state of a search for the best parameters. A stopped search continues
// from its checkpoint, on this or another machine, with the same results as if it had never stopped. The file
// is text. The file begins with a header (version, hash and settings). After the header, the file contains
// every trial as exact hexadecimal doubles, the archive of the library pagmo, and an end line. A checkpoint
// without an end line is incomplete. After every generation, the program writes the checkpoint under a
// temporary name, and then renames the file to its final name.
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

// Computes an FNV-1a hash over all data on which the result of a search depends.
class Hash
{
  public:
    void add(std::string_view bytes);
    void add(double value);
    void add_file(const std::filesystem::path &file); // Hashes the bytes of a file, not its name. Throws
                                                      // CheckpointError.
    std::uint64_t value() const { return value_; }

  private:
    std::uint64_t value_ = 14695981039346656037u;
};

// Hashes the case with all its files, and the settings of the evaluator, the judge and the search. The hash
// leaves out the number of generations, so that a user can prolong a search.
std::uint64_t hash_of(const insertion::Case &c, const Evaluator &evaluator, const Judge &judge,
                      const SearchSettings &settings);

// Throws OutputError.
void write_checkpoint(const std::string &path, std::uint64_t hash, const SearchSettings &settings,
                      const SearchState &state);
// Throws CheckpointError when the file is incomplete, or when its version, case or settings do not match
// `hash`.
SearchState read_checkpoint(const std::string &path, std::uint64_t hash, std::size_t parameter_count);

} // namespace crn::calibrate
