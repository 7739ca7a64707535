#include "sweep/ranks.hpp"

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace viscobar {

namespace {

/// This process becomes the program that is linked to MPI, beside this one; returns where there is none.
void become_rank() {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "viscobar-mpi";
  std::ifstream command("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> arguments;
  for (std::string one; std::getline(command, one, '\0');) arguments.push_back(one);
  std::vector<char*> pointers;
  for (std::string& one : arguments) pointers.push_back(one.data());
  pointers.push_back(nullptr);
  ::execv(program.c_str(), pointers.data());
}

}  // namespace

Ranks::Ranks(std::function<bool()> interrupted) : interrupted_(std::move(interrupted)) {
  become_rank();
  const char* const sizes[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_NTASKS"};
  const auto more_than_one = [](const char* name) {
    const char* size = std::getenv(name);
    return size && std::strcmp(size, "1") != 0;
  };
  if (std::none_of(std::begin(sizes), std::end(sizes), more_than_one)) return;
  throw std::invalid_argument(
      "this viscobar was built without MPI, so mpirun would run the same sweep several times; build it where MPI is "
      "installed (libopenmpi-dev), or start it without mpirun: it uses all cores of a machine");
}
Ranks::~Ranks() = default;
std::vector<double> Ranks::plan(const SweepFile&) { return {}; }
bool Ranks::run(const SweepWork&) { return false; }
void Ranks::serve() {}

}  // namespace viscobar
