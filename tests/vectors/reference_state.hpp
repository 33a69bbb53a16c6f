#pragma once
#include <gtest/gtest.h>

#include "axode/axode.hpp"
#include "tests/support/comparison.hpp"
#include "tests/support/vectors.hpp"

/// The states of the reference systems, and test suites that run through them.
namespace axode::test {

inline constexpr double bound = 1e-12;  // the largest difference, relative to the largest entry of a quantity

inline const std::string none = "none";  // the parameter of a suite if the files are absent
inline std::vector<std::string> systems() {
  const std::string ending = "_model.json";
  std::vector<std::string> names;
  for (const auto& file : files_ending_in(vectors_folder(), ending)) {
    const std::string name = file.filename().string();
    names.push_back(name.substr(0, name.size() - ending.size()));
  }
  return names.empty() ? std::vector{none} : names;
}
inline std::string name_of(const testing::TestParamInfo<std::string>& system) { return system.param; }

/// Calls f with each representation and its letter in the files, such as f(BodyFixed{}, "b").
template <class F> void each_representation(const F& f) {
  f(BodyFixed{}, "b"), f(Spatial{}, "s"), f(Hybrid{}, "h"), f(Mixed{}, "m");
}

/// A state of a reference system: the model, its coordinates and their derivatives, and reference values.
struct ReferenceState {
  const Json& kinematics;
  const Json& dynamics;
  Model model;
  Workspace<> workspace;
  std::vector<double> q, rates, tau;
  std::vector<std::size_t> place;  ///< place[j] is the index in q and v of joint j of the file
  std::vector<AppliedWrench<>> wrenches;

  ReferenceState(const ReferenceSystem& system, const Json& state, Telling telling)
      : kinematics(state.at("kinematics")),
        dynamics(state.at("dynamics")),
        model(system.build(telling)),
        workspace(model),
        q(ReferenceSystem::in_model_order(model, state.at("q"))),
        tau(ReferenceSystem::in_model_order(model, state.at("tau"))),
        place{0},
        wrenches(system.loads(model)) {
    for (const char* key : {"qd", "qdd", "qddd", "qdddd"})
      for (const double x : ReferenceSystem::in_model_order(model, state.at(key))) rates.push_back(x);
    for (int j = 1; j <= model.nv(); ++j) place.push_back(ReferenceSystem::place_of(model, j));
  }
  std::size_t n() const { return static_cast<std::size_t>(model.nv()); }
  int frame(int index) const { return ReferenceSystem::frame(model, index); }
  std::vector<double> rate(std::size_t k) const {
    return {rates.begin() + k * n(), rates.begin() + (k + 1) * n()};
  }
  std::vector<double> v() const { return rate(0); }
  std::vector<double> a() const { return rate(1); }

  /// An array with `dimensions` indices, each of them over the joints, brought from the order of the model
  /// into that of the files.
  std::vector<double> in_file_order(const std::vector<double>& x, int dimensions) const {
    std::vector<double> out;
    const auto walk = [&](const auto& self, int left, std::size_t at) -> void {
      if (left == 0) return out.push_back(x[at]);
      for (std::size_t j = 1; j <= n(); ++j) self(self, left - 1, at * n() + place[j]);
    };
    walk(walk, dimensions, 0);
    return out;
  }
};

/// A test suite that runs for every reference system.
class ReferenceStates : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == none) GTEST_SKIP() << missing(vectors_folder(), "AXODE_VECTORS");
  }
  /// Calls check(state) for every state whose file has the quantity, and for every way to describe the
  /// system.
  template <class Check>
  static void each_state_with(const char* part, const char* quantity, const Check& check) {
    const ReferenceSystem system(GetParam());
    ASSERT_FALSE(system.states.empty());
    if (!system.states.front().at(part).contains(quantity))
      GTEST_SKIP() << GetParam() << " comes without " << quantity;
    for (const Json& json : system.states)
      for (const Telling telling : tellings) {
        SCOPED_TRACE("state " + json.at("state").text() + ", told in way " +
                     std::to_string(static_cast<int>(telling)));
        ReferenceState state(system, json, telling);
        check(state);
      }
  }
};

}  // namespace axode::test
