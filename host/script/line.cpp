#include "host/script/line.hpp"
#include <cctype>

namespace crn
{
namespace
{

bool is_number_character(char c)
{
    return std::isdigit(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '+';
}

} // namespace

std::vector<Token> split_line(std::string_view line)
{
    std::vector<Token> tokens;
    for (std::size_t i = 0; i < line.size() && line[i] != '#';) {
        if (std::isspace(static_cast<unsigned char>(line[i])) || line[i] == ',') {
            i++;
            continue;
        }
        const std::size_t begin = i;
        const bool is_number = is_number_character(line[i]);
        while (i < line.size() && !std::isspace(static_cast<unsigned char>(line[i])) && line[i] != ',' &&
               line[i] != '#' && (!is_number || is_number_character(line[i]))) {
            i++;
        }
        tokens.push_back({std::string(line.substr(begin, i - begin)), static_cast<int>(begin) + 1});
    }
    return tokens;
}

} // namespace crn
