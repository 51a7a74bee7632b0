#include "tools/centreline/fit/axes.hpp"
#include "host/base/output_files.hpp"

#include <Eigen/LU>
#include <sstream>

namespace crn::centreline
{

Eigen::Matrix3d turned_axes(const std::string &text, const std::string &also)
{
    Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
    std::istringstream words(text);
    std::string word;
    int row = 0;
    for (; std::getline(words, word, ','); ++row) {
        const std::size_t axis = word.size() == 2 ? std::string("xyz").find(word[1]) : std::string::npos;
        if (row > 2 || axis == std::string::npos || (word[0] != '+' && word[0] != '-')) break;
        axes(row, static_cast<int>(axis)) = word[0] == '+' ? 1 : -1;
    }
    if (row != 3 || axes.determinant() < 0.5)
        throw UsageError("--axes " + text +
                         ": name each of x, y and z once with its sign, like +x,+z,-y, without a mirror" +
                         also);
    return axes;
}

} // namespace crn::centreline
