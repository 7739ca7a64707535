// End traces of one's own, out of a CSV file, beside viscobar's methods.
//
//     u_tt - u_xx = 0                         0 < x < 1, t < 6
//     0 <= u(0,t)  _|_  R(t) >= 0             obstacle at the left end, u(1,t) = 0
//     u(x,0) = (1 - x)/2,  u_t(x,0) = 0
//
// The file has a header and lines t,u_left,u_right, here the closed form of this bar of period 3: u(0,t) = (1 - t)/2,
// 0, (t - 2)/2 on the three thirds. It could as well be a measurement or another program's. Ends are all it knows, so
// they become a recording on a mesh of one element.
//
// Run: build/release/examples/end_traces examples/data/period-3-ends.csv
#include <cmath>
#include <fstream>
#include <iostream>
#include <viscobar/viscobar.hpp>

namespace {

using namespace viscobar;

struct Trace {
  std::vector<double> times, left, right;

  explicit Trace(const std::string& file) {
    std::ifstream stream(file);
    if (!stream) throw std::runtime_error(file + " cannot be read");
    std::string header;
    std::getline(stream, header);
    double t = 0.0, u_left = 0.0, u_right = 0.0;
    for (char comma = 0; stream >> t >> comma >> u_left >> comma >> u_right;) {
      times.push_back(t);
      left.push_back(u_left);
      right.push_back(u_right);
    }
  }

  // The solver that viscobar calls: linear between the times of the file, whatever they are.
  Recording operator()(const Case& run) const {
    Recording ends;
    ends.label = "trace";
    ends.mesh = {run.scene.bar.length, 1};
    ends.times = run.output_times();
    std::size_t k = 1;
    for (const double t : ends.times) {
      while (k + 1 < times.size() && times[k] < t) ++k;
      const double share = (t - times[k - 1]) / (times[k] - times[k - 1]);
      ends.u.push_back(std::lerp(left[k - 1], left[k], share));
      ends.u.push_back(std::lerp(right[k - 1], right[k], share));
    }
    return ends;
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "end_traces FILE\n";
    return 2;
  }
  const Trace trace(argv[1]);

  Case run;
  run.scene = exact::PeriodThree::scene();
  run.elements = 200;
  run.mass = Mass::redistributed;
  run.epsilon = 1e-6;
  run.step = 1e-3;
  run.end = trace.times.back();
  run.output_every = 0.01;

  // The kinks of the wave, where the slope jumps by 1/2, spread by the dispersion of linear elements over h^(2/3).
  const double spread = std::pow(run.mesh().spacing(), 2.0 / 3.0);
  const Trial trial{"period-3 bar",
                    run,
                    {},
                    {MethodName::rigid, MethodName::ida, MethodName::fully_discrete},
                    Bounds{.end_trace = 0.5 * spread}};
  const TrialResult result = examine("trace", trace, {&trial, 1}).front();
  std::cout << trial_text(result);
  return result.passed() ? 0 : 1;
}
