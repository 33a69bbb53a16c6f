#include "axode/batch/check_loops.hpp"

#include <memory>
#include <stdexcept>
#include <string>

#include "axode/integration/prescribed/closed_motion.hpp"
#include "axode/kinematics/check_arguments.hpp"

namespace axode::batch {

bool check_loops(const Model& model, std::span<const double> q, std::span<const double> v, int threads,
                 const Monitor& monitor) {
  if (model.loops().empty() && model.motions().empty()) return true;
  const std::size_t nq = model.nq(), nv = model.nv(), N = q.size() / nq;
  check_size("v", v.size(), N * nv, "nv N");
  const Monitor asked = [&](std::size_t, std::size_t of) { return !monitor || monitor(0, of); };
  return N == in_portions(N, 1, threads, asked, [&]() -> Work {
           return [&, loops = std::make_shared<ClosedMotion>(model)](std::size_t n, std::size_t) {
             try {
               loops->check(q.subspan(n * nq, nq), v.subspan(n * nv, nv));
             } catch (const std::invalid_argument& error) {
               throw std::invalid_argument("state " + std::to_string(n) + ": " + error.what());
             }
           };
         });
}

}  // namespace axode::batch
