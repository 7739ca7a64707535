#pragma once

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <vector>

#include "sweep/sweep_workers.hpp"

namespace viscobar {

/// True in a process that mpirun, srun or a like started.
inline bool started_by_mpi() {
  const char* const variables[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"};
  return std::any_of(std::begin(variables), std::end(variables), [](const char* name) { return std::getenv(name); });
}

/// The processes of an MPI job: rank 0 hands out the cases and writes the rows, every other rank runs one case at a
/// time. The scene goes to all once; then the manager sends
/// cases to be planned, and the worker their costs, and then a case at a time, and the worker its row. MPI lives as
/// long as this object, of which there is one. The program is not linked to MPI, whose libraries take longer to load
/// than a small bar to run: this one's constructor replaces the process by viscobar-mpi, which is.
class Ranks {
 public:
  /// `interrupted` tells, in any process of the job, whether to give up.
  /// @throws std::invalid_argument when this viscobar was built without MPI
  explicit Ranks(std::function<bool()> interrupted);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int size() const { return size_; }
  bool is_manager() const { return rank_ == 0; }

  /// Called by the manager, before run(): like plan_cases(), each rank a share.
  std::vector<double> plan(const SweepFile& sweep);

  /// Called by the manager; like run_on_threads().
  bool run(const SweepWork& work);

  /// Called by a worker: runs until the manager has no more cases.
  void serve();

 private:
  std::function<bool()> interrupted_;
  int rank_ = 0, size_ = 1;
  bool scene_sent_ = false, ran_ = false;
};

}  // namespace viscobar
