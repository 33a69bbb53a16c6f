#include "axode/scalar/trace.hpp"

#include <bit>
#include <cstdint>
#include <stdexcept>
#include <utility>

namespace axode {
namespace {

thread_local Tape* current = nullptr;

using Operation = Tape::Operation;

/// Sums of constant factors below this fraction of the larger one count as 0: constants have rounding errors.
constexpr double rounding_of_constants = 0x1p-50;
double sum_of_factors(double a, double b) {
  const double sum = a + b;
  return std::abs(sum) <= rounding_of_constants * std::max(std::abs(a), std::abs(b)) ? 0 : sum;
}

}  // namespace

Tape::Tape() {
  if (current) throw std::logic_error("there is a Tape in this thread already");
  nodes_.push_back({Operation::one});
  current = this;
}
Tape::~Tape() { current = nullptr; }

std::size_t Tape::Hash::operator()(const Node& node) const {
  std::uint64_t hash = static_cast<std::uint64_t>(node.operation);
  for (const std::uint64_t word :
       {static_cast<std::uint64_t>(node.a), static_cast<std::uint64_t>(node.b),
        static_cast<std::uint64_t>(node.condition), std::bit_cast<std::uint64_t>(node.factor)}) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15U;
    hash ^= hash >> 32;
  }
  return hash;
}

Tape& Tape::of_this_thread() {
  if (!current) throw std::logic_error("a Trace needs a Tape in its thread, and there is none");
  return *current;
}
/// The node of an operation, which is appended to the tape if it is new.
int Tape::record(const Node& node) {
  Tape& tape = of_this_thread();
  const auto [at, is_new] = tape.known_.try_emplace(node, static_cast<int>(tape.nodes_.size()));
  if (is_new) tape.nodes_.push_back(node);
  return at->second;
}
const Tape::Node& Tape::at(int node) { return of_this_thread().nodes_[static_cast<std::size_t>(node)]; }

Trace Tape::input(int array, int index) { return Trace(1, record({Operation::input, array, index})); }

/// The recorded operation with the value of the Trace a, whose constant factor is recorded as a scaling.
int Tape::scaled(const Trace& a) {
  return a.node() != 0 && a.factor() == 1 ? a.node() : record({Operation::scale, a.node(), 0, 0, a.factor()});
}

/// The product of two recorded operations. A reciprocal 1/d cancels against a factor d.
Trace Tape::product(int a, int b) {
  for (const auto& [x, y] : {std::pair(a, b), std::pair(b, a)}) {
    if (at(x).operation != Operation::reciprocal) continue;
    const int divisor = at(x).a;
    if (divisor == y) return 1;
    if (at(y).operation != Operation::product) continue;
    if (at(y).a == divisor) return Trace(1, at(y).b);
    if (at(y).b == divisor) return Trace(1, at(y).a);
  }
  return Trace(1, record({Operation::product, std::min(a, b), std::max(a, b)}));
}

/// The sum of two terms, neither of which is 0. A sum of the form (u + k v) - u is folded to k v.
Trace Tape::sum(const Trace& a, const Trace& b) {
  if (a.node() == b.node()) return Trace(sum_of_factors(a.factor(), b.factor()), a.node());
  for (const auto& [x, y] : {std::pair(a, b), std::pair(b, a)}) {  // (u + k v) - u
    const Node& node = at(x.node());
    if (node.operation != Operation::sum) continue;
    const Trace u(x.factor(), node.a), v(x.factor() * node.factor, node.b);
    if (u.node() == y.node() && sum_of_factors(u.factor(), y.factor()) == 0) return v;
    if (v.node() == y.node() && sum_of_factors(v.factor(), y.factor()) == 0) return u;
  }
  const double size_a = std::abs(a.factor()), size_b = std::abs(b.factor());
  const bool a_leads = size_a == size_b ? a.node() < b.node() : size_a > size_b;
  const Trace &first = a_leads ? a : b, &second = a_leads ? b : a;
  return Trace(first.factor(),
               record({Operation::sum, first.node(), second.node(), 0, second.factor() / first.factor()}));
}

Trace::Condition Tape::truth(int node) {
  Trace::Condition result;
  result.node_ = node;
  return result;
}
Trace::Condition Tape::condition(Operation operation, int a, int b) {
  return truth(record({operation, a, b}));
}

Trace operator+(const Trace& a, const Trace& b) {
  if (a.is_constant() && b.is_constant()) return a.factor_ + b.factor_;
  if (a.factor_ == 0) return b;
  if (b.factor_ == 0) return a;
  return Tape::sum(a, b);
}
Trace operator*(const Trace& a, const Trace& b) {
  const double factor = a.factor_ * b.factor_;
  if (factor == 0 || b.is_constant()) return Trace(factor, a.node_);
  if (a.is_constant()) return Trace(factor, b.node_);
  const Trace product = Tape::product(a.node_, b.node_);
  return Trace(factor * product.factor_, product.node_);
}
Trace operator/(const Trace& a, const Trace& b) {
  if (b.is_constant()) return Trace(a.factor_ / b.factor_, a.node_);
  const Tape::Node& divisor = Tape::at(b.node_);
  const int reciprocal =
      divisor.operation == Operation::reciprocal ? divisor.a : Tape::record({Operation::reciprocal, b.node_});
  return a * Trace(1 / b.factor_, reciprocal);
}
Trace sqrt(const Trace& a) {
  return a.is_constant() ? Trace(std::sqrt(a.factor_))
                         : Trace(1, Tape::record({Operation::root, Tape::scaled(a)}));
}
Trace sin(const Trace& a) {
  if (a.is_constant()) return std::sin(a.factor_);
  return a.factor_ < 0 ? -sin(-a) : Trace(1, Tape::record({Operation::sine, Tape::scaled(a)}));
}
Trace cos(const Trace& a) {
  if (a.is_constant()) return std::cos(a.factor_);
  return a.factor_ < 0 ? cos(-a) : Trace(1, Tape::record({Operation::cosine, Tape::scaled(a)}));
}
Trace atan2(const Trace& a, const Trace& b) {
  if (a.is_constant() && b.is_constant()) return std::atan2(a.factor_, b.factor_);
  return Trace(1, Tape::record({Operation::angle, Tape::scaled(a), Tape::scaled(b)}));
}

Trace::Condition operator<(const Trace& a, const Trace& b) {
  if (a.is_constant() && b.is_constant()) return a.factor_ < b.factor_;
  return Tape::condition(Operation::less, Tape::scaled(a), Tape::scaled(b));
}
Trace::Condition operator<=(const Trace& a, const Trace& b) {
  if (a.is_constant() && b.is_constant()) return a.factor_ <= b.factor_;
  return Tape::condition(Operation::less_equal, Tape::scaled(a), Tape::scaled(b));
}
Trace::Condition operator&&(const Trace::Condition& a, const Trace::Condition& b) {
  if (a.is_constant()) return a.constant() ? b : a;
  if (b.is_constant()) return b.constant() ? a : b;
  if (a.node_ == b.node_) return a;
  return Tape::condition(Operation::both, a.node_, b.node_);
}
Trace::Condition operator||(const Trace::Condition& a, const Trace::Condition& b) {
  if (a.is_constant()) return a.constant() ? a : b;
  if (b.is_constant()) return b.constant() ? b : a;
  if (a.node_ == b.node_) return a;
  return Tape::condition(Operation::either, a.node_, b.node_);
}
Trace::Condition operator!(const Trace::Condition& a) {
  return a.is_constant() ? Trace::Condition(!a.constant()) : Tape::condition(Operation::negation, a.node_, 0);
}
Trace select(const Trace::Condition& condition, const Trace& a, const Trace& b) {
  if (condition.is_constant()) return condition.constant() ? a : b;
  if (a.factor_ == b.factor_) {
    if (a.node_ == b.node_) return a;
    return Trace(a.factor_, Tape::record({Operation::choice, a.node_, b.node_, condition.node_}));
  }
  return Trace(1, Tape::record({Operation::choice, Tape::scaled(a), Tape::scaled(b), condition.node_}));
}

}  // namespace axode
