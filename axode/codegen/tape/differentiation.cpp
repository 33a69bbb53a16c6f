#include "axode/codegen/tape/differentiation.hpp"

namespace axode::codegen {
namespace {

using enum Tape::Operation;
using Traces = Composition::Traces;

bool is_zero(const Trace& x) { return x.is_constant() && x.factor() == 0; }

/// The derivatives of the value y of a node by its two operands.
std::array<Trace, 2> partials(const Tape::Node& node, const Trace& y) {
  const Trace a = Tape::number(node.a), b = Tape::number(node.b);
  switch (node.operation) {
    case scale: return {node.factor, 0};
    case sum: return {1, node.factor};
    case product: return {b, a};
    case reciprocal: return {-(y * y), 0};
    case root: return {0.5 / y, 0};
    case sine: return {cos(a), 0};
    case cosine: return {-sin(a), 0};
    case angle: {
      const Trace r = 1 / (a * a + b * b);
      return {b * r, -(a * r)};
    }
    case choice: {
      const Trace::Condition first = Tape::truth(node.condition);
      return {select(first, 1, 0), select(first, 0, 1)};
    }
    default: return {};
  }
}

}  // namespace

Traces Composition::argument(const std::string& name, int n) {
  inputs_.emplace_back();
  for (int k = 0; k < n; ++k)
    inputs_.back().push_back(tape_.input(static_cast<int>(recording_.arguments.size()), k));
  recording_.arguments.push_back(name);
  recording_.lengths.push_back(n);
  return inputs_.back();
}

std::vector<Traces> Composition::arguments_of(const Recording& f) {
  std::vector<Traces> all;
  for (std::size_t k = 0; k < f.arguments.size(); ++k) all.push_back(argument(f.arguments[k], f.lengths[k]));
  return all;
}

Traces Composition::operator()(const Recording& f, std::span<const Traces> arguments) {
  const std::vector<char> need = needed(f);
  Traces x(need.size());
  std::vector<Trace::Condition> truth(need.size());
  for (std::size_t k = 0; k < need.size(); ++k) {
    if (!need[k]) continue;
    const Tape::Node& node = f.nodes[k];
    const std::size_t a = node.a, b = node.b;
    switch (node.operation) {
      case one: x[k] = 1; break;
      case input: x[k] = arguments[a][b]; break;
      case scale: x[k] = node.factor * x[a]; break;
      case sum: x[k] = x[a] + node.factor * x[b]; break;
      case product: x[k] = x[a] * x[b]; break;
      case reciprocal: x[k] = 1 / x[a]; break;
      case root: x[k] = sqrt(x[a]); break;
      case sine: x[k] = sin(x[a]); break;
      case cosine: x[k] = cos(x[a]); break;
      case angle: x[k] = atan2(x[a], x[b]); break;
      case choice: x[k] = select(truth[node.condition], x[a], x[b]); break;
      case less: truth[k] = x[a] < x[b]; break;
      case less_equal: truth[k] = x[a] <= x[b]; break;
      case both: truth[k] = truth[a] && truth[b]; break;
      case either: truth[k] = truth[a] || truth[b]; break;
      case negation: truth[k] = !truth[a]; break;
    }
  }
  const auto now = [&](const Trace& result) {
    return result.factor() * (result.is_constant() ? Trace(1) : x[result.node()]);
  };
  Traces results;
  for (const Trace& result : f.results) results.push_back(now(result));
  recording_.returns_singularity = recording_.returns_singularity || f.returns_singularity;
  recording_.maybe_singular =
      recording_.maybe_singular ||
      (f.maybe_singular.is_constant() ? f.maybe_singular : truth[f.maybe_singular.node()]);
  return results;
}

std::size_t Composition::node(std::size_t argument, std::size_t entry) const {
  return inputs_[argument][entry].node();
}

Traces Composition::along(const Traces& x, std::span<const Traces> direction) const {
  const Recording made{.nodes = tape_.nodes(), .results = x};
  return along(made, needed(made), direction);
}

Traces Composition::along(const Recording& made, const std::vector<char>& need,
                          std::span<const Traces> direction) const {
  Traces d(need.size());
  for (std::size_t i = 0; i < direction.size(); ++i)
    for (std::size_t k = 0; k < direction[i].size(); ++k) d[node(i, k)] = direction[i][k];
  for (std::size_t k = 1; k < need.size(); ++k) {
    const Tape::Node& node = made.nodes[k];
    if (!need[k] || node.operation == input) continue;
    const Trace &da = d[node.a], &db = d[node.b];
    if (is_zero(da) && is_zero(db)) continue;
    const auto [by_a, by_b] = partials(node, Tape::number(static_cast<int>(k)));
    d[k] = by_a * da + by_b * db;
  }
  Traces change;
  for (const Trace& result : made.results) change.push_back(result.factor() * d[result.node()]);
  return change;
}

Traces Composition::gradient(const Traces& x, const Traces& w, std::size_t arguments) const {
  const std::vector<Tape::Node> nodes = tape_.nodes();
  Traces by(nodes.size());
  for (std::size_t k = 0; k < x.size(); ++k) by[x[k].node()] += x[k].factor() * w[k];
  for (std::size_t k = by.size(); k-- > 1;) {
    if (is_zero(by[k]) || nodes[k].operation == input) continue;
    const auto [by_a, by_b] = partials(nodes[k], Tape::number(static_cast<int>(k)));
    by[nodes[k].a] += by[k] * by_a;
    by[nodes[k].b] += by[k] * by_b;
  }
  Traces out;
  for (std::size_t i = 0; i < arguments; ++i)
    for (std::size_t k = 0; k < inputs_[i].size(); ++k) out.push_back(by[node(i, k)]);
  return out;
}

Traces Composition::jacobian(const Traces& x, std::size_t arguments) const {
  const Recording made{.nodes = tape_.nodes(), .results = x};  // a copy of the tape, because each column adds
                                                               // nodes to it
  const std::vector<char> need = needed(made);
  std::vector<Traces> direction;
  for (std::size_t i = 0; i < arguments; ++i) direction.emplace_back(inputs_[i].size());
  Traces columns;
  for (Traces& part : direction)
    for (Trace& entry : part) {
      entry = 1;
      const Traces column = along(made, need, direction);
      columns.insert(columns.end(), column.begin(), column.end());
      entry = 0;
    }
  return columns;
}

Recording Composition::with(const std::string& result, Traces results) {
  recording_.result = result;
  recording_.results = std::move(results);
  recording_.nodes = tape_.nodes();
  return std::move(recording_);
}

Recording jacobian_of(const Recording& f) {
  Composition on;
  const std::vector<Traces> x = on.arguments_of(f);
  return on.with("jac", on.jacobian(on(f, x), x.size()));
}

Recording tangent_of(const Recording& f) {
  Composition on;
  const std::vector<Traces> x = on.arguments_of(f);
  std::vector<Traces> direction;
  for (std::size_t k = 0; k < x.size(); ++k)
    direction.push_back(on.argument("fwd_" + f.arguments[k], f.lengths[k]));
  return on.with("fwd", on.along(on(f, x), direction));
}

Traces Weights::on(Composition& composition) const {
  Traces w;
  for (std::size_t k = 0; k < names.size(); ++k)
    for (const Trace& x : composition.argument(names[k], lengths[k])) w.push_back(x);
  return w;
}

Recording adjoint_of(const Recording& f, const Weights& weights) {
  Composition on;
  const std::vector<Traces> x = on.arguments_of(f);
  const Traces w = weights.on(on);
  return on.with("adj", on.gradient(on(f, x), w, x.size()));
}

Recording hessian_of(const Recording& f, const Weights& weights) {
  Composition on;
  const std::vector<Traces> x = on.arguments_of(f);
  const Traces w = weights.on(on);
  return on.with("hess", on.jacobian(on.gradient(on(f, x), w, x.size()), x.size()));
}

}  // namespace axode::codegen
