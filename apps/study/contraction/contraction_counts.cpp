#include "apps/study/contraction/contraction_counts.hpp"

#include "apps/study/contraction/tree_contraction.hpp"
#include "apps/study/longest_path.hpp"

namespace axode::command {

std::vector<ContractionCount> contraction_counts(const Model& model, const State& state) {
  const Tree<double>& of_model = model.tree<double>();
  const Tree<Counted> tree = cast<Counted>(of_model);
  const auto counted = [](const auto& numbers) {
    return std::vector<Counted>(numbers.begin(), numbers.end());
  };
  const std::vector<Counted> q = counted(state.q), v = counted(state.v), tau = counted(state.a);
  std::vector<Counted> a(v.size());
  std::vector<ContractionCount> out;
  for (int most_rounds = 0;; ++most_rounds) {
    const ContractionPlan plan(of_model, most_rounds);
    if (most_rounds > 0 && plan.compressions == out.back().compressions) return out;
    TreeContraction<Counted> contraction(of_model, plan);
    LongestPath path(tree->n);
    Counted::count() = {};
    if (!contraction.run(tree, q.data(), v.data(), tau.data(), a.data(), path)) return out;
    out.push_back({plan.rounds, plan.compressions, Counted::count(), path.operations()});
  }
}

}  // namespace axode::command
