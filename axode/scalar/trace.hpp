#pragma once
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "axode/lie/scalar.hpp"

namespace axode {

class Tape;

/// A number that records how it is computed. While a Tape exists in the thread, the tape records all
/// operations on Traces. An operation that is repeated with the same operands is recorded only once.
///
/// A Trace is a factor times a recorded number, or a constant. Therefore constants and signs are folded and
/// never recorded: 0 x = 0, x + 0 = x, x - x = 0, (2 x) (-3 y) = -6 (x y), a b - c d = -(c d - a b). For all
/// finite numbers, a folded result is equal to the result of the operations up to rounding.
class Trace {
 public:
  /// The result of a comparison of Traces. If is_constant() is true, it does not depend on the inputs, and
  /// constant() is its value. Otherwise its value is known only when the recorded program runs: it can be an
  /// argument of select(), but cannot decide a branch of the program that is being recorded.
  class Condition {
   public:
    Condition() = default;
    Condition(bool value) : value_(value) {}  // NOLINT(google-explicit-constructor): a constant
    bool is_constant() const { return node_ == 0; }
    bool constant() const { return value_; }
    int node() const { return node_; }
    friend Condition operator&&(const Condition& a, const Condition& b);
    friend Condition operator||(const Condition& a, const Condition& b);
    friend Condition operator!(const Condition& a);
    friend Trace select(const Condition& condition, const Trace& a, const Trace& b);

   private:
    friend class Tape;
    int node_ = 0;
    bool value_ = false;
  };

  Trace() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number> Trace(Number value)
        : factor_(static_cast<double>(value)) {}  // NOLINT(google-explicit-constructor): a constant

    bool is_constant() const { return node_ == 0; }
    /// This Trace is factor() times the value of node number node() on the tape; node 0 is the number 1.
    double factor() const { return factor_; }
    int node() const { return node_; }

    friend Trace operator+(const Trace& a, const Trace& b);
    friend Trace operator-(const Trace& a, const Trace& b) { return a + -b; }
    friend Trace operator-(const Trace& a) { return Trace(-a.factor_, a.node_); }
    friend Trace operator*(const Trace& a, const Trace& b);
    /// The quotient a / b is recorded as a (1/b), so that all quotients with one divisor share a division.
    friend Trace operator/(const Trace& a, const Trace& b);
    Trace& operator+=(const Trace& b) { return *this = *this + b; }
    Trace& operator-=(const Trace& b) { return *this = *this - b; }
    friend Trace sqrt(const Trace& a);
    friend Trace sin(const Trace& a);
    friend Trace cos(const Trace& a);
    friend Trace atan2(const Trace& a, const Trace& b);
    friend Condition operator<(const Trace& a, const Trace& b);
    friend Condition operator<=(const Trace& a, const Trace& b);
    friend Condition operator>(const Trace& a, const Trace& b) { return b < a; }
    friend Condition operator>=(const Trace& a, const Trace& b) { return b <= a; }
    friend Trace select(const Condition& condition, const Trace& a, const Trace& b);

   private:
    friend class Tape;
    Trace(double factor, int node)
        : factor_(factor == 0 ? 0 : factor), node_(factor == 0 ? 0 : node) {}  // -0 becomes 0
    double factor_ = 0;
    int node_ = 0;
};

/// The list of operations on Traces in this thread. A Trace is a number type that records the operations by
/// which it is computed. Traces can be used only while the Tape exists on which they were recorded. The
/// constructor throws std::logic_error if the thread already has a Tape.
class Tape {
 public:
  enum class Operation : unsigned char {
    one,         ///< the number 1
    input,       ///< entry b of array a
    scale,       ///< factor a
    sum,         ///< a + factor b, |factor| <= 1
    product,     ///< a b
    reciprocal,  ///< 1 / a
    root,        ///< sqrt(a)
    sine,        ///< sin(a)
    cosine,      ///< cos(a)
    angle,       ///< atan2(a, b)
    choice,      ///< condition ? a : b
    less,        ///< a < b
    less_equal,  ///< a <= b
    both,        ///< conditions a && b
    either,      ///< conditions a || b
    negation,    ///< !a
  };
  struct Node {
    Operation operation{};
    int a = 0, b = 0, condition = 0;  ///< indices of earlier nodes
    double factor = 1;
    friend bool operator==(const Node&, const Node&) = default;
  };

  Tape();
  ~Tape();
  Tape(const Tape&) = delete;
  Tape& operator=(const Tape&) = delete;

  /// An unknown number that is an input of the recorded program: entry `index` of input array `array`.
  Trace input(int array, int index);
  /// The recorded operations, in an order in which they can be computed.
  const std::vector<Node>& nodes() const { return nodes_; }
  /// The number that the node with this index computes.
  static Trace number(int node) { return Trace(1, node); }
  /// The condition that the node with this index computes.
  static Trace::Condition truth(int node);

 private:
  friend class Trace;
  struct Hash {
    std::size_t operator()(const Node& node) const;
  };
  static Tape& of_this_thread();
  static int record(const Node& node);
  static const Node& at(int node);
  static int scaled(const Trace& a);
  static Trace::Condition condition(Operation operation, int a, int b);
  static Trace product(int a, int b);
  static Trace sum(const Trace& a, const Trace& b);

  friend Trace operator+(const Trace&, const Trace&);
  friend Trace operator*(const Trace&, const Trace&);
  friend Trace operator/(const Trace&, const Trace&);
  friend Trace sqrt(const Trace&);
  friend Trace sin(const Trace&);
  friend Trace cos(const Trace&);
  friend Trace atan2(const Trace&, const Trace&);
  friend Trace::Condition operator<(const Trace&, const Trace&);
  friend Trace::Condition operator<=(const Trace&, const Trace&);
  friend Trace::Condition operator&&(const Trace::Condition&, const Trace::Condition&);
  friend Trace::Condition operator||(const Trace::Condition&, const Trace::Condition&);
  friend Trace::Condition operator!(const Trace::Condition&);
  friend Trace select(const Trace::Condition&, const Trace&, const Trace&);

  std::vector<Node> nodes_;
  std::unordered_map<Node, int, Hash> known_;
};

}  // namespace axode
