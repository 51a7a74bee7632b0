// Makes the bodies of a scene on all processors (see bodies.hpp).
#include "tools/bake/bodies.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/form.hpp"
#include "tools/bake/lesion.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace crn::bake
{
namespace
{

int index_of(const SceneText &text, const std::string &name)
{
    const auto at = std::find_if(text.bodies.begin(), text.bodies.end(),
                                 [&](const BodyText &b) { return b.name == name; });
    return at == text.bodies.end() ? -1 : static_cast<int>(at - text.bodies.begin());
}

// Holds what each body waits for, and gives out the bodies that can be made. A body waits for the bodies that
// are subtracted from it, and marrow for its bone; both stand above it in the text.
class Queue
{
  public:
    explicit Queue(const SceneText &text)
        : waits_(text.bodies.size(), 0), followers_(text.bodies.size()), end_(text.bodies.size())
    {
        for (std::size_t i = 0; i < text.bodies.size(); ++i) {
            std::vector<std::string> needed = text.bodies[i].form.less;
            if (text.bodies[i].is_marrow) needed.push_back(text.bodies[i].inside);
            for (const std::string &name : needed) {
                ++waits_[i];
                followers_[static_cast<std::size_t>(index_of(text, name))].push_back(i);
            }
        }
    }
    // Returns the first body that can be made, or -1 when no body is left for this thread.
    int take()
    {
        std::unique_lock lock(mutex_);
        for (;;) {
            const auto at = std::find(waits_.begin(), waits_.begin() + static_cast<std::ptrdiff_t>(end_), 0);
            if (at != waits_.begin() + static_cast<std::ptrdiff_t>(end_)) {
                *at = taken;
                ++in_work_;
                return static_cast<int>(at - waits_.begin());
            }
            if (in_work_ == 0) return -1;
            changed_.wait(lock);
        }
    }
    void finished(int body)
    {
        const std::lock_guard lock(mutex_);
        --in_work_;
        for (std::size_t follower : followers_[static_cast<std::size_t>(body)]) --waits_[follower];
        changed_.notify_all();
    }
    // Bodies below a faulty one are not made. Those above are, so that always the same fault is named.
    void faulty(int body)
    {
        const std::lock_guard lock(mutex_);
        --in_work_;
        end_ = std::min(end_, static_cast<std::size_t>(body));
        changed_.notify_all();
    }

  private:
    static constexpr int taken = -1;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<int> waits_;
    std::vector<std::vector<std::size_t>> followers_;
    std::size_t end_;
    int in_work_ = 0;
};

class Maker
{
  public:
    Maker(const SceneText &text, const Mesh &lumen, const VesselTree &tree, Progress &progress)
        : text_(text), lumen_(lumen), tree_(tree), progress_(progress), queue_(text),
          bodies_(text.bodies.size()), bases_(text.bodies.size()), reports_(text.bodies.size()),
          faults_(text.bodies.size())
    {
        for (std::size_t i = 0; i < bodies_.size(); ++i) {
            const BodyText &body = text.bodies[i];
            bodies_[i].name = body.name;
            bodies_[i].material = body.material;
            bodies_[i].moves = body.moves;
            bodies_[i].is_trabecular = body.is_trabecular();
            bodies_[i].parent = index_of(text, body.inside);
        }
    }

    // Reads the meshes one after another: a child process reads each file, and forking is cheap only as long
    // as this process is small.
    void load()
    {
        progress_.stage("reading the bodies", bodies_.size());
        for (std::size_t i = 0; i < bodies_.size(); ++i) {
            progress_.step(i);
            const BodyText &body = text_.bodies[i];
            if (!body.is_lumen && !body.is_marrow) bases_[i] = load_body(body);
            if (!body.inhaled.empty()) bodies_[i].inhaled_mm = load_inhaled(body, bases_[i]);
        }
    }

    void make()
    {
        progress_.stage("making the bodies", bodies_.size());
        const std::size_t count =
            std::min<std::size_t>(std::max(1u, std::thread::hardware_concurrency()), bodies_.size());
        {
            std::vector<std::jthread> threads;
            for (std::size_t i = 1; i < count; ++i) threads.emplace_back([this] { work(false); });
            work(true);
        }
        progress_.step(
            bodies_.size()); // names the user's interruption rather than a fault that follows from it
        for (const std::exception_ptr &fault : faults_)
            if (fault) std::rethrow_exception(fault);
        progress_.finish();
    }

    std::vector<BakedBody> take(std::string &report)
    {
        for (const std::string &lines : reports_) report += lines;
        return std::move(bodies_);
    }

  private:
    // The thread that called make() also shows the progress, and throws when the user has interrupted it.
    void work(bool is_caller)
    {
        for (int i; (i = queue_.take()) >= 0;) {
            try {
                if (Progress::interrupted()) throw Fault("interrupted: nothing was written");
                make_one(static_cast<std::size_t>(i));
            } catch (...) {
                faults_[static_cast<std::size_t>(i)] = std::current_exception();
                queue_.faulty(i);
                continue;
            }
            queue_.finished(i);
            if (is_caller) progress_.step(static_cast<std::size_t>(i));
        }
    }

    void make_one(std::size_t i)
    {
        const BodyText &body = text_.bodies[i];
        Mesh &mesh = bodies_[i].mesh;
        mesh = body.is_lumen ? lumen_ : form_body(body, std::move(bases_[i]), bodies_, reports_[i]);
        std::vector<bool> narrowed;
        if (!body.is_lumen && body.material == "blood" && !tree_.lesions.empty())
            narrowed = narrow(mesh, lesions_within(tree_, TriangleTree(mesh)));
        const bool is_changed = bodies_[i].inhaled_mm.size() != mesh.vertices_mm.size() ||
                                std::find(narrowed.begin(), narrowed.end(), true) != narrowed.end();
        if (!body.inhaled.empty() && is_changed)
            throw Fault(body.mesh.file.string() + ": a lesion changes body '" + body.name +
                        "', so its `inhaled` does not fit: leave `inhaled` out");
    }

    const SceneText &text_;
    const Mesh &lumen_;
    const VesselTree &tree_;
    Progress &progress_;
    Queue queue_;
    std::vector<BakedBody> bodies_;
    std::vector<Mesh> bases_;
    std::vector<std::string> reports_;
    std::vector<std::exception_ptr> faults_;
};

} // namespace

std::vector<bool> narrow(Mesh &mesh, const VesselTree &tree)
{
    if (tree.lesions.empty()) return {};
    refine_lesions(mesh, tree);
    return narrow_lesions(mesh.vertices_mm, tree);
}

std::vector<BakedBody> make_bodies(const SceneText &text, const Mesh &lumen, const VesselTree &tree,
                                   std::string &report, Progress &progress)
{
    Maker maker(text, lumen, tree, progress);
    maker.load();
    maker.make();
    std::vector<BakedBody> bodies = maker.take(report);
    for (std::size_t k = 0; k < text.lesions.size(); ++k) {
        if (text.lesions[k].calcified_deg == 0) continue;
        BakedBody calcium = calcium_of(tree, tree.lesions[k], text.lesions[k]);
        calcium.moves = !text.motion.frames.empty();
        calcium.parent = index_of(text, text.lesions[k].inside);
        bodies.push_back(std::move(calcium));
    }
    return bodies;
}

} // namespace crn::bake
