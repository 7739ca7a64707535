#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "integration/error_weights.hpp"
#include "integration/rest_watch.hpp"
#include "integration/stepper.hpp"
#include "integration/sundials/leg.hpp"

namespace viscobar::sundials {

/// Functions that CVODE and IDA both have.
struct MultistepLibrary {
  std::string prefix;  ///< of the names of its functions
  int (*get_dky)(void*, sunrealtype, int, N_Vector);
  int (*get_last_order)(void*, int*);
  int (*get_current_time)(void*, sunrealtype*);
  int (*get_last_step)(void*, sunrealtype*);
  int (*set_max_order)(void*, int);
  int (*set_stop_time)(void*, sunrealtype);
  int (*set_max_step)(void*, sunrealtype);
  int (*set_user_data)(void*, void*);
  int (*set_weights)(void*, int (*)(N_Vector, N_Vector, void*));
  int (*set_solver)(void*, SUNNonlinearSolver);
  char* (*flag_name)(long);
  Library flags;
  bool divided_differences;  ///< its history, first to last; else Nordsieck's array, last to first
};

/// Steps of a multistep library, up to what the libraries have not alike: how a leg begins, and a step.
class Multistep : public LegStepper {
 public:
  void begin_run(std::vector<std::size_t> sampled_entries) final;
  void restart(double t, double stop, std::span<const double> y) final;
  void before_step() final;
  double advance() final;
  std::size_t order() const final;
  void interpolate(double t, std::span<double> y) final;
  std::span<const double> sample(double t, int derivative) final;
  void select(std::span<const std::size_t> sampled) final { probed_->selected.assign(sampled.begin(), sampled.end()); }
  bool hull(std::span<double> lowest, std::span<double> highest, std::span<double> last) final;
  std::span<const PointValues> form_samples(double begin, double end) final;
  double account_correction() const final { return leg_.account_correction; }
  std::span<const double> account() const final {
    return values(state_).subspan(2 * leg_.layout.nodes, leg_.layout.account());
  }
  std::span<const double> accelerations(double t) final;
  ErrorWeights& weights() final { return weights_; }

 protected:
  /// `solve_step` see Leg. With `passes_over_rest` the contacts at rest are watched (see RestWatch).
  Multistep(const MultistepLibrary& library, const StepperParts& parts, const Tolerance& tolerance,
            void (*solve_step)(Leg&, std::span<double>), bool passes_over_rest);

  static constexpr int highest_bdf = 5;

  /// Begins at t with the formulas that the leg asks for.
  virtual void begin_leg(double t) = 0;
  /// Begins at t by backward differentiation up to that order.
  virtual void begin_bdf(int order, double t) = 0;
  /// A step of the library. The name of its function behind the prefix, its flag, and the time reached in t_.
  virtual std::pair<const char*, int> step() = 0;

  /// To be called once for each memory of the library, and ...
  void configure(void* memory, double t);
  /// ... as each stretch of steps begins.
  void begin_stretch(void* memory, int max_order);

  /// A call of the function of that name, without the prefix.
  void check(const char* name, int flag);
  template <class... Formal, class... Actual>
  void call(const char* name, int (*function)(void*, Formal...), Actual... arguments) {
    check(name, function(leg_.memory, arguments...));
  }

  Context context_;
  Leg leg_;
  ErrorWeights weights_;
  double end_, stop_ = 0.0, t_ = 0.0;  // of the run, of the leg, and now
  Vector state_;

 private:
  void find_factors(double begin, double end);

  const MultistepLibrary& library_;
  bool passes_over_rest_;
  RestWatch rest_;
  RestWatch::Advice advice_ = RestWatch::Advice::go_on;
  Vector interpolated_;
  std::optional<Probed> probed_;
  Recorded record_;
  std::array<PointValues, 13> factors_{};  // of its terms, at the points of forms
  std::vector<PointValues> gathered_;      // its terms, of each entry of forms
  Vector probe_, hull_, recorder_;
  NonlinearSolver solver_;
};

}  // namespace viscobar::sundials
