// Workers evaluate the trials of a generation; they are threads of this process, or ranks (processes) of an
// MPI job. The results depend neither on which worker evaluates a trial nor on the order of the trials:
// verdict i belongs to trial i.
#pragma once
#include "tools/lab/calibrate/judge.hpp"
#include <functional>

namespace crn::calibrate
{

struct Interrupted : std::exception {
    const char *what() const noexcept override { return "interrupted"; }
};

// A function of the type Evaluate evaluates one trial: it takes the values of the parameters and returns a
// Verdict. The function that evaluates a trial must be safe to call from several threads.
using Evaluate = std::function<Verdict(const std::vector<double> &values)>;
// The program calls a function of the type Stop between trials; the function returns true if the work must
// stop.
using Stop = std::function<bool()>;
// The leading thread calls a function of the type Progress from time to time, with the number of finished
// trials.
using Progress = std::function<void(std::size_t done)>;

class Workers
{
  public:
    virtual ~Workers() = default;
    // Throws Interrupted when a stop was requested, and rethrows any exception that a trial has thrown.
    virtual std::vector<Verdict> evaluate(const std::vector<std::vector<double>> &trials) = 0;
    virtual std::string description() const = 0; // "4 threads", "2 ranks with 1 thread each"
};

std::unique_ptr<Workers> thread_workers(unsigned threads, Evaluate evaluate, Stop stop, Progress progress);

// --- MPI (workers_mpi.cpp) ---

// Returns true when mpirun or another launcher started the program; otherwise the program never initialises
// MPI.
bool is_mpi_job();

// Initialises and finalises the MPI library. Rank 0 leads; the other ranks evaluate trials until rank 0
// dismisses them.
class MpiJob
{
  public:
    MpiJob();
    ~MpiJob();
    MpiJob(const MpiJob &) = delete;
    MpiJob &operator=(const MpiJob &) = delete;

    int rank() const { return rank_; }
    int size() const { return size_; }
    // Ends every rank (process) of the MPI job at once with the given exit status. After a failure, only this
    // function can end the program, because the other ranks (processes) wait for messages.
    [[noreturn]] void abort(int status);

    // Rank 0 (the leading process) calls the function below; its workers are all other ranks, and `threads`
    // threads of rank 0.
    std::unique_ptr<Workers> workers(unsigned threads, Evaluate evaluate, Stop stop, Progress progress);
    // The other ranks (processes) call the function below, which evaluates incoming trials until rank 0
    // reports the end of the trials.
    void serve(unsigned threads, const Evaluate &evaluate);
    // Rank 0 (the leading process) calls the function below to tell the other ranks that no more trials
    // follow.
    void dismiss();

  private:
    int rank_ = 0, size_ = 1;
};

} // namespace crn::calibrate
