#include <gtest/gtest.h>

#include <cmath>

#include "axode/codegen.hpp"
#include "axode/io.hpp"
#include "tests/codegen/compiled.hpp"
#include "tests/support/comparison.hpp"
#include "tests/support/random_tree.hpp"
#include "tests/support/refused_arguments.hpp"
#include "tests/support/run_program.hpp"

/// Generated functions for CasADi, called in the way in which CasADi calls them. Their values, derivatives
/// and sparsity patterns are compared in tests/bridges/casadi.
namespace axode::test {
namespace {

using catalog::Id;
using codegen::Function;
using Numbers = std::vector<double>;

Model machine() { return load(robot("machine.toml"), Base::as_described); }

codegen::Source source_for_casadi(const Model& model, const std::vector<Function>& functions,
                                  int states = 1) {
  return codegen::c_source(model, functions, {.prefix = "m", .abi = codegen::Abi::casadi, .states = states});
}

/// A function in a compiled library, with the descriptions of itself that CasADi asks for.
class External {
 public:
  External(const Compiled& library, const std::string& name) : library_(library), name_(name) {}
  long long n_in() const { return library_.function<long long()>(name_ + "_n_in")(); }
  long long n_out() const { return library_.function<long long()>(name_ + "_n_out")(); }
  /// Calls the function and returns the entries of all results. Arguments without entries are passed as null
  /// pointers.
  std::vector<Numbers> operator()(const std::vector<Numbers>& arguments) const {
    long long sizes[4];
    library_.function<int(long long*, long long*, long long*, long long*)>(name_ + "_work")(
        &sizes[0], &sizes[1], &sizes[2], &sizes[3]);
    std::vector<const double*> arg;
    for (const Numbers& x : arguments) arg.push_back(x.empty() ? nullptr : x.data());
    arg.resize(static_cast<std::size_t>(n_in()), nullptr);
    std::vector<Numbers> results;
    std::vector<double*> res;
    for (int i = 0; i < n_out(); ++i) results.emplace_back(entries(i), std::nan(""));
    for (Numbers& x : results) res.push_back(x.data());
    Numbers w(static_cast<std::size_t>(sizes[3]));
    status_ = library_.function<int(const double**, double**, long long*, double*, int)>(name_)(
        arg.data(), res.data(), nullptr, w.data(), 0);
    return results;
  }
  int status() const { return status_; }

 private:
  /// The number of entries of result i.
  std::size_t entries(int i) const {
    const long long* p = library_.function<const long long*(long long)>(name_ + "_sparsity_out")(i);
    const bool dense = p[2] == 1;
    return static_cast<std::size_t>(dense ? p[0] * p[1] : p[2 + p[1]]);
  }

  const Compiled& library_;
  std::string name_;
  mutable int status_ = 0;
};

const std::vector<Function> all{{Id("forward_dynamics")},
                                {Id("inverse_dynamics")},
                                {Id("mass_matrix")},
                                {Id("inverse_mass_matrix")},
                                {Id("poses")},
                                {Id("pose"), 9},
                                {Id("jacobian"), 9, Representation::mixed}};

TEST(FunctionsForCasadi, TakeNothingForZeroAndTellWhatIsSingular) {
  const Model model = machine();
  const Compiled library(
      source_for_casadi(model, {{Id("forward_dynamics")}, {Id("inverse_mass_matrix")}}).text);
  const External f(library, "m_forward_dynamics");
  const Numbers q = neutral(model), zero(static_cast<std::size_t>(model.nv()));
  EXPECT_EQ(f({q})[0], f({q, zero, zero})[0]);
  EXPECT_EQ(f.status(), 0);
  f({Numbers(q.size(), std::nan(""))});
  EXPECT_EQ(f.status(), 1);
  for (const std::string derivative : {"", "fwd1_", "adj1_", "jac_"}) {
    const External A(library, derivative + "m_inverse_mass_matrix");
    A({q});
    EXPECT_EQ(A.status(), 0);
    A({Numbers(q.size(), std::nan(""))});
    EXPECT_EQ(A.status(), 1) << derivative;
  }
}

/// The derivatives in more detail, and those of second order, are compared in tests/bridges/casadi.
TEST(FunctionsForCasadi, HaveTheFirstDerivativesOfDifferences) {
  const Model model = load(robot("arm7.toml"), Base::as_described);
  const Compiled library(
      source_for_casadi(model, {{Id("inverse_dynamics")}, {Id("inverse_mass_matrix")}}).text);
  Random<double> random(1);
  for (const std::string name : {"inverse_dynamics", "inverse_mass_matrix"}) {
    const External f(library, "m_" + name), derivative(library, "fwd1_m_" + name);
    std::vector<Numbers> x, direction;
    for (long long k = 0; k < f.n_in(); ++k) {
      x.push_back(random_numbers(random, model.nv()));
      direction.push_back(random_numbers(random, model.nv()));
    }
    const auto at = [&](double h) {
      std::vector<Numbers> there = x;
      for (std::size_t k = 0; k < x.size(); ++k)
        for (std::size_t c = 0; c < x[k].size(); ++c) there[k][c] += h * direction[k][c];
      return f(there)[0];
    };
    std::vector<Numbers> given = x;
    given.push_back(at(0));
    given.insert(given.end(), direction.begin(), direction.end());
    constexpr double h = 1e-5;
    Numbers difference = at(h);
    const Numbers before = at(-h);
    for (std::size_t k = 0; k < before.size(); ++k) difference[k] = (difference[k] - before[k]) / (2 * h);
    Comparison change(name.c_str(), 1e-7);
    change.expect_equal(derivative(given)[0], difference);
  }
}

TEST(FunctionsForCasadi, CompileWithoutWarningsAsC99AndAsCpp) {
  const TemporaryFolder folder;
  for (const auto& [robot_file, base] :
       {std::pair("machine.toml", Base::as_described), std::pair("arm7.toml", Base::fixed)}) {
    const std::string file =
        folder.write("generated.c", source_for_casadi(load(robot(robot_file), base), all, 2).text);
    for (const std::vector<std::string>& language :
         {std::vector<std::string>{"-x", "c", "-std=c99"}, {"-x", "c++"}}) {
      std::vector<std::string> words{AXODE_COMPILER, "-Wall",   "-Wextra",
                                     "-pedantic",    "-Werror", "-fsyntax-only"};
      words.insert(words.end(), language.begin(), language.end());
      words.push_back(file);
      EXPECT_EQ(run(words).err, "") << robot_file;
    }
  }
}

TEST(FunctionsForCasadi, RefuseWhatTheyCannotBe) {
  const Model model = machine();
  const auto refusal = [&](Id quantity, const codegen::Options& options) {
    return message_of([&] { codegen::c_source(model, std::vector<Function>{{quantity}}, options); });
  };
  constexpr auto casadi = codegen::Abi::casadi;
  EXPECT_EQ(refusal(Id("forward_dynamics_vjp"), {.abi = casadi}),
            "forward_dynamics_vjp comes with forward_dynamics for CasADi, as jac_, fwd1_, adj1_ and "
            "jac_adj1_; generate that function instead");
  EXPECT_EQ(refusal(Id("mass_matrix"), {.single_precision = true, .abi = casadi}),
            "single_precision is set, but CasADi computes in double precision");
  EXPECT_EQ(refusal(Id("mass_matrix"), {.prefix = "a__b", .abi = casadi}),
            "the prefix \"a__b\" is not a name in CasADi: underscores must be single, and between letters or "
            "digits");
  EXPECT_EQ(refusal(Id("mass_matrix"), {.abi = casadi, .states = 0}), "states is 0; expected 1 or more");
  const std::string too_many = refusal(Id("mass_matrix"), {.abi = casadi, .states = 2'000'000'000});
  EXPECT_TRUE(too_many.starts_with("states is 2000000000; ") &&
              too_many.ends_with(" would have more than 2147483647 entries for so many states"))
      << too_many;
  EXPECT_EQ(refusal(Id("mass_matrix"), {.states = 2}),
            "states is an option of functions for CasADi (abi = casadi); other functions compute one state");
}

}  // namespace
}  // namespace axode::test
