#include "tools/lab/calibrate/evaluator.hpp"
#include "host/base/number_text.hpp"
#include <algorithm>
#include <cmath>

namespace crn::calibrate
{

double Parameter::value_at(double share) const
{
    return low * std::pow(high / low, share);
}

double Parameter::share_of(double value) const
{
    return std::clamp(std::log(value / low) / std::log(high / low), 0.0, 1.0);
}

void Evaluator::set_bounds(std::size_t parameter, double low, double high)
{
    Parameter &p = parameters_.at(parameter);
    if (!(low > 0.0) || !(low < high) || p.nominal < low || p.nominal > high)
        throw Fault("bounds of " + p.name + ": give LOW..HIGH above 0 with the file's value, " +
                    number_text(p.nominal, insertion::file_digits) + " " + p.unit + ", between them");
    p.low = low;
    p.high = high;
}

} // namespace crn::calibrate
