// Uses what needs each library that viscobar is linked with: SUNDIALS, fmt, HDF5.
#include <cstdio>
#include <filesystem>
#include <viscobar/viscobar.hpp>

int main() {
  const viscobar::SceneFile scene = viscobar::parse_scene(
      "[bar]\nlength = 1.0\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = 0.1\n[right]\nkind = \"free\"\n"
      "[initial]\ndisplacement = \"0*x\"\nvelocity = -1.0\n[time]\nend = 1.0\n[mesh]\nelements = 10\n"
      "[contact]\nepsilon = 1e-4\n[method]\nname = \"cvode\"\n[output]\nevery = 0.1\n",
      "outside.toml");
  const viscobar::RunRecord run = viscobar::record_run(scene, "outside-result");
  std::filesystem::remove_all("outside-result");
  std::printf("viscobar %s, %zu contact changes\n", viscobar::versions().viscobar.c_str(), run.outcome.events);
  return run.outcome.ending == viscobar::Ending::completed && run.outcome.events > 0 ? 0 : 1;
}
