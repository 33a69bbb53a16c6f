#pragma once
#include <algorithm>
#include <functional>
#include <queue>
#include <vector>

#include "axode/scalar/counted.hpp"

namespace axode::command {

/// Counts the operations on the critical path of a tree contraction, a parallel algorithm, if there is one
/// processor for each body and communication costs nothing. A step begins when its inputs are complete, and a
/// sweep over the tree begins when the sweep before it is complete. If several bodies or chains of bodies are
/// added to one, they are added in pairs.
class LongestPath {
 public:
  explicit LongestPath(int n) : ready_(static_cast<std::size_t>(n + 1)), added_(ready_.size()) {}

  /// A step of one node.
  template <class F> void at(int i, const F& f) { ready(i) += cost(f); }
  /// A step of two nodes.
  template <class F> void join(int upper, int lower, const F& f) {
    ready(upper) = std::max(ready(upper), ready(lower)) + cost(f);
  }
  /// Adds the lower node to the upper one, in any order with others.
  template <class F> void sum(int upper, int lower, const F& f) {
    const long time = ready(lower);
    added_[static_cast<std::size_t>(upper)].push({time, cost(f)});
  }
  /// A step of the lower node, with numbers of the upper one that it changes or not.
  template <class F> void pass_on(int upper, int lower, bool changed, const F& f) {
    ready(lower) = std::max(ready(upper), ready(lower)) + cost(f);
    if (changed) ready(upper) = ready(lower);
  }
  /// Waits for all nodes.
  void meet() { std::ranges::fill(ready_, operations()); }
  long operations() {
    for (std::size_t i = 0; i < ready_.size(); ++i) static_cast<void>(ready(static_cast<int>(i)));
    return std::ranges::max(ready_);
  }

 private:
  struct Term {
    long time, cost;
    bool operator>(const Term& other) const { return time > other.time; }
  };

  template <class F> static long cost(const F& f) {
    const long before = Counted::count().total();
    f();
    return Counted::count().total() - before;
  }
  /// When a node is ready, with all that was added to it: always the two terms that are ready first.
  long& ready(int i) {
    auto& terms = added_[static_cast<std::size_t>(i)];
    long& own = ready_[static_cast<std::size_t>(i)];
    if (terms.empty()) return own;
    const long step = terms.top().cost;
    terms.push({own, step});
    while (terms.size() > 1) {
      terms.pop();
      const long later = terms.top().time;
      terms.pop();
      terms.push({later + step, step});
    }
    own = terms.top().time;
    terms.pop();
    return own;
  }

  std::vector<long> ready_;
  std::vector<std::priority_queue<Term, std::vector<Term>, std::greater<>>> added_;
};

}  // namespace axode::command
