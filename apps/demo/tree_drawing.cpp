#include "apps/demo/tree_drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"

namespace axode::command {
namespace {

constexpr std::size_t deepest_indent = 24;  // largest number of levels that are drawn as branches
constexpr std::size_t widest_line = 110;

/// Draws the branches (lines of text) in front of the entries of a tree, which come in depth-first order.
class Branches {
 public:
  std::string before(std::size_t depth, bool last) {
    open_.resize(depth);
    std::string text;
    if (depth > deepest_indent) text = fmt::format("... {} deeper ", depth - deepest_indent);
    text += branches(depth - std::min(depth, deepest_indent)) + (last ? "└─ " : "├─ ");
    open_.push_back(!last);
    return text;
  }
  /// The branches in front of a further line of text of the last entry.
  std::string under() const { return branches(0) + "  "; }

 private:
  std::string branches(std::size_t from) const {
    std::string text;
    for (std::size_t k = from; k < open_.size(); ++k) text += open_[k] ? "│  " : "   ";
    return text;
  }

  std::vector<bool> open_;
};

struct ChildCounts {
  std::vector<int> children, last_child;  ///< number of children of bodies 0 to n_bodies, and the last child

  explicit ChildCounts(const Model& model)
      : children(model.n_bodies() + 1), last_child(model.n_bodies() + 1) {
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const int p = model.body(i).predecessor;
      ++children[p];
      last_child[p] = i;
    }
  }
};

}  // namespace

std::string slice(char symbol, int first, int count) {
  if (count == 0) return "";
  return count == 1 ? fmt::format("{}[{}]", symbol, first)
                    : fmt::format("{}[{}:{}]", symbol, first, first + count);
}

std::string coupling(const Model& model, const Joint& joint) {
  if (!joint.leader) return "";
  const auto& [leader, ratio, offset] = *joint.leader;
  std::string text = fmt::format("= {} q({})", significant(ratio), model.joint(leader).name);
  if (offset != 0) text += fmt::format(" {} {}", offset < 0 ? '-' : '+', significant(std::abs(offset)));
  return text;
}

std::string draw_tree(const Model& model) {
  const ChildCounts counts(model);
  std::vector<std::size_t> depth(model.n_bodies() + 1);
  std::vector<std::string> left(model.n_bodies() + 1);
  Branches branches;
  std::size_t widest = 0, widest_joint = 0;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const int p = model.body(i).predecessor;
    depth[i] = p == 0 ? 0 : depth[p] + 1;
    left[i] = branches.before(depth[i], counts.last_child[p] == i) + model.body(i).name;
    widest = std::max(widest, width(left[i]));
    widest_joint = std::max(widest_joint, width(model.joint(i).name));
  }
  std::string out = model.body(0).name + "\n";
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Joint& joint = model.joint(i);
    const std::string where = joint.leader
                                  ? coupling(model, joint)
                                  : slice('q', joint.iq, joint.nq) + " " + slice('v', joint.iv, joint.nv);
    out += fmt::format("{}  <- {}  {}\n", padded(left[i], widest), padded(joint.name, widest_joint),
                       in(Ink::faint, fmt::format("{:<9} {}", to_string(joint.kind), where)));
  }
  return out;
}

std::string draw_limbs(const Model& model) {
  const ChildCounts counts(model);
  std::vector<std::size_t> depth(model.n_bodies() + 1);
  Branches branches;
  std::string out, line = model.body(0).name;
  const auto begin_line = [&](const std::string& start) {
    out += line + "\n";
    line = start;
  };
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const int p = model.body(i).predecessor;
    const std::string& name = model.body(i).name;
    if (p > 0 && counts.children[p] == 1) {
      depth[i] = depth[p];
      if (width(line) + width(name) > widest_line) begin_line(branches.under());
      line += " ─ " + name;
    } else {
      depth[i] = p == 0 ? 0 : depth[p] + 1;
      begin_line(branches.before(depth[i], counts.last_child[p] == i) + name);
    }
  }
  return out + line + "\n";
}

}  // namespace axode::command
