// The account of a run does not know the output times.
#include "properties/generator.hpp"

namespace viscobar::properties {
namespace {

struct Told {
  Statistics statistics;
  std::vector<Event> events;
};

Told told(const Case& run) {
  Told all;
  Observers observers;
  observers.energy = observers.account = true;
  observers.snapshot = [](const Snapshot&) {};
  observers.event = [&](const Event& event) { all.events.push_back(event); };
  all.statistics = simulate(resolve(run), observers);
  return all;
}

// The steps of a scheme are those of its text: the outputs alone are varied.
TEST(Account, IsTheSameAtEveryOutputIntervalBitForBit) {
  expect_always([] {
    const RandomScene scene = *scenes();
    Case run = scene.read().run;
    const Told one = told(run);
    run.output_every *= *rc::gen::element(0.037, 0.41, 3.3, 100.0);
    const Told two = told(run);
    RC_CLASSIFY(!one.events.empty(), "contact");
    for (const auto end : {&RunAccount::left, &RunAccount::right}) {
      const EndAccount &a = (*one.statistics.account).*end, &b = (*two.statistics.account).*end;
      RC_ASSERT(a.closings == b.closings);
      for (double EndAccount::*const number : std::initializer_list<double EndAccount::*>{
               &EndAccount::displacement, &EndAccount::lowest, &EndAccount::highest, &EndAccount::impulse,
               &EndAccount::peak_reaction})
        RC_ASSERT((a.*number) == (b.*number));
      RC_ASSERT(a.contact.total(run.end) == b.contact.total(run.end));
    }
    RC_ASSERT(one.statistics.max_penetration == two.statistics.max_penetration);
    RC_ASSERT(one.statistics.steps == two.statistics.steps);
    for (const auto number :
         {&EnergyAccount::initial, &EnergyAccount::final, &EnergyAccount::dissipated, &EnergyAccount::work})
      RC_ASSERT(((*one.statistics.energy).*number) == ((*two.statistics.energy).*number));
    RC_ASSERT(one.events.size() == two.events.size());
    for (std::size_t k = 0; k < one.events.size(); ++k) RC_ASSERT(one.events[k].impulse == two.events[k].impulse);
  });
}

}  // namespace
}  // namespace viscobar::properties
