// Holds a symmetric band matrix whose entries lie within `Band::reach` of the diagonal; it can be factored by
// Cholesky's method and solved.
#pragma once
#include <Eigen/Core>
#include <vector>

namespace crn::reference
{

class Band
{
  public:
    static constexpr int reach =
        10; // that of a joint: its three nodes and two edges have 11 unknowns side by side

    void reset(int size); // all zero
    int size() const { return size_; }
    // Returns the entry (row, column) with row >= column >= row - reach.
    double &at(int row, int column)
    {
        return entries_[static_cast<std::size_t>(row) * (reach + 1) + column - row + reach];
    }
    double at(int row, int column) const
    {
        return entries_[static_cast<std::size_t>(row) * (reach + 1) + column - row + reach];
    }

    // Replaces the matrix by its lower Cholesky factor. Returns false when the matrix is not positive
    // definite; its entries are then lost.
    bool factor();
    // Replaces the right side by the solution; factor() must have been called before.
    void solve(Eigen::VectorXd &x) const;

  private:
    int size_ = 0;
    std::vector<double> entries_; // row by row: `reach` entries left of the diagonal, and the diagonal
};

} // namespace crn::reference
