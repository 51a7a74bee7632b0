// Who evaluates the trials of a generation: threads of this process, or ranks of an MPI job. What comes back
// does not depend on who did it or in which order: verdict i belongs to trial i.
#pragma once
#include "tools/lab/calibrate/judge.hpp"
#include <functional>

namespace crn::calibrate
{

struct Interrupted : std::exception {
    const char *what() const noexcept override { return "interrupted"; }
};

// One trial: values in, verdict out. Safe from several threads.
using Evaluate = std::function<Verdict(const std::vector<double> &values)>;
// Asked between trials; true: stop.
using Stop = std::function<bool()>;
// Called by the leading thread now and then with the number of trials that are done.
using Progress = std::function<void(std::size_t done)>;

class Workers
{
  public:
    virtual ~Workers() = default;
    // Throws Interrupted when it was asked to stop, and what a trial throws.
    virtual std::vector<Verdict> evaluate(const std::vector<std::vector<double>> &trials) = 0;
    virtual std::string description() const = 0; // "4 threads", "2 ranks with 1 thread each"
};

std::unique_ptr<Workers> thread_workers(unsigned threads, Evaluate evaluate, Stop stop, Progress progress);

// --- MPI (workers_mpi.cpp) ---

// Started by mpirun or another launcher: without one MPI is never begun.
bool is_mpi_job();

// Begins and ends MPI. Rank 0 leads; the others serve until it is gone.
class MpiJob
{
  public:
    MpiJob();
    ~MpiJob();
    MpiJob(const MpiJob &) = delete;
    MpiJob &operator=(const MpiJob &) = delete;

    int rank() const { return rank_; }
    int size() const { return size_; }
    // Ends every rank at once with this exit status: the way out after a failure, since the others wait.
    [[noreturn]] void abort(int status);

    // Rank 0: itself with `threads`, and all other ranks.
    std::unique_ptr<Workers> workers(unsigned threads, Evaluate evaluate, Stop stop, Progress progress);
    // The other ranks: evaluate what comes, until rank 0 says that there is no more.
    void serve(unsigned threads, const Evaluate &evaluate);
    // Rank 0: no more trials.
    void dismiss();

  private:
    int rank_ = 0, size_ = 1;
};

} // namespace crn::calibrate
