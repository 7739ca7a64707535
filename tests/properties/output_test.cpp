#include "properties/generator.hpp"
#include "support/description.hpp"
#include "viscobar/case/recording.hpp"

namespace viscobar::properties {
namespace {

TEST(Output, IntervalLeavesTheTrajectoryAsItIsBitForBit) {
  expect_always([] {
    const RandomScene scene = *scenes();
    RandomScene finer = scene;
    const int factor = *rc::gen::map(rc::gen::inRange(1, 3), [](int k) { return 1 << k; });
    finer.outputs *= factor;
    finer.steps_per_output /= factor;
    const Recording one = record(scene.read().run), two = record(finer.read().run);
    RC_CLASSIFY(!one.events.empty(), "contact");
    const auto rows = static_cast<std::size_t>(factor);
    for (std::size_t k = 0; k < one.times.size(); ++k)
      for (std::size_t i = 0; i < one.mesh.nodes(); ++i)
        if (one.displacement(k)[i] != two.displacement(rows * k)[i] || one.velocity(k)[i] != two.velocity(rows * k)[i])
          RC_FAIL(fmt::format("at t = {}, node {}: u = {} and {}, v = {} and {} with {} times the outputs",
                              one.times[k], i, one.displacement(k)[i], two.displacement(rows * k)[i],
                              one.velocity(k)[i], two.velocity(rows * k)[i], factor));
    RC_ASSERT(one.statistics.steps == two.statistics.steps);
    RC_ASSERT(one.events.size() == two.events.size());
    for (std::size_t k = 0; k < one.events.size(); ++k) RC_ASSERT(one.events[k].time == two.events[k].time);
  });
}

TEST(Output, TheSceneAsUnderstoodIsTheSceneAgain) {
  expect_always([] {
    const RandomScene scene = *scenes();
    const SceneFile read = scene.read();
    const SceneFile again = parse_scene("", "empty.toml", overrides_of(read.description()));
    RC_ASSERT(again.description() == read.description());
    const Recording one = record(read.run), two = record(again.run);
    RC_ASSERT(one.u == two.u);
    RC_ASSERT(one.v == two.v);
    RC_ASSERT(one.reaction_left == two.reaction_left);
    RC_ASSERT(one.reaction_right == two.reaction_right);
  });
}

}  // namespace
}  // namespace viscobar::properties
