// Makes error messages that name a position in a file, and suggestions for misspelt words.
#pragma once
#include "host/base/fault.hpp"
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// A message has the form "file:line:column: what is wrong". Line 0 of a message refers to the whole file, and
// column 0 to the whole line.
class FileError : public Fault
{
  public:
    FileError(const std::string &file, int line, int column, const std::string &text);
    std::string file;
    int line, column;
};

// Returns ", did you mean 'advance'?" if a known word is at most two edits away from the given word, else ";
// known: a, b, c".
std::string suggestion(std::string_view word, const std::vector<std::string> &candidates);

// Reads the whole file. Throws FileError with the operating system's reason.
std::string read_text_file(const std::string &path);
std::vector<unsigned char> read_binary_file(const std::string &path);

} // namespace crn
