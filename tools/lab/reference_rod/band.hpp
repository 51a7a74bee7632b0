// Holds a symmetric band matrix, whose entries lie within `Band::reach` of the diagonal, and solves systems
// with this matrix by Cholesky's method.
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
    // Returns the matrix entry at (row, column), where row >= column >= row - reach.
    double &at(int row, int column)
    {
        return entries_[static_cast<std::size_t>(row) * (reach + 1) + column - row + reach];
    }
    double at(int row, int column) const
    {
        return entries_[static_cast<std::size_t>(row) * (reach + 1) + column - row + reach];
    }

    // Replaces the matrix by its lower Cholesky factor. Returns false when the matrix is not positive
    // definite; its entries are lost in this case.
    bool factor();
    // Replaces the right-hand side of the system by the solution; the caller must call factor() first.
    void solve(Eigen::VectorXd &x) const;

  private:
    int size_ = 0;
    std::vector<double> entries_; // row by row: `reach` entries left of the diagonal, and the diagonal
};

} // namespace crn::reference
