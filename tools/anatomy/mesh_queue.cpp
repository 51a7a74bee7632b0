#include "tools/anatomy/mesh_queue.hpp"
#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <new>
#include <numeric>
#include <stdexcept>
#include <thread>

namespace anatomy
{

namespace
{

struct Made {
    Mesh mesh;
    double seconds = 0;
};

/* Estimates how long a mesh takes: the surface of its box in voxels. The longest meshes are begun first, so
 * that no thread makes a long one alone at the end. */
double estimated_work(const MeshRequest &request)
{
    const Vec3 size = (request.bounds.high - request.bounds.low) / request.voxel_mm;
    return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

std::vector<size_t> longest_first(const std::vector<MeshRequest> &requests)
{
    std::vector<size_t> order(requests.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
        return estimated_work(requests[a]) > estimated_work(requests[b]);
    });
    return order;
}

Made made(const MeshRequest &request)
{
    const auto start = std::chrono::steady_clock::now();
    Made one;
    one.mesh = mesh_of(request);
    one.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return one;
}

} // namespace

unsigned usual_threads()
{
    constexpr unsigned THREADS_MAX = 16; // a person has about 40 bodies
    return std::clamp(std::thread::hardware_concurrency(), 1u, THREADS_MAX);
}

void make_meshes(const std::vector<std::string> &names, const std::vector<MeshRequest> &requests,
                 unsigned threads, const std::function<void(size_t index, Mesh &&mesh, double seconds)> &take)
{
    const std::vector<size_t> order = longest_first(requests);
    std::vector<std::promise<Made>> promises(requests.size());
    std::vector<std::future<Made>> results;
    for (std::promise<Made> &promise : promises) results.push_back(promise.get_future());
    std::atomic<size_t> next = 0;
    const auto work = [&] {
        for (size_t i = next++; i < order.size(); i = next++) {
            try {
                promises[order[i]].set_value(made(requests[order[i]]));
            } catch (...) {
                promises[order[i]].set_exception(std::current_exception());
            }
        }
    };
    std::vector<std::jthread> workers; // joined when this function ends, also by an exception
    const size_t count = std::min<size_t>(std::max(1u, threads), requests.size());
    for (size_t i = 0; i < count; i++) workers.emplace_back(work);
    const auto stop = [&] { next = order.size(); }; // the workers end their present mesh, and begin no other
    for (size_t i = 0; i < results.size(); i++) {
        Made one;
        try {
            one = results[i].get();
        } catch (const std::bad_alloc &) {
            stop();
            throw std::runtime_error(names[i] +
                                     ": too little memory; give fewer --threads, or a coarser grid: "
                                     "a larger --body-scale or --lumen-mm");
        } catch (const std::exception &error) {
            stop();
            throw std::runtime_error(names[i] + ": " + error.what() +
                                     "; try a finer grid: a smaller --body-scale or --lumen-mm");
        }
        try {
            take(i, std::move(one.mesh), one.seconds);
        } catch (...) {
            stop();
            throw;
        }
    }
}

} // namespace anatomy
