// Computes the Cholesky factor of a band matrix, row by row.
#include "tools/lab/reference_rod/band.hpp"
#include <algorithm>
#include <cmath>

namespace crn::reference
{

void Band::reset(int size)
{
    size_ = size;
    entries_.assign(static_cast<std::size_t>(size) * (reach + 1), 0.0);
}

bool Band::factor()
{
    for (int i = 0; i < size_; i++) {
        const int first = std::max(0, i - reach);
        for (int j = first; j <= i; j++) {
            double sum = at(i, j);
            for (int k = std::max(first, j - reach); k < j; k++) sum -= at(i, k) * at(j, k);
            if (j < i) {
                at(i, j) = sum / at(j, j);
            } else {
                if (!(sum > 0.0)) return false;
                at(i, i) = std::sqrt(sum);
            }
        }
    }
    return true;
}

void Band::solve(Eigen::VectorXd &x) const
{
    for (int i = 0; i < size_; i++) {
        for (int k = std::max(0, i - reach); k < i; k++) x[i] -= at(i, k) * x[k];
        x[i] /= at(i, i);
    }
    for (int i = size_ - 1; i >= 0; i--) {
        x[i] /= at(i, i);
        for (int k = std::max(0, i - reach); k < i; k++) x[k] -= at(i, k) * x[i];
    }
}

} // namespace crn::reference
