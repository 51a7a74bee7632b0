/* Makes the meshes of several bodies at the same time. Each body is made by one thread from start to end, so
 * the meshes do not depend on the number of threads. */
#pragma once
#include "tools/anatomy/mesh.hpp"
#include <functional>

namespace anatomy
{

/* Returns the number of threads that meshes are made with, if the user gives none: one per processor. */
unsigned usual_threads();

/* Makes the meshes of all requests, and calls `take` with each mesh in the order of the requests, in the
 * calling thread. `take` also receives the seconds that the mesh took. If a mesh cannot be made, the function
 * throws std::runtime_error, whose text begins with the name of the request and ends with the remedy. */
void make_meshes(const std::vector<std::string> &names, const std::vector<MeshRequest> &requests,
                 unsigned threads,
                 const std::function<void(size_t index, Mesh &&mesh, double seconds)> &take);

} // namespace anatomy
