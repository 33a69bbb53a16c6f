#include "axode/codegen/tape/statement_order.hpp"

#include <cstddef>
#include <queue>

namespace axode::codegen {
namespace {

class Ordering {
 public:
  Ordering(const std::vector<std::vector<int>>& operands, const std::vector<int>& lasting)
      : operands_(operands),
        users_(operands.size()),
        missing_(operands.size()),
        uses_left_(operands.size()),
        possible_since_(operands.size()),
        done_(operands.size()) {
    for (std::size_t k = 0; k < operands.size(); ++k) {
      for (const int from : operands[k]) users_[from].push_back(static_cast<int>(k));
      missing_[k] = static_cast<int>(operands[k].size());
    }
    for (std::size_t k = 0; k < operands.size(); ++k) uses_left_[k] = static_cast<int>(users_[k].size());
    for (const int k : lasting) ++uses_left_[k];
  }

  std::vector<int> run() {
    std::vector<int> order;
    for (std::size_t k = 0; k < operands_.size(); ++k)
      if (missing_[k] == 0) offer(static_cast<int>(k));
    while (!possible_.empty()) {
      const Candidate next = possible_.top();
      possible_.pop();
      if (done_[next.statement]) continue;
      if (next.freed != freed(next.statement)) {
        offer(next.statement);
        continue;
      }
      order.push_back(next.statement);
      take(next.statement, static_cast<int>(order.size()));
    }
    return order;
  }

 private:
  struct Candidate {
    int freed, since, statement;
    bool operator<(const Candidate& b) const {
      return freed != b.freed   ? freed < b.freed
             : since != b.since ? since < b.since
                                : statement > b.statement;
    }
  };

  /// The decrease of the number of live results by statement k, whose own result is live if it is used later.
  int freed(int k) const {
    int count = 0;
    for (const int from : operands_[k]) count += uses_left_[from] == 1;
    return count - (uses_left_[k] > 0);
  }
  void offer(int k) { possible_.push({freed(k), possible_since_[k], k}); }
  void take(int k, int now) {
    done_[k] = 1;
    for (const int from : operands_[k])
      if (--uses_left_[from] == 1)
        for (const int user : users_[from])
          if (!done_[user] && missing_[user] == 0) offer(user);
    for (const int user : users_[k])
      if (--missing_[user] == 0) {
        possible_since_[user] = now;
        offer(user);
      }
  }

  const std::vector<std::vector<int>>& operands_;
  std::vector<std::vector<int>> users_;
  std::vector<int> missing_, uses_left_, possible_since_;
  std::vector<char> done_;
  std::priority_queue<Candidate> possible_;
};

}  // namespace

std::vector<int> order_for_few_registers(const std::vector<std::vector<int>>& operands,
                                         const std::vector<int>& lasting) {
  return Ordering(operands, lasting).run();
}

}  // namespace axode::codegen
