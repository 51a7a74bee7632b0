// Renderers of one size. The size never changes, so the memory of a picture stays at the same address while
// the renderer exists, and views of it stay valid.
#pragma once
#include "host/python/module/module.hpp"
#include <array>

namespace cournand_python
{

class Renderer
{
  public:
    Renderer(const Scene &scene, std::uint32_t size, std::uint32_t threads);
    cournand_renderer *get() const { return handle_.get(); }
    std::uint32_t size() const { return size_; }

  private:
    using Handle = Owned<cournand_renderer, cournand_renderer_free>;
    std::uint32_t size_;
    Handle handle_;
};

// The primary and secondary angles, isocentre, distances, field and dose, in the order of cournand_view.
using ViewNumbers = std::array<double, 9>;
cournand_view make_view(const ViewNumbers &numbers, std::uint32_t size, std::uint32_t flags,
                        std::uint64_t seed);

} // namespace cournand_python
