#include <cstring>

#include "tests/laws/law.hpp"
#include "tests/support/functions.hpp"
#include "tests/support/refused_arguments.hpp"

/// Laws that hold for every function of the catalogue, in every representation and for the fast path.
namespace axode::test {
namespace {

using catalog::Function, catalog::Input;

class EveryFunction : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, EveryFunction, testing::ValuesIn(cases_with_fast()), name_of);

/// The results of a call, or the message with which it was refused.
template <class T> struct ResultOfCall {
  std::vector<T> numbers;
  Solvability solvability;
  std::string refusal;  ///< the message of the exception; empty if there was none

  bool operator==(const ResultOfCall& other) const {
    return numbers.size() == other.numbers.size() && refusal == other.refusal &&
           solvability == other.solvability &&
           std::equal(numbers.begin(), numbers.end(), other.numbers.begin(), [](T x, T y) {
             return std::memcmp(&x, &y, sizeof x) == 0 || (std::isnan(x) && std::isnan(y));
           });
  }
};

/// A model with two sets of arguments that suit every function.
template <class T> class Calls {
 public:
  Calls(const TreeRecipe& recipe, Random<double> random)
      : model(ModelBuilder(random_description(random, recipe)).build()),
        arguments(model, random),
        others(model, random),
        workspace(model) {}

  const Model model;
  Arguments<T> arguments;
  const Arguments<T> others;
  Workspace<T> workspace;

  std::size_t size(const Function<T>& function) const {
    return function.size(model, arguments.wrenches.size());
  }
  /// Calls a function that writes its results into `out`.
  ResultOfCall<T> call(const Function<T>& function, const catalog::Arguments<T>& given, std::span<T> out) {
    ResultOfCall<T> outcome;
    try {
      outcome.solvability = function.call(model, workspace, given, out);
    } catch (const std::invalid_argument& error) {
      return {{}, {}, error.what()};
    } catch (const std::domain_error& error) {  // no body has mass
      return {{}, {}, error.what()};
    }
    outcome.numbers.assign(out.begin(), out.end());
    return outcome;
  }
  ResultOfCall<T> call(const Function<T>& function, const catalog::Arguments<T>& given) {
    std::vector<T> out(size(function));
    return call(function, given, out);
  }
  ResultOfCall<T> call(const Function<T>& function) { return call(function, arguments.given()); }
};

const TreeRecipe small{.most_bodies = 8};

/// Calls law(calls, function) for every function.
template <class Law> void for_functions(const Case& c, int trees, const TreeRecipe& recipe, const Law& law) {
  with_scalar(c, [&](auto scalar) {
    using T = decltype(scalar);
    for_seeds(trees, [&](std::uint64_t seed) {
      Calls<T> calls(recipe, Random<double>(seed));
      for (const Function<T>& function : functions_of<T>(c)) {
        SCOPED_TRACE(function.name);
        law(calls, function);
      }
    });
  });
}

TEST_P(EveryFunction, InPlaceIsRightOrRefused) {
  int right = 0, refused = 0;
  for_functions(GetParam(), 50, small, [&]<class T>(Calls<T>& calls, const Function<T>& function) {
    const ResultOfCall<T> separate = calls.call(function);
    for (const Input input : inputs_of_numbers(function))
      for (const std::ptrdiff_t shift : {0, 1, -1}) {  // how far the result begins behind the argument
        SCOPED_TRACE(std::string(to_string(input)) + " shifted by " + std::to_string(shift));
        catalog::Arguments<T> given = calls.arguments.given();
        std::span<const T>& argument = catalog::numbers(given, input);
        const std::size_t size = calls.size(function);
        std::vector<T> memory(std::max(argument.size(), size) + 1);
        T* const begin = memory.data() + std::max<std::ptrdiff_t>(0, -shift);
        std::copy(argument.begin(), argument.end(), begin);
        argument = {begin, argument.size()};
        const ResultOfCall<T> in_place = calls.call(function, given, {begin + shift, size});
        if (in_place.refusal.find("shares memory") != std::string::npos) {
          ++refused;
        } else {
          ++right;
          EXPECT_TRUE(in_place == separate) << in_place.refusal;
        }
      }
  });
  EXPECT_GT(right, refused);
}

TEST_P(EveryFunction, RemembersNothing) {
  for_functions(GetParam(), 50, small, [&]<class T>(Calls<T>& calls, const Function<T>& function) {
    Arguments<T> none = calls.others;  // will hold NaN
    for (std::vector<T>* numbers : {&none.v, &none.a, &none.tau, &none.p})
      std::fill(numbers->begin(), numbers->end(), std::numeric_limits<T>::quiet_NaN());
    Workspace<T> used = calls.workspace;  // has been used by the functions before this one
    calls.workspace = Workspace<T>(calls.model);
    const ResultOfCall<T> fresh = calls.call(function);
    calls.workspace = std::move(used);
    calls.call(function, calls.others.given());
    EXPECT_TRUE(calls.call(function) == fresh) << "after another state";
    calls.call(function, none.given());
    EXPECT_TRUE(calls.call(function) == fresh) << "after NaN";
  });
}

TEST_P(EveryFunction, RefusesWrongSizes) {
  for_functions(GetParam(), 20, small, [&]<class T>(Calls<T>& calls, const Function<T>& function) {
    for (const Input input : inputs_of_numbers(function))
      for (const int change : {-1, 1}) {
        catalog::Arguments<T> given = calls.arguments.given();
        std::span<const T>& argument = catalog::numbers(given, input);
        if (argument.empty() && change < 0) continue;
        std::vector<T> numbers(argument.begin(), argument.end());
        numbers.resize(numbers.size() + static_cast<std::size_t>(change));
        argument = numbers;
        const std::string refusal = calls.call(function, given).refusal;
        EXPECT_NE(refusal.find(" has " + std::to_string(numbers.size()) + " entries"), std::string::npos)
            << refusal;
      }
    if (function.shape.empty()) return;  // the result is one number, for which the caller always has memory
    std::size_t n_entries = 1;
    for (const catalog::Extent extent : function.shape)
      n_entries *= value_of(extent, calls.model, calls.arguments.wrenches.size());
    const std::size_t size = calls.size(function), entry = n_entries == 0 ? 6 : size / n_entries;
    std::vector<T> memory(size + entry);
    for (const std::size_t wrong : {size - std::min(size, entry), size + entry})
      if (wrong != size) {
        const std::string refusal =
            calls.call(function, calls.arguments.given(), {memory.data(), wrong}).refusal;
        EXPECT_NE(refusal.find(" entries; expected "), std::string::npos) << refusal;
      }
  });
}

TEST_P(EveryFunction, RefusesAWorkspaceOfASmallerModel) {
  for_functions(GetParam(), 20, small, [&]<class T>(Calls<T>& calls, const Function<T>& function) {
    if (calls.model.n_bodies() < 2) return;
    const Workspace<T> own = calls.workspace;
    calls.workspace = Workspace<T>(one_body());
    const std::string refusal = calls.call(function).refusal;
    EXPECT_TRUE(refusal.starts_with("workspace: made for 1 bodies")) << refusal;
    calls.workspace = own;
  });
}

TEST_P(EveryFunction, RefusesQuaternionsThatAreNotOfUnitNorm) {
  const double allowed = GetParam().single ? 5e-5 : 5e-7;
  const TreeRecipe recipe{.most_bodies = 8, .one_free_root = true};
  for_functions(GetParam(), 20, recipe, [&]<class T>(Calls<T>& calls, const Function<T>& function) {
    const Joint& joint = calls.model.joint(1);
    ASSERT_EQ(joint.nq, 7);
    for (const double norm : {1 + allowed, 1 + 4 * allowed, 2.0, 0.0, std::nan("")}) {
      catalog::Arguments<T> given = calls.arguments.given();
      std::vector<T> q = calls.arguments.q;
      for (int k = joint.iq; k < joint.iq + joint.nq; ++k) q[static_cast<std::size_t>(k)] *= T(norm);
      given.q = q;
      const std::string refusal = calls.call(function, given).refusal;
      if (norm == 1 + allowed) {
        EXPECT_EQ(refusal.find("must be 1 to 1e-0"), std::string::npos) << refusal;
      } else {
        EXPECT_TRUE(refusal.starts_with("q: ")) << refusal;
        EXPECT_NE(refusal.find('"' + joint.name + '"'), std::string::npos) << refusal;
        EXPECT_NE(refusal.find("must be 1 to 1e-0"), std::string::npos) << refusal;
      }
    }
  });
}

TEST_P(EveryFunction, RefusesFramesThatDoNotExist) {
  for_functions(GetParam(), 20, small, [&]<class T>(Calls<T>& calls, const Function<T>& function) {
    const int n = calls.model.n_frames();
    for (const int frame : {-1, n}) {
      const auto expect_refused = [&](const catalog::Arguments<T>& given, const std::string& argument) {
        const std::string refusal = calls.call(function, given).refusal;
        EXPECT_TRUE(refusal.starts_with(argument)) << refusal;
        EXPECT_NE(refusal.find(std::to_string(frame)), std::string::npos) << refusal;
        EXPECT_NE(refusal.find("has frames 0 to " + std::to_string(n - 1)), std::string::npos) << refusal;
      };
      catalog::Arguments<T> loaded = calls.arguments.given(), placed = loaded, based = loaded;
      std::vector<AppliedWrench<T>> wrenches = calls.arguments.wrenches;
      wrenches.back().frame = frame;
      loaded.loads.wrenches = wrenches;
      placed.place.frame = based.base.frame = frame;
      if (function.takes_input(Input::loads)) expect_refused(loaded, "loads: ");
      if (function.takes_input(Input::place)) expect_refused(placed, "");
      if (function.takes_input(Input::base)) expect_refused(based, "");
    }
  });
}

TEST_P(EveryFunction, NotFiniteIsSaid) {
  int said = 0, well = 0;
  const TreeRecipe recipe{.most_bodies = 8, .always_mass = true, .one_free_root = true};
  for_functions(GetParam(), 50, recipe, [&]<class T>(Calls<T>& calls, const Function<T>& function) {
    if (!function.may_fail) return;
    const auto check = [&](const ResultOfCall<T>& outcome, const auto&... where) {
      if (!outcome.refusal.empty()) return;
      const bool finite =
          std::all_of(outcome.numbers.begin(), outcome.numbers.end(), [](T x) { return std::isfinite(x); });
      EXPECT_TRUE((finite || !outcome.solvability.ok())) << testing::PrintToString(std::tuple(where...));
      ++(outcome.solvability.ok() ? well : said);
    };
    check(calls.call(function));
    const T nan = std::numeric_limits<T>::quiet_NaN(), infinity = std::numeric_limits<T>::infinity(),
            huge = T(1e-8) * std::numeric_limits<T>::max();
    for (const Input input : inputs_of_numbers(function)) {
      catalog::Arguments<T> given = calls.arguments.given();
      std::span<const T>& argument = catalog::numbers(given, input);
      std::vector<T> numbers(argument.begin(), argument.end());
      argument = numbers;
      for (T& x : numbers)
        for (const T wrong : {nan, infinity, huge}) {
          const T right = std::exchange(x, wrong);
          check(calls.call(function, given), to_string(input), "has", wrong);
          x = right;
        }
    }
    if (!function.takes_input(Input::place)) return;
    for (const T wrong : {nan, infinity, huge}) {
      SCOPED_TRACE("a place at " + std::to_string(wrong));
      catalog::Arguments<T> given = calls.arguments.given();
      given.place.offset.r.x = wrong;
      check(calls.call(function, given));
    }
  });
  EXPECT_GT(said, 100);
  EXPECT_GT(well, 100);
}

}  // namespace
}  // namespace axode::test
