// The workers that evaluate the trials of a generation: threads of this process, or ranks of an MPI job. The
// results do not depend on the worker or on the order: verdict i belongs to trial i.
#pragma once
#include "tools/lab/calibrate/judge.hpp"
#include <functional>

namespace crn::calibrate
{

struct Interrupted : std::exception {
    const char *what() const noexcept override { return "interrupted"; }
};

// Evaluates one trial: it takes values and returns a verdict. It must be safe to call from several threads.
using Evaluate = std::function<Verdict(const std::vector<double> &values)>;
// It is called between trials; true means stop.
using Stop = std::function<bool()>;
// The leading thread calls it now and then with the number of finished trials.
using Progress = std::function<void(std::size_t done)>;

class Workers
{
  public:
    virtual ~Workers() = default;
    // Throws Interrupted when a stop was requested, and passes on what a trial throws.
    virtual std::vector<Verdict> evaluate(const std::vector<std::vector<double>> &trials) = 0;
    virtual std::string description() const = 0; // "4 threads", "2 ranks with 1 thread each"
};

std::unique_ptr<Workers> thread_workers(unsigned threads, Evaluate evaluate, Stop stop, Progress progress);

// --- MPI (workers_mpi.cpp) ---

// True when mpirun or another launcher started the program; otherwise MPI is never initialised.
bool is_mpi_job();

// Initialises and finalises MPI. Rank 0 leads; the others serve until it dismisses them.
class MpiJob
{
  public:
    MpiJob();
    ~MpiJob();
    MpiJob(const MpiJob &) = delete;
    MpiJob &operator=(const MpiJob &) = delete;

    int rank() const { return rank_; }
    int size() const { return size_; }
    // Ends every rank at once with this exit status. It is the only way out after a failure, since the others
    // wait.
    [[noreturn]] void abort(int status);

    // On rank 0: itself with `threads`, and all other ranks.
    std::unique_ptr<Workers> workers(unsigned threads, Evaluate evaluate, Stop stop, Progress progress);
    // On the other ranks: evaluates incoming trials until rank 0 sends the end.
    void serve(unsigned threads, const Evaluate &evaluate);
    // On rank 0: sends the end of the trials.
    void dismiss();

  private:
    int rank_ = 0, size_ = 1;
};

} // namespace crn::calibrate
