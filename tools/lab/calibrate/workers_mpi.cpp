// Distributes trials over the ranks (processes) of an MPI job. Of all files in this folder, only this file
// uses MPI itself. Only the first thread of each rank (process) exchanges messages with other ranks. The
// first thread polls for messages and sleeps between the polls, because MPI's own waiting functions keep a
// processor core busy.
//   trial    rank 0 -> r   { index, values... }
//   verdict  r -> rank 0   { index, objective, error, force error }
//   threads  r -> rank 0   { how many trials r takes at a time }
//   failure  r -> rank 0   the error as text
//   over     rank 0 -> r   nothing
#include "tools/lab/calibrate/thread_pool.hpp"
#include <chrono>
#include <cstdlib>
#define OMPI_SKIP_MPICXX 1 // we do not use its C++ classes
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

namespace crn::calibrate
{
namespace
{

enum Tag { trial_tag = 1, verdict_tag, threads_tag, failure_tag, over_tag };
constexpr int pause_ms = 1;

std::vector<double> receive(const MPI_Status &status)
{
    int count = 0;
    MPI_Get_count(&status, MPI_DOUBLE, &count);
    std::vector<double> numbers(static_cast<std::size_t>(count));
    MPI_Recv(numbers.data(), count, MPI_DOUBLE, status.MPI_SOURCE, status.MPI_TAG, MPI_COMM_WORLD,
             MPI_STATUS_IGNORE);
    return numbers;
}

std::string receive_text(const MPI_Status &status)
{
    int count = 0;
    MPI_Get_count(&status, MPI_CHAR, &count);
    std::string text(static_cast<std::size_t>(count), ' ');
    MPI_Recv(text.data(), count, MPI_CHAR, status.MPI_SOURCE, status.MPI_TAG, MPI_COMM_WORLD,
             MPI_STATUS_IGNORE);
    return text;
}

void send(const std::vector<double> &numbers, int rank, Tag tag)
{
    MPI_Send(numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, rank, tag, MPI_COMM_WORLD);
}

bool is_waiting(MPI_Status &status)
{
    int flag = 0;
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &flag, &status);
    return flag != 0;
}

class MpiWorkers final : public Workers
{
  public:
    MpiWorkers(int size, unsigned threads, Evaluate evaluate, Stop stop, Progress progress)
        : pool_(threads, std::move(evaluate)), stop_(std::move(stop)), progress_(std::move(progress)),
          room_(static_cast<std::size_t>(size), 0), busy_(room_)
    {
        room_[0] = pool_.size();
        for (int rank = 1; rank < size; rank++) {
            MPI_Status status;
            MPI_Probe(rank, threads_tag, MPI_COMM_WORLD, &status);
            room_[static_cast<std::size_t>(rank)] = static_cast<unsigned>(receive(status).at(0));
        }
    }

    std::vector<Verdict> evaluate(const std::vector<std::vector<double>> &trials) override
    {
        std::vector<Verdict> verdicts(trials.size());
        std::size_t next = 0, done = 0;
        while (done < trials.size()) {
            for (std::size_t rank = 0; rank < room_.size(); rank++)
                while (next < trials.size() && busy_[rank] < room_[rank])
                    give(rank, next, trials[next]), next++;
            const std::size_t before = done;
            for (const ThreadPool::Done &own : pool_.take(pause_ms)) {
                if (own.failure) std::rethrow_exception(own.failure);
                verdicts[own.index] = own.verdict;
                busy_[0]--;
                done++;
            }
            done += hear(verdicts);
            if (stop_ && stop_()) throw Interrupted();
            if (progress_ && done > before) progress_(done);
        }
        return verdicts;
    }

    std::string description() const override
    {
        unsigned all = 0;
        for (const unsigned threads : room_) all += threads;
        return std::to_string(room_.size()) + " ranks with " + std::to_string(all) + " threads together";
    }

  private:
    void give(std::size_t rank, std::size_t index, const std::vector<double> &values)
    {
        busy_[rank]++;
        if (rank == 0) {
            pool_.give(index, values);
            return;
        }
        std::vector<double> message = {static_cast<double>(index)};
        message.insert(message.end(), values.begin(), values.end());
        send(message, static_cast<int>(rank), trial_tag);
    }

    std::size_t hear(std::vector<Verdict> &verdicts)
    {
        std::size_t count = 0;
        for (MPI_Status status; is_waiting(status); count++) {
            if (status.MPI_TAG == failure_tag)
                throw std::runtime_error("rank " + std::to_string(status.MPI_SOURCE) + ": " +
                                         receive_text(status));
            const std::vector<double> message = receive(status);
            verdicts.at(static_cast<std::size_t>(message.at(0))) = {message.at(1), message.at(2),
                                                                    message.at(3)};
            busy_[static_cast<std::size_t>(status.MPI_SOURCE)]--;
        }
        return count;
    }

    ThreadPool pool_;
    Stop stop_;
    Progress progress_;
    std::vector<unsigned> room_, busy_; // trials that each rank takes at a time, and has now
};

} // namespace

bool is_mpi_job()
{
    for (const char *name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "MPI_LOCALNRANKS"})
        if (std::getenv(name)) return true;
    return false;
}

MpiJob::MpiJob()
{
    int given = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &given);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

MpiJob::~MpiJob()
{
    MPI_Finalize();
}

void MpiJob::abort(int status)
{
    MPI_Abort(MPI_COMM_WORLD, status);
    std::_Exit(status);
}

std::unique_ptr<Workers> MpiJob::workers(unsigned threads, Evaluate evaluate, Stop stop, Progress progress)
{
    return std::make_unique<MpiWorkers>(size_, threads, std::move(evaluate), std::move(stop),
                                        std::move(progress));
}

void MpiJob::serve(unsigned threads, const Evaluate &evaluate)
{
    ThreadPool pool(threads, evaluate);
    send({static_cast<double>(pool.size())}, 0, threads_tag);
    for (;;) {
        for (MPI_Status status; is_waiting(status);) {
            const std::vector<double> message = receive(status);
            if (status.MPI_TAG == over_tag) return;
            pool.give(static_cast<std::size_t>(message.at(0)), {message.begin() + 1, message.end()});
        }
        for (const ThreadPool::Done &done : pool.take(pause_ms)) {
            try {
                if (done.failure) std::rethrow_exception(done.failure);
                const Verdict &v = done.verdict;
                send({static_cast<double>(done.index), v.objective, v.error_mm, v.force_error}, 0,
                     verdict_tag);
            } catch (const std::exception &error) {
                const std::string text = error.what();
                MPI_Send(text.data(), static_cast<int>(text.size()), MPI_CHAR, 0, failure_tag,
                         MPI_COMM_WORLD);
            }
        }
    }
}

void MpiJob::dismiss()
{
    for (int rank = 1; rank < size_; rank++) send({}, rank, over_tag);
}

} // namespace crn::calibrate
