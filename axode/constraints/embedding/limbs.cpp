#include "axode/constraints/embedding/limbs.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace axode {
namespace {

/// A partition of the velocities into sets (union-find). Sets are joined until each is a limb.
class Parts {
 public:
  explicit Parts(int size) : up_(static_cast<std::size_t>(size)) { std::iota(up_.begin(), up_.end(), 0); }

  int first(int c) {
    while (at(c) != c) c = at(c) = at(at(c));
    return c;
  }
  void join(int a, int b) {
    const int first_a = first(a), first_b = first(b);
    at(std::max(first_a, first_b)) = std::min(first_a, first_b);
  }

 private:
  int& at(int c) { return up_[static_cast<std::size_t>(c)]; }
  std::vector<int> up_;
};

/// Estimates the cost of an elimination limb by limb: the sum of the cubes of the numbers of velocities.
double cost(const Limbs& division) {
  const auto cube = [](std::size_t n) {
    const auto x = static_cast<double>(n);
    return x * x * x;
  };
  double sum = cube(division.carrying.size());
  for (const Limb& limb : division.limbs) sum += cube(limb.velocities.size());
  return sum;
}

}  // namespace

Limbs limbs_of(const Model& model, const std::vector<LoopPath>& paths, int platform) {
  const Topology& topology = model.topology();
  Limbs out;
  out.platform = platform;
  std::vector<char> carries(static_cast<std::size_t>(topology.nv));
  for (int i = platform; i > 0; i = topology.parent[i])
    for (int s = topology.first_screw[i]; s < topology.first_screw[i + 1]; ++s)
      carries[static_cast<std::size_t>(topology.iv[i] + s - topology.first_screw[i])] = 1;
  for (int c = 0; c < topology.nv; ++c)
    if (carries[static_cast<std::size_t>(c)] != 0) out.carrying.push_back(c);

  Parts parts(topology.nv);
  const auto separate = [&](int c) { return carries[static_cast<std::size_t>(c)] == 0; };
  for (int c = 0; c < topology.nv; ++c) {  // the mass matrix of the tree couples velocities on one path to
                                           // the ground
    const int p = topology.velocity_parent[c];
    if (p >= 0 && separate(c) && separate(p)) parts.join(c, p);
  }
  std::vector<int> first_of_loop;  // a velocity of each loop that is not carrying; -1 if the loop has
                                   // carrying velocities only
  for (const LoopPath& path : paths) {
    int first = -1;
    for (const LoopColumn& column : path.columns) {
      if (!separate(column.velocity)) continue;
      if (first >= 0) parts.join(first, column.velocity);
      first = column.velocity;
    }
    first_of_loop.push_back(first);
  }

  std::vector<int> limb_of(static_cast<std::size_t>(topology.nv), -1);
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const int number = static_cast<int>(k);
    if (first_of_loop[k] < 0) {
      out.limbs.push_back({{}, {number}});
      continue;
    }
    int& limb = limb_of[static_cast<std::size_t>(parts.first(first_of_loop[k]))];
    if (limb < 0) {
      limb = static_cast<int>(out.limbs.size());
      out.limbs.emplace_back();
    }
    out.limbs[static_cast<std::size_t>(limb)].loops.push_back(number);
  }
  for (int c = 0; c < topology.nv; ++c) {
    if (!separate(c)) continue;
    const int limb = limb_of[static_cast<std::size_t>(parts.first(c))];
    (limb < 0 ? out.outside : out.limbs[static_cast<std::size_t>(limb)].velocities).push_back(c);
  }
  return out;
}

Limbs limbs_of(const Model& model, const std::vector<LoopPath>& paths) {
  constexpr std::size_t most_candidates = 16;
  std::map<int, int> loops;  // for each body, the number of loops that have it on their paths to the ground
  for (const LoopPath& path : paths)
    for (const int body : path.bodies) ++loops[body];
  std::vector<std::pair<int, int>> candidates(loops.begin(), loops.end());
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  candidates.resize(std::min(candidates.size(), most_candidates));
  Limbs best = limbs_of(model, paths, 0);
  for (const auto& [body, count] : candidates) {
    if (count < 2) break;
    Limbs division = limbs_of(model, paths, body);
    if (cost(division) < cost(best)) best = std::move(division);
  }
  return best;
}

}  // namespace axode
