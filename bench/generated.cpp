// The code that `axode codegen` writes for one robot, compared with the fast path, which takes any robot.
#include <memory>

#include "axode/io.hpp"
#include "bench/subjects.hpp"

extern "C" {
void arm7_inverse_dynamics(const double* q, const double* v, const double* a, double* tau);
int arm7_forward_dynamics(const double* q, const double* v, const double* tau, double* a);
void arm7_mass_matrix(const double* q, double* M);
void arm7_jacobian_flange(const double* q, double* J);
void humanoid_inverse_dynamics(const double* q, const double* v, const double* a, double* tau);
int humanoid_forward_dynamics(const double* q, const double* v, const double* tau, double* a);
void humanoid_mass_matrix(const double* q, double* M);
void humanoid_jacobian_right_sole(const double* q, double* J);
}

namespace {

using namespace axode;
using namespace axode::bench;

using OfState = void(const double*, const double*, const double*, double*);
using Solve = int(const double*, const double*, const double*, double*);
using OfConfiguration = void(const double*, double*);

void measure_generated(const Model& robot, OfState* inverse_dynamics, Solve* forward_dynamics,
                       OfConfiguration* mass_matrix, OfConfiguration* jacobian) {
  const auto one = [&](const char* function, const auto& f) {
    measure_function(function, "generated", f, {robot});
  };
  one("inverse_dynamics", [=](auto&, auto&, auto& q, auto& v, auto& a, auto out) {
    inverse_dynamics(q.data(), v.data(), a.data(), out.data());
  });
  one("forward_dynamics", [=](auto&, auto&, auto& q, auto& v, auto& a, auto out) {
    benchmark::DoNotOptimize(forward_dynamics(q.data(), v.data(), a.data(), out.data()));
  });
  one("mass_matrix",
      [=](auto&, auto&, auto& q, auto&, auto&, auto out) { mass_matrix(q.data(), out.data()); });
  one("jacobian", [=](auto&, auto&, auto& q, auto&, auto&, auto out) { jacobian(q.data(), out.data()); });
}

/// Measures the Jacobian of the last frame.
void measure_jacobian(const Model& robot) {
  const auto J = std::make_shared<std::vector<Twist<BodyFixed>>>(static_cast<std::size_t>(robot.nv()));
  measure_function("jacobian", "fast",
                   [J](const Model& m, auto& w, auto& q, auto&, auto&, auto) {
                     jacobian(m, w, q, m.n_frames() - 1, *J);
                     benchmark::DoNotOptimize(J->data());
                   },
                   {robot});
}

const bool registered = [] {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml"),
              humanoid = load(AXODE_ROBOTS_DIR "/humanoid.urdf", Base::free);
  measure_generated(arm, arm7_inverse_dynamics, arm7_forward_dynamics, arm7_mass_matrix,
                    arm7_jacobian_flange);
  measure_generated(humanoid, humanoid_inverse_dynamics, humanoid_forward_dynamics, humanoid_mass_matrix,
                    humanoid_jacobian_right_sole);
  measure_jacobian(arm), measure_jacobian(humanoid);
  const auto fast = [&](const char* function, const auto& f) {  // functions.cpp measures the arm
    measure_function(function, "fast", f, {humanoid});
  };
  fast("inverse_dynamics", [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto out) {
    inverse_dynamics(m, w, q, v, a, out.first(v.size()));
  });
  fast("forward_dynamics", [](const Model& m, auto& w, auto& q, auto& v, auto& a, auto out) {
    benchmark::DoNotOptimize(forward_dynamics(m, w, q, v, a, out.first(v.size())));
  });
  fast("mass_matrix", [](const Model& m, auto& w, auto& q, auto& v, auto&, auto out) {
    mass_matrix(m, w, q, out.first(v.size() * v.size()));
  });
  return true;
}();

}  // namespace
