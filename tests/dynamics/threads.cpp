#include <functional>
#include <thread>

#include "tests/laws/law.hpp"
#include "tests/support/functions.hpp"

/// Several threads may use one model, each with a workspace of its own. No call leaves anything in the
/// workspace that changes later results.
namespace axode::test {
namespace {

class Threads : public Law {};
INSTANTIATE_TEST_SUITE_P(Dynamics, Threads, testing::ValuesIn(cases_with_fast()), name_of);

/// Hashes of the bits of all results: of every function at all states, one after the other.
using Fingerprints = std::vector<std::size_t>;
template <class T>
Fingerprints results(const Case& c, const Model& model, const std::vector<Arguments<T>>& states) {
  Fingerprints all;
  std::vector<T> out;
  Workspace<T> workspace(model);
  for (const catalog::Function<T>& function : functions_of<T>(c))
    for (const Arguments<T>& state : states) {
      out.assign(function.size(model, state.wrenches.size()), T(0));
      static_cast<void>(function.call(model, workspace, state.given(), out));
      const std::string_view bits(reinterpret_cast<const char*>(out.data()), out.size() * sizeof(T));
      all.push_back(std::hash<std::string_view>{}(bits));
    }
  return all;
}

Model any_tree(Random<double>& random) {
  return ModelBuilder(with_springs(described(random_mechanism(random), random), random)).build();
}

TEST_P(Threads, AgreeToTheLastBit) {
  with_scalar(GetParam(), [&](auto scalar) {
    using T = decltype(scalar);
    Random<double> random(5);
    const Model model = any_tree(random);
    ASSERT_GT(model.n_bodies(), 5);
    std::vector<Arguments<T>> states;
    for_seeds(25, [&](std::uint64_t) { states.emplace_back(model, random); });

    const Fingerprints alone = results<T>(GetParam(), model, states);
    std::vector<Fingerprints> together(2);
    std::vector<std::thread> threads;
    for (Fingerprints& mine : together)
      threads.emplace_back([&] { mine = results<T>(GetParam(), model, states); });
    for (std::thread& thread : threads) thread.join();
    for (const Fingerprints& mine : together) EXPECT_TRUE(mine == alone);
  });
}

}  // namespace
}  // namespace axode::test
