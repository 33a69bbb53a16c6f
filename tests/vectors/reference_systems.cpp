#include "axode/kinematics/higher_order/product_of_exponentials.hpp"
#include "axode/lie/newton_euler.hpp"
#include "tests/support/any_scalar.hpp"
#include "tests/vectors/reference_state.hpp"

/// Every quantity of every reference system that the library can compute, for every way to describe the
/// system.
namespace axode::test {
namespace {

class ReferenceSystems : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == none) GTEST_SKIP() << missing(vectors_folder(), "AXODE_VECTORS");
  }

  /// Calls check(system, model) for every way to describe the system.
  template <class Check> static void each_telling(const Check& check, bool with_gravity = true) {
    const ReferenceSystem system(GetParam());
    for (const Telling telling : tellings) {
      SCOPED_TRACE("told in way " + std::to_string(static_cast<int>(telling)));
      check(system, system.build(telling, with_gravity));
    }
  }
  /// Calls check(at, state) for every state and every way to describe the system.
  template <class Check> static void each_state(const Check& check, bool with_gravity = true) {
    each_telling(
        [&](const ReferenceSystem& system, const Model& model) {
          ASSERT_FALSE(system.states.empty());
          for (const Json& state : system.states) {
            SCOPED_TRACE("state " + state.at("state").text());
            check(system, model, state);
          }
        },
        with_gravity);
  }
};

INSTANTIATE_TEST_SUITE_P(Vectors, ReferenceSystems, testing::ValuesIn(systems()), name_of);

/// What the library computes for a model in a state of the files. Results for the bodies are in the order of
/// the files.
struct Evaluation {
  const Model& model;
  Workspace<> workspace;
  std::vector<double> q, v, a;

  Evaluation(const Model& of, const Json& state)
      : model(of),
        workspace(of),
        q(ReferenceSystem::in_model_order(of, state.at("q"))),
        v(ReferenceSystem::in_model_order(of, state.at("qd"))),
        a(ReferenceSystem::in_model_order(of, state.at("qdd"))) {}

  template <class Quantity> std::vector<Quantity> frames() const {
    return std::vector<Quantity>(static_cast<std::size_t>(model.n_frames()));
  }
  std::vector<SE3<>> poses() {
    auto C = frames<SE3<>>();
    axode::poses(model, workspace, q, C);
    return ReferenceSystem::in_file_order_of_bodies(model, C);
  }
  template <class Rep> std::vector<Twist<Rep>> twists(const std::vector<double>& at_v) {
    auto V = frames<Twist<Rep>>();
    axode::twists<Rep>(model, workspace, q, at_v, V);
    return ReferenceSystem::in_file_order_of_bodies(model, V);
  }
  template <class Rep> std::vector<Twist<Rep>> twists() { return twists<Rep>(v); }
  template <class Rep> std::vector<TwistRate<Rep>> accelerations() {
    auto dV = frames<TwistRate<Rep>>();
    axode::accelerations<Rep>(model, workspace, q, v, a, dV);
    return ReferenceSystem::in_file_order_of_bodies(model, dV);
  }
  std::vector<Inertia<>> inertias() const {
    std::vector<Inertia<>> M;
    for (int i = 1; i <= model.n_bodies(); ++i) M.push_back(model.body(ReferenceSystem::frame(model, i)).M);
    return M;
  }
  template <class Rep>
  std::vector<double> inverse_dynamics(const std::vector<double>& at_v, const std::vector<double>& at_a,
                                       const Loads<>& loads = {}) {
    std::vector<double> tau(v.size());
    axode::inverse_dynamics<Rep>(model, workspace, q, at_v, at_a, tau, loads);
    return ReferenceSystem::in_file_order(model, tau);
  }
  std::vector<double> zero() const { return std::vector<double>(v.size()); }
  std::vector<double> unit(int index) const {
    std::vector<double> e = zero();
    e[ReferenceSystem::place_of(model, index)] = 1;
    return e;
  }
};

TEST_P(ReferenceSystems, AreToldInEveryWay) {
  Comparison A("A", bound), B("B", bound), X("X", bound), Y("Y", bound), Z("Z", bound), S("S", bound);
  each_telling([&](const ReferenceSystem& system, const Model& model) {
    for (const Json& reference : system.model.at("bodies")) {
      const int i = ReferenceSystem::frame(model, reference.at("index"));
      const Body& body = model.body(i);
      EXPECT_EQ(body.predecessor, ReferenceSystem::frame(model, reference.at("parent")));
      EXPECT_EQ(model.joint(i).name, ReferenceSystem::joint_name(reference.at("index")));
      A.expect_equal(body.A, se3(reference.at("A")));
      B.expect_equal(body.B, se3(reference.at("B")));
      B.expect_equal(model.body(body.predecessor).A * body.B, body.A);
      S.expect_equal(body.S_prev, body.B * body.S_self);
      X.expect_equal(body.X.at(0), screw_of(reference.at("X")));
      Y.expect_equal(Ad(body.A, body.X.at(0)), screw_of(reference.at("Y")));
      Z.expect_equal(Ad_inv(se3(reference.at("S_self")), body.X.at(0)), screw_of(reference.at("Z")));
    }
  });
}

TEST_P(ReferenceSystems, Inertias) {
  Comparison M_b("M_b", bound), params10("params10", bound);
  each_telling([&](const ReferenceSystem& system, const Model& model) {
    for (const Json& reference : system.model.at("bodies")) {
      const Inertia<> M = model.body(ReferenceSystem::frame(model, reference.at("index"))).M;
      const Matrix6<double> by_rows = to_eigen(M).transpose();
      M_b.expect_equal(entries(by_rows), numbers(reference.at("M_b")));
      const Sym3<>& A = M.Theta;
      params10.expect_equal(std::vector{M.m, M.h.x, M.h.y, M.h.z, A.xx, A.yy, A.zz, A.xy, A.xz, A.yz},
                            numbers(reference.at("params10")));
    }
  });
}

TEST_P(ReferenceSystems, Poses) {
  Comparison C("C", bound), by_X("C by X", bound), by_Y("C by Y", bound);
  each_state([&](const ReferenceSystem&, const Model& model, const Json& state) {
    Evaluation at(model, state);
    std::vector<SE3<>> reference;
    for (const Json& rows : state.at("kinematics").at("C")) reference.push_back(se3(rows));
    C.expect_equal(at.poses(), reference);
    const auto in_file_order = [&](const std::vector<SE3<>>& bodies) {
      return ReferenceSystem::in_file_order_of_bodies(model, bodies);
    };
    by_X.expect_equal(in_file_order(poses_by_body_screws(model, at.q.data())), reference);
    by_Y.expect_equal(in_file_order(poses_by_spatial_screws(model, at.q.data())), reference);
  });
}

TEST_P(ReferenceSystems, TwistsAndAccelerations) {
  Comparison V("V", bound), Vdot("Vdot", bound);
  each_state([&](const ReferenceSystem&, const Model& model, const Json& state) {
    Evaluation at(model, state);
    each_representation([&](auto rep, const char* letter) {
      using Rep = decltype(rep);
      const Json& kinematics = state.at("kinematics");
      V.expect_equal(entries(at.template twists<Rep>()), numbers(kinematics.at("V").at(letter)));
      Vdot.expect_equal(entries(at.template accelerations<Rep>()), numbers(kinematics.at("Vdot").at(letter)));
    });
  });
}

/// The Taylor series Σ x_k t^k/k! of every coordinate, from the derivatives x_0, x_1, ... in the files.
template <std::size_t N>
std::vector<Taylor<double, N>> series(const Model& model, const Json& state,
                                      std::initializer_list<const char*> derivatives) {
  std::vector<Taylor<double, N>> out(static_cast<std::size_t>(model.nv()));
  double factorial = 1;
  std::size_t order = 0;
  for (const char* key : derivatives) {
    const std::vector<double> x = ReferenceSystem::in_model_order(model, state.at(key));
    for (std::size_t k = 0; k < x.size(); ++k) out[k].c[order] = x[k] / factorial;
    factorial *= static_cast<double>(++order);
  }
  return out;
}

/// The order-th derivative of the twists of the bodies, in the order of the files.
template <class Rep, std::size_t N>
std::vector<double> derivative_of_twists(const Model& model,
                                         const std::vector<Twist<Rep, Taylor<double, N>>>& V,
                                         std::size_t order) {
  std::vector<double> out;
  for (const auto& [w, v] : ReferenceSystem::in_file_order_of_bodies(model, V))
    for (const auto& x : {w.x, w.y, w.z, v.x, v.y, v.z}) out.push_back(derivative(x, order));
  return out;
}

TEST_P(ReferenceSystems, HigherDerivativesOfTwists) {
  constexpr std::size_t N = 4;
  Comparison Vddot("Vddot", bound), Vdddot("Vdddot", bound);
  each_state([&](const ReferenceSystem&, const Model& model, const Json& state) {
    const auto tree = cast<Taylor<double, N>>(model.tree<double>());
    const auto q = series<N>(model, state, {"q", "qd", "qdd", "qddd"});
    const auto v = series<N>(model, state, {"qd", "qdd", "qddd", "qdddd"});
    each_representation([&](auto rep, const char* letter) {
      const auto V = frame_twists<decltype(rep)>(tree, q, v);
      const Json& kinematics = state.at("kinematics");
      Vddot.expect_equal(derivative_of_twists(model, V, 2), numbers(kinematics.at("Vddot").at(letter)));
      Vdddot.expect_equal(derivative_of_twists(model, V, 3), numbers(kinematics.at("Vdddot").at(letter)));
    });
  });
}

TEST_P(ReferenceSystems, Jacobians) {
  constexpr std::size_t N = 3;
  const char* const keys[] = {"J", "Jdot", "Jddot"};
  if (!ReferenceSystem(GetParam()).states.at(0).at("kinematics").contains("pairs"))
    GTEST_SKIP() << GetParam() << " comes without Jacobians";
  Comparison worst("J", bound);
  each_state([&](const ReferenceSystem&, const Model& model, const Json& state) {
    const Json& kinematics = state.at("kinematics");
    const auto tree = cast<Taylor<double, N>>(model.tree<double>());
    const auto q = series<N>(model, state, {"q", "qd", "qdd"});
    each_representation([&](auto rep, const char* letter) {
      std::vector<std::vector<Twist<decltype(rep), Taylor<double, N>>>>
          J;  // for each j: the twists of all bodies if joint j moves with velocity 1
      for (int j = 1; j <= model.n_bodies(); ++j) {
        std::vector<Taylor<double, N>> unit(q.size());
        unit[ReferenceSystem::place_of(model, j)] = 1.0;
        J.push_back(frame_twists<decltype(rep)>(tree, q, unit));
      }
      for (std::size_t order = 0; order < N; ++order) {
        std::vector<std::vector<double>> others;
        for (const auto& J_j : J) others.push_back(derivative_of_twists(model, J_j, order));
        std::vector<double> listed;
        for (const Json& pair : kinematics.at("pairs")) {
          const std::size_t i = pair.at(0), j = pair.at(1);
          for (std::size_t k = 6 * (i - 1); k < 6 * i; ++k) {
            listed.push_back(others[j - 1][k]);
            others[j - 1][k] = 0;
          }
        }
        worst.expect_equal(listed, numbers(kinematics.at(keys[order]).at(letter)));
        EXPECT_EQ(largest(entries(others)), 0) << "columns that are not listed are zero";
      }
    });
  });
}

TEST_P(ReferenceSystems, MomentaEnergiesAndInertiaForces) {
  Comparison Pi("Pi", bound), total("Pi_s_total", bound), W("W_inertia", bound),
      kinetic("kinetic energy", bound), potential("potential energy", bound);
  each_state([&](const ReferenceSystem&, const Model& model, const Json& state) {
    Evaluation at(model, state);
    const Json& dynamics = state.at("dynamics");
    const std::vector<SE3<>> C = at.poses();
    const std::vector<Inertia<>> M = at.inertias();
    const std::vector<Twist<BodyFixed>> V_b = at.twists<BodyFixed>();
    each_representation([&](auto rep, const char* letter) {
      using Rep = decltype(rep);
      const auto V = at.template twists<Rep>();
      const auto dV = at.template accelerations<Rep>();
      std::vector<Momentum<Rep>> momenta;
      std::vector<Wrench<Rep>> wrenches;
      Momentum<Spatial> sum{};
      double twice_T = 0;
      for (std::size_t i = 0; i < C.size(); ++i) {
        momenta.push_back(change<Rep>(C[i], M[i] * V_b[i]));
        wrenches.push_back(wrench(C[i], M[i], V[i], dV[i]));
        sum += change<Spatial>(C[i], momenta[i]);
        twice_T += momenta[i] | V[i];
      }
      if (dynamics.contains("Pi")) Pi.expect_equal(entries(momenta), numbers(dynamics.at("Pi").at(letter)));
      if (dynamics.contains("W_inertia"))
        W.expect_equal(entries(wrenches), numbers(dynamics.at("W_inertia").at(letter)));
      if (dynamics.contains("Pi_s_total"))
        total.expect_equal(entries(sum), numbers(dynamics.at("Pi_s_total")));
      kinetic.expect_equal(twice_T / 2, number(dynamics.at("kinetic_energy")));
    });
    const Vec3<> c = center_of_mass(model, at.workspace, at.q);
    potential.expect_equal(-model.total_mass() * dot(model.gravity(), c),
                           number(dynamics.at("potential_energy")));
  });
}

TEST_P(ReferenceSystems, NewtonEulerInAnyPairOfFrames) {
  if (!ReferenceSystem(GetParam()).states.at(0).at("dynamics").contains("newton_euler_jk"))
    GTEST_SKIP() << GetParam() << " comes without pairs of frames";
  Comparison twist("V", bound), rate("Vdot", bound), inertia("M", bound), force("W", bound),
      back("Vdot from W", bound);
  each_state([&](const ReferenceSystem&, const Model& model, const Json& state) {
    Evaluation at(model, state);
    auto C = at.poses();
    auto V_h = at.twists<Hybrid>();
    const auto V_s = at.twists<Spatial>();
    const auto dV_s = at.accelerations<Spatial>();
    const auto M = at.inertias();
    const auto motion_of = [&](int index) {  // of frame F_index, in inertial axes
      return index == 0 ? std::pair<SE3<>, Twist<Hybrid>>{} : std::pair{C[index - 1], V_h[index - 1]};
    };
    for (const Json& reference : state.at("dynamics").at("newton_euler_jk")) {
      const int i = reference.at("i");
      const auto [C_j, V_j] = motion_of(reference.at("j"));
      const auto [C_k, V_k] = motion_of(reference.at("k"));
      const FramePair<> jk{C_j.r, V_j.v, C_k.R, V_k.w};
      const Twist<InFrames> V = change(jk, V_s[i - 1]);
      const TwistRate<InFrames> dV = change(jk, V_s[i - 1], dV_s[i - 1]);
      const Wrench<InFrames> W = wrench(C[i - 1], M[i - 1], jk, V, dV);
      twist.expect_equal(entries(V), numbers(reference.at("V")));
      rate.expect_equal(entries(dV), numbers(reference.at("Vdot")));
      inertia.expect_equal(
          entries(Matrix6<double>(to_eigen(inertia_in_frames(jk, C[i - 1], M[i - 1])).transpose())),
          numbers(reference.at("M")));
      force.expect_equal(entries(W), numbers(reference.at("W")));
      back.expect_equal(acceleration(C[i - 1], M[i - 1], jk, V, W), dV, largest(entries(W)));
    }
  });
}

TEST_P(ReferenceSystems, DriveForces) {
  Comparison Q("Q", bound), applied("applied_generalized", bound), coriolis("coriolis_vector", bound),
      M("M", bound);
  each_state([&](const ReferenceSystem& system, const Model& model, const Json& state) {
    Evaluation at(model, state);
    const std::vector<AppliedWrench<>> wrenches = system.loads(model);
    each_representation([&](auto rep, const char*) {
      Q.expect_equal(at.template inverse_dynamics<decltype(rep)>(at.v, at.a, {.wrenches = wrenches}),
                     numbers(state.at("dynamics").at("Q")));
    });
  });
  each_state(
      [&](const ReferenceSystem& system, const Model& model, const Json& state) {
        Evaluation at(model, state);
        const Json& dynamics = state.at("dynamics");
        const std::vector<AppliedWrench<>> wrenches = system.loads(model);
        each_representation([&](auto rep, const char*) {
          using Rep = decltype(rep);
          std::vector<double> loads =
              at.template inverse_dynamics<Rep>(at.zero(), at.zero(), {.wrenches = wrenches});
          for (double& x : loads) x = -x;
          applied.expect_equal(loads, numbers(dynamics.at("applied_generalized")));
          coriolis.expect_equal(at.template inverse_dynamics<Rep>(at.v, at.zero()),
                                numbers(dynamics.at("coriolis_vector")));
          std::vector<std::vector<double>> columns;
          for (int k = 1; k <= model.nv(); ++k)
            columns.push_back(at.template inverse_dynamics<Rep>(at.zero(), at.unit(k)));
          M.expect_equal(entries(columns), numbers(dynamics.at("M")));
        });
      },
      false);
}

TEST_P(ReferenceSystems, GravityForcesAndForwardDynamics) {
  Comparison gravity("gravity_vector", bound), tau("tau", bound);
  each_state([&](const ReferenceSystem& system, const Model& model, const Json& state) {
    Evaluation at(model, state);
    const Json& dynamics = state.at("dynamics");
    const std::vector<AppliedWrench<>> wrenches = system.loads(model);
    each_representation([&](auto rep, const char*) {
      using Rep = decltype(rep);
      gravity.expect_equal(at.template inverse_dynamics<Rep>(at.zero(), at.zero()),
                           numbers(dynamics.at("gravity_vector")));
      if (!dynamics.contains("forward")) return;
      const std::vector<double> a = ReferenceSystem::in_model_order(model, dynamics.at("forward").at("qdd"));
      // The accelerations are large because some inertias are small. Differences are therefore compared with
      // the largest term of the equation.
      const double scale = largest(at.template inverse_dynamics<Rep>(at.zero(), a));
      tau.expect_equal(at.template inverse_dynamics<Rep>(at.v, a, {.wrenches = wrenches}),
                       numbers(state.at("tau")), scale);
    });
  });
}

TEST_P(ReferenceSystems, TimeDerivativesOfDriveForces) {
  constexpr std::size_t N = 3;
  using S = Taylor<double, N>;
  Comparison Qdot("Qdot", bound), Qddot("Qddot", bound);
  each_state([&](const ReferenceSystem& system, const Model& model, const Json& state) {
    const auto tree = cast<S>(model.tree<double>());
    const auto q = series<N>(model, state, {"q", "qd", "qdd"});
    const auto v = series<N>(model, state, {"qd", "qdd", "qddd"});
    const auto a = series<N>(model, state, {"qdd", "qddd", "qdddd"});
    std::vector<AppliedWrench<S>> wrenches;
    for (const AppliedWrench<>& load : system.loads(model))
      wrenches.emplace_back(load.frame, load.representation, cast<S>(load.m), cast<S>(load.f));
    each_representation([&](auto rep, const char*) {
      const std::vector<S> Q = ReferenceSystem::in_file_order(
          model, generalised_forces<decltype(rep)>(tree, q, v, a, {.wrenches = wrenches}));
      const auto rate = [&](std::size_t order) {
        std::vector<double> out;
        for (const S& Q_k : Q) out.push_back(derivative(Q_k, order));
        return out;
      };
      Qdot.expect_equal(rate(1), numbers(state.at("dynamics").at("Qdot")));
      Qddot.expect_equal(rate(2), numbers(state.at("dynamics").at("Qddot")));
    });
  });
}

}  // namespace
}  // namespace axode::test
