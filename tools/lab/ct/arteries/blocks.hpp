// The mean of some voxels in the neighbourhood of every voxel, on coarse blocks.
#pragma once
#include "tools/lab/ct/volume/volume.hpp"

namespace crn::ct
{

class BlockMeans
{
  public:
    // Takes the voxels for which is_wanted(voxel) holds, in blocks of `block_mm`. The mean is that of a block
    // and its 26 neighbours. Where less than `share_least` of their voxels are wanted, it is `standard`.
    template <class Rule>
    BlockMeans(const Volume &scan, double block_mm, double share_least, double standard,
               const Rule &is_wanted)
    {
        set_size(scan, block_mm);
        std::vector<double> sums(count()), counts(count());
        for (int k = 0; k < scan.size[2]; ++k)
            for (int j = 0; j < scan.size[1]; ++j)
                for (int i = 0; i < scan.size[0]; ++i) {
                    const std::size_t at = scan.at(i, j, k);
                    if (!is_wanted(at)) continue;
                    sums[block(i, j, k)] += static_cast<double>(scan.hu[at]);
                    counts[block(i, j, k)] += 1;
                }
        finish(std::move(sums), std::move(counts), share_least, standard);
    }
    float at(int i, int j, int k) const { return means_[block(i, j, k)]; }

  private:
    std::size_t count() const
    {
        return static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
               static_cast<std::size_t>(size_[2]);
    }
    std::size_t block(int i, int j, int k) const
    {
        return (static_cast<std::size_t>(k / voxels_[2]) * static_cast<std::size_t>(size_[1]) +
                static_cast<std::size_t>(j / voxels_[1])) *
                   static_cast<std::size_t>(size_[0]) +
               static_cast<std::size_t>(i / voxels_[0]);
    }
    void set_size(const Volume &scan, double block_mm);
    void finish(std::vector<double> sums, std::vector<double> counts, double share_least, double standard);
    void spread(std::vector<double> &values) const;

    std::array<int, 3> voxels_{}, size_{};
    std::vector<float> means_;
};

} // namespace crn::ct
