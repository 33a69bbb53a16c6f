#include "tests/support/subject.hpp"

#include <stdexcept>

#include "axode/constraints/loops.hpp"
#include "tests/support/functions.hpp"

namespace axode::test {

namespace {

std::vector<Case> make_cases(bool with_fast) {
  std::vector<Case> all;
  for (const bool single : {false, true}) {
    const std::string scalar = single ? "_float" : "_double";
    for (const Representation r : representations) all.push_back({name(r) + scalar, r, false, single});
    if (with_fast) all.push_back(fast(all.back()));
  }
  return all;
}

template <class T> const catalog::Function<T>& function_of(const Case& c, std::string_view wanted) {
  for (const catalog::Function<T>& function : functions_of<T>(c))
    if (function.name == wanted) return function;
  throw std::logic_error(c.name + " has no function " + std::string(wanted));
}

template <class T> class SubjectOf : public Subject {
 public:
  SubjectOf(const Case& c, const Model& model, const Model& workspace_of)
      : case_(c),
        model_(model),
        workspace_(model.loops().empty() ? Workspace<T>(workspace_of)
                                         : Workspace<T>(workspace_of, cut_tree)) {
    if (!model.loops().empty()) loops_.emplace(workspace_of);
  }

  Answer call(std::string_view wanted, const Ask& ask) override {
    return call(wanted, ask, function_of<T>(case_, wanted).size(model_, ask.loads.wrenches.size()));
  }
  Answer call(std::string_view wanted, const Ask& ask, std::size_t size) override {
    const catalog::Function<T>& function = function_of<T>(case_, wanted);
    const Arguments<T> arguments(ask);
    std::vector<T> out(size);
    const Solvability solvability = loops_ && function.call_with_loops != nullptr
                                        ? function.call_with_loops(model_, *loops_, arguments.given(), out)
                                        : function.call(model_, workspace_, arguments.given(), out);
    return {cast<double>(out), solvability};
  }

 private:
  Case case_;
  Model model_;
  Workspace<T> workspace_;
  std::optional<LoopWorkspace<T>> loops_;  ///< for mechanisms with loops
};

}  // namespace

const std::vector<Case>& cases() {
  static const std::vector<Case> all = make_cases(false);
  return all;
}
const std::vector<Case>& cases_with_fast() {
  static const std::vector<Case> all = make_cases(true);
  return all;
}
const std::vector<Case>& scalars() {
  static const std::vector<Case> all{{"double", Representation::hybrid, false, false},
                                     {"float", Representation::hybrid, false, true}};
  return all;
}
Case in(Representation representation, const Case& c) {
  return {name(representation) + std::string(c.single ? "_float" : "_double"), representation, false,
          c.single};
}
Case fast(const Case& c) {
  return {c.single ? "fast_float" : "fast_double", Representation::body, true, c.single};
}
Case in_double(const Case& c) {
  const Case exact{"", c.representation, c.fast, false};
  return c.fast ? fast(exact) : in(c.representation, exact);
}

Six changed_twist(Representation to, Representation from, const SE3<>& C, const Six& V) {
  return with_representation(to, [&](auto t) {
    return with_representation(from,
                               [&](auto f) { return six(change<decltype(t)>(C, twist_of<decltype(f)>(V))); });
  });
}
Six changed_rate(Representation to, Representation from, const SE3<>& C, const Six& V, const Six& dV) {
  return with_representation(to, [&](auto t) {
    return with_representation(from, [&](auto f) {
      return six(change<decltype(t)>(C, twist_of<decltype(f)>(V), rate_of<decltype(f)>(dV)));
    });
  });
}
Six changed_wrench(Representation to, Representation from, const SE3<>& C, const Six& W) {
  return with_representation(to, [&](auto t) {
    return with_representation(
        from, [&](auto f) { return six(change<decltype(t)>(C, wrench_of<decltype(f)>(W))); });
  });
}

std::unique_ptr<Subject> subject(const Case& c, const Model& model) { return subject(c, model, model); }
std::unique_ptr<Subject> subject(const Case& c, const Model& model, const Model& workspace_of) {
  if (c.single) return std::make_unique<SubjectOf<float>>(c, model, workspace_of);
  return std::make_unique<SubjectOf<double>>(c, model, workspace_of);
}

std::vector<SE3<>> poses_of(const std::vector<double>& numbers) {
  std::vector<SE3<>> C;
  for (std::size_t k = 0; k + 12 <= numbers.size(); k += 12) {
    const double* x = &numbers[k];
    C.push_back({{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, {x[6], x[7], x[8]}}, {x[9], x[10], x[11]}});
  }
  return C;
}
std::vector<Six> sixes_of(const std::vector<double>& numbers) {
  std::vector<Six> all;
  for (std::size_t k = 0; k + 6 <= numbers.size(); k += 6) {
    const double* x = &numbers[k];
    all.push_back({{x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
  }
  return all;
}
std::vector<Vec3<>> vectors_of(const std::vector<double>& numbers) {
  std::vector<Vec3<>> all;
  for (std::size_t k = 0; k + 3 <= numbers.size(); k += 3)
    all.push_back({numbers[k], numbers[k + 1], numbers[k + 2]});
  return all;
}

State<double> rounded(const Case& c, const State<double>& state) {
  return c.single ? cast<double>(cast<float>(state)) : state;
}

}  // namespace axode::test
