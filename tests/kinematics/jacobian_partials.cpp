#include "axode/kinematics/higher_order/screw_partials.hpp"
#include "axode/scalar/counted.hpp"
#include "tests/kinematics/derivatives.hpp"
#include "tests/support/refused_arguments.hpp"

/// Closed forms of partial derivatives agree with derivatives from scalar types that carry derivatives.
namespace axode::test {
namespace {

template <class F> void each_representation(const F& f) {
  f(BodyFixed{}), f(Spatial{}), f(Hybrid{}), f(Mixed{});
}
template <class Rep>
constexpr std::size_t index_of = std::same_as<Rep, BodyFixed> ? 0
                                 : std::same_as<Rep, Spatial> ? 1
                                 : std::same_as<Rep, Hybrid>  ? 2
                                                              : 3;

/// A random tree with a configuration and a place on it.
struct Sample {
  Random<double> random;
  Model model;
  Workspace<> workspace;
  std::vector<double> q;
  Place<> place;

  Sample(std::uint64_t seed, int most_bodies)
      : random(seed),
        model(random_model(random, {.most_bodies = most_bodies})),
        workspace(model),
        q(random_configuration(model, seed)),
        place(random_place(model, random)) {}
  Sample(const Model& of, std::uint64_t seed, const Place<>& at)
      : random(seed), model(of), workspace(model), q(random_configuration(model, seed)), place(at) {}

  template <class Rep> std::vector<Twist<Rep>> partials(int order) {
    std::size_t size = static_cast<std::size_t>(model.nv());
    for (int k = 0; k < order; ++k) size *= static_cast<std::size_t>(model.nv());
    std::vector<Twist<Rep>> J(size, {{9, 9, 9}, {9, 9, 9}});
    jacobian_partials<Rep>(model, workspace, q, place, order, J);
    return J;
  }
  template <class Rep> std::vector<Twist<Rep>> along(int order, const std::vector<double>& directions) {
    std::vector<Twist<Rep>> J(static_cast<std::size_t>(model.nv()), {{9, 9, 9}, {9, 9, 9}});
    jacobian_derivative_along<Rep>(model, workspace, q, place, order, directions, J);
    return J;
  }
};

/// Dual numbers that are nested `depth` times. They carry the mixed derivative along one direction for each
/// level.
template <int depth> struct Nested { using Type = Dual<typename Nested<depth - 1>::Type, 1>; };
template <> struct Nested<0> { using Type = double; };
/// The infinitesimal unit of a level; level 0 is the outermost.
template <int depth> typename Nested<depth>::Type infinitesimal(int level) {
  if constexpr (depth == 0)
    return 0;
  else
    return level == 0 ? typename Nested<depth>::Type(0.0, {1.0})
                      : typename Nested<depth>::Type(infinitesimal<depth - 1>(level - 1));
}
template <int depth> double mixed_derivative(const typename Nested<depth>::Type& x) {
  if constexpr (depth == 0)
    return x;
  else
    return mixed_derivative<depth - 1>(x.dx[0]);
}

/// The Jacobian at ((q ⊕ ε_n u_n) ⊕ ...) ⊕ ε_1 u_1 in all representations, and its derivative with respect to
/// ε_1, ..., ε_n.
template <int depth> class NestedJacobian {
 public:
  using T = typename Nested<depth>::Type;
  explicit NestedJacobian(const Sample& sample)
      : tree_(on<T>(sample.model)), q_(on<T>(sample.q)), place_(on<T>(sample.place)) {}

  void move(int level, const std::vector<double>& u) {
    const T epsilon = infinitesimal<depth>(level);
    for (int i = 1; i <= tree_->n; ++i) {
      if (tree_->coupled[i]) continue;
      with_joint(tree_, i, [&](const auto& joint) {
        std::array<T, 6> dv;
        bool moves = false;
        for (int k = 0; k < joint.nv; ++k) {
          const double u_k = u[static_cast<std::size_t>(tree_->iv[i] + k)];
          dv[static_cast<std::size_t>(k)] = T(u_k) * epsilon, moves = moves || u_k != 0;
        }
        if (moves)
          joint.integrate(std::vector<T>(&q_[tree_->iq[i]], &q_[tree_->iq[i]] + joint.nq).data(), dv.data(),
                          &q_[tree_->iq[i]]);
      });
    }
  }
  template <class Rep> std::vector<Twist<Rep>> derivative() const {
    return each_number(jacobian_on<Rep>(tree_, q_, place_),
                       [](const T& x) { return mixed_derivative<depth>(x); });
  }

 private:
  Tree<T> tree_;
  std::vector<T> q_;
  Place<T> place_;
};

/// The tensor of all partial derivatives from nested dual numbers: calls store() for each multi-index with
/// the derivative of every column.
template <int order, class Store> void each_partial(const Sample& sample, const Store& store) {
  const int nv = sample.model.nv();
  int entries_of_tensor = 1;
  for (int k = 0; k < order; ++k) entries_of_tensor *= nv;
  for (int entry = 0; entry < entries_of_tensor; ++entry) {
    NestedJacobian<order> at(sample);
    for (int level = 0, rest = entry, size = entries_of_tensor / std::max(nv, 1); level < order; ++level) {
      at.move(level, unit(nv, rest / size));  // the direction of the outermost derivative comes first
      rest %= size, size /= std::max(nv, 1);
    }
    store(at);
  }
}
template <int order> void expect_partials_of_nested_duals(Sample& sample, Comparison& comparison) {
  std::tuple<std::vector<Twist<BodyFixed>>, std::vector<Twist<Spatial>>, std::vector<Twist<Hybrid>>,
             std::vector<Twist<Mixed>>>
      tensors;
  each_partial<order>(sample, [&](const NestedJacobian<order>& at) {
    each_representation([&](auto rep) {
      auto& tensor = std::get<index_of<decltype(rep)>>(tensors);
      for (const auto& column : at.template derivative<decltype(rep)>()) tensor.push_back(column);
    });
  });
  each_representation([&](auto rep) {
    using Rep = decltype(rep);
    comparison.expect_equal(sample.partials<Rep>(order), std::get<index_of<Rep>>(tensors), 1);
  });
}

TEST(JacobianPartials, OfOrderZeroAreTheJacobian) {
  Comparison J("J", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Sample sample(seed, 20);
    each_representation([&](auto rep) {
      using Rep = decltype(rep);
      std::vector<Twist<Rep>> expected(static_cast<std::size_t>(sample.model.nv()));
      jacobian<Rep>(sample.model, sample.workspace, sample.q, sample.place, expected);
      J.expect_equal(sample.partials<Rep>(0), expected, 1);
      J.expect_equal(sample.along<Rep>(0, {}), expected, 1);
    });
  });
}

TEST(JacobianPartials, OfFirstOrderAreThoseOfDuals) {
  Comparison partial("partial", agreement<double>);
  for_seeds(500, [&](std::uint64_t seed) {
    Sample sample(seed, 6);
    expect_partials_of_nested_duals<1>(sample, partial);
  });
}

TEST(JacobianPartials, OfSecondOrderAreThoseOfNestedDuals) {
  Comparison partial("partial", agreement<double>);
  for_seeds(200, [&](std::uint64_t seed) {
    Sample sample(seed, 6);
    expect_partials_of_nested_duals<2>(sample, partial);
  });
}

TEST(JacobianPartials, OfThirdOrderAreThoseOfNestedDuals) {
  Comparison partial("partial", agreement<double>);
  for_seeds(60, [&](std::uint64_t seed) {
    Sample sample(seed, 3);
    if (sample.model.nv() <= 12) expect_partials_of_nested_duals<3>(sample, partial);
  });
}

TEST(JacobianPartials, ContractedWithDirectionsAreDerivativesAlongThem) {
  Comparison derivative("derivative", agreement<double>);
  int tensors = 0;
  for_seeds(120, [&](std::uint64_t seed) {
    Sample sample(seed, 4);
    const int nv = sample.model.nv();
    const int highest = nv <= 7 ? 4 : nv <= 12 ? 3 : 2;
    tensors += highest == 4;
    for (int order = 1; order <= highest; ++order) {
      const std::vector<double> u = random_numbers(sample.random, order * nv);
      each_representation([&](auto rep) {
        using Rep = decltype(rep);
        std::vector<Twist<Rep>> sum = sample.partials<Rep>(order);
        for (int k = order; k > 0; --k) {  // u_k belongs to the slowest of the indices that remain
          const std::size_t size = sum.size() / static_cast<std::size_t>(nv);
          std::vector<Twist<Rep>> contracted(size);
          for (std::size_t e = 0; e < sum.size(); ++e)
            contracted[e % size] += u[static_cast<std::size_t>((k - 1) * nv) + e / size] * sum[e];
          sum = contracted;
        }
        derivative.expect_equal(sample.along<Rep>(order, u), sum, 1);
      });
    }
  });
  if (std::getenv("AXODE_RANDOM_TREES") == nullptr) {
    EXPECT_GT(tensors, 50) << "of fourth order";
  }
}

TEST(JacobianPartials, AlongThreeDirectionsAreThoseOfNestedDuals) {
  Comparison derivative("derivative", agreement<double>);
  for_seeds(200, [&](std::uint64_t seed) {
    Sample sample(seed, 12);
    const int nv = sample.model.nv();
    const std::vector<double> u = random_numbers(sample.random, 3 * nv);
    NestedJacobian<3> at(sample);
    for (int level = 0; level < 3; ++level)  // the last direction belongs to the outermost level
      at.move(level, {u.begin() + (2 - level) * nv, u.begin() + (3 - level) * nv});
    each_representation([&](auto rep) {
      using Rep = decltype(rep);
      derivative.expect_equal(sample.along<Rep>(3, u), at.template derivative<Rep>(), 1);
    });
  });
}

TEST(JacobianPartials, AlongOneDirectionAreTheSeriesOnThatWay) {
  constexpr std::size_t N = 7;
  using S = Taylor<double, N>;
  Comparison derivative("derivative", agreement<double>);
  for_seeds(200, [&](std::uint64_t seed) {
    Sample sample(seed, 10);
    const std::vector<double> u = random_numbers(sample.random, sample.model.nv());
    std::vector<S> dv;
    for (const double u_c : u) dv.push_back(S({0.0, u_c}));
    const Tree<S> tree = on<S>(sample.model);
    const std::vector<S> q = moved(tree, on<S>(sample.q), dv);
    each_representation([&](auto rep) {
      using Rep = decltype(rep);
      const auto J = jacobian_on<Rep>(tree, q, on<S>(sample.place));
      std::vector<double> directions;
      for (int order = 0; order < static_cast<int>(N); ++order) {
        derivative.expect_equal(sample.along<Rep>(order, directions), time_derivative(J, order), 1);
        directions.insert(directions.end(), u.begin(), u.end());
      }
    });
  });
}

TEST(JacobianPartials, AlongTheVelocitiesAreTheRateOfTheJacobian) {
  Comparison rate("rate", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Sample sample(seed, 20);
    const std::size_t nv = static_cast<std::size_t>(sample.model.nv());
    std::vector<double> rates = random_numbers(sample.random, sample.model.nv());
    const std::vector<double> v = rates;
    rates.resize(2 * nv);
    HigherOrderMotion<> motion(sample.model, 1);
    motion.evaluate(sample.q, rates);
    each_representation([&](auto rep) {
      using Rep = decltype(rep);
      std::vector<TwistRate<Rep>> dJ(nv);
      motion.jacobian_derivative<Rep>(sample.place, 1, dJ);
      rate.expect_equal(entries(sample.along<Rep>(1, v)), entries(dJ), 1);
    });
  });
}

/// A chain of joints of one kind with axes in general position.
Model chain(JointKind kind, int n) {
  Random<double> random(5);
  ModelBuilder builder("chain");
  for (int i = 1; i <= n; ++i)
    builder.add({.name = "link " + std::to_string(i),
                 .predecessor = i == 1 ? "ground" : "link " + std::to_string(i - 1),
                 .joint = {.kind = kind, .axis = random.direction(), .point = random.vector()},
                 .geometry = InBodyFrame{random.pose()}});
  return builder.build();
}
template <class Rep> bool is_zero(const Twist<Rep>& X) { return largest(entries(X)) == 0; }

/// A body-fixed derivative is zero unless all joints of the derivative are outward of the column's joint. A
/// spatial one is zero unless all of them are inward of it (Müller, eqs. der1, der2Jb, Jsder, Jsder2 and
/// erratum 2 of docs/errata.md). Joints beyond the place have no effect on either.
TEST(JacobianPartials, AreExactlyZeroWhereThePaperSaysSoAndNowhereElse) {
  const int n = 6, body = 5;
  Sample sample(chain(JointKind::revolute, n), 1, body);
  const auto body_1 = sample.partials<BodyFixed>(1), body_2 = sample.partials<BodyFixed>(2);
  const auto spatial_1 = sample.partials<Spatial>(1), spatial_2 = sample.partials<Spatial>(2);
  for (int j = 1; j <= n; ++j)
    for (int k = 1; k <= n; ++k) {
      const std::size_t at = static_cast<std::size_t>((k - 1) * n + j - 1);
      EXPECT_EQ(is_zero(body_1[at]), !(j < k && k <= body)) << j << ' ' << k;
      EXPECT_EQ(is_zero(spatial_1[at]), !(k < j && j <= body)) << j << ' ' << k;
      for (int r = 1; r <= n; ++r) {
        const std::size_t at_2 = static_cast<std::size_t>((r - 1) * n * n) + at;
        EXPECT_EQ(is_zero(body_2[at_2]), !(j < std::min(k, r) && std::max(k, r) <= body))
            << j << ' ' << k << ' ' << r;
        EXPECT_EQ(is_zero(spatial_2[at_2]), !(std::max(k, r) < j && j <= body)) << j << ' ' << k << ' ' << r;
      }
    }
}

/// ∂J^h_ij/∂q_k is [J_ij, vJ_ik], a linear velocity, for j <= k. For k < j it is [wJ_ik, J_ij], which is not
/// zero.
TEST(JacobianPartials, OfHybridScrewsHaveTwoCasesOfWhichNoneIsZero) {
  const int n = 6, body = 5;
  Sample sample(chain(JointKind::revolute, n), 2, body);
  const auto J = sample.partials<Hybrid>(0), dJ = sample.partials<Hybrid>(1);
  Comparison column("column", agreement<double>);
  for (int j = 1; j <= n; ++j)
    for (int k = 1; k <= n; ++k) {
      const Twist<Hybrid>&J_j = J[j - 1], &J_k = J[k - 1],
            &d = dJ[static_cast<std::size_t>((k - 1) * n + j - 1)];
      EXPECT_EQ(is_zero(d), std::max(j, k) > body);
      const Screw<> X_j{J_j.w, J_j.v}, w_k{J_k.w, {}}, v_k{{}, J_k.v},
          expected = j <= k ? ad(X_j, v_k) : ad(w_k, X_j);
      if (std::max(j, k) <= body) column.expect_equal(Screw<>{d.w, d.v}, expected, 1);
    }
}

TEST(JacobianPartials, OfSecondOrderCommuteBetweenDifferentJoints) {
  Comparison partial("partial", agreement<double>);
  for_seeds(50, [&](std::uint64_t seed) {
    Sample sample(seed, 6);
    const std::size_t n = static_cast<std::size_t>(sample.model.nv());
    std::vector<int> joint(n);
    for (int i = 1; i <= sample.model.n_bodies(); ++i)
      if (!sample.model.joint(i).leader)
        for (int k = 0; k < sample.model.joint(i).nv; ++k) joint[sample.model.joint(i).iv + k] = i;
    each_representation([&](auto rep) {
      const auto T = sample.partials<decltype(rep)>(2);
      for (std::size_t k = 0; k < n; ++k)
        for (std::size_t l = 0; l < k; ++l)
          for (std::size_t j = 0; j < n && joint[k] != joint[l]; ++j)
            partial.expect_equal(T[(k * n + l) * n + j], T[(l * n + k) * n + j], 1);
    });
  });
}

/// Contracted with the velocities of a motion with constant velocities, the partials are the derivative of
/// the Jacobian in time, which HigherOrderMotion computes without them.
TEST(JacobianPartials, OfOrdersBeyondTwelveAreDerivativesAlongTheMotion) {
  const int order = 13;
  Comparison derivative("derivative", agreement<double>);
  Sample sample(chain(JointKind::revolute, 2), 4, Place<>(2, Vec3<>{0.1, 0.2, 0.3}));
  const std::vector<double> v{0.7, -0.9};
  std::vector<double> rates(2 * (order + 1));
  std::copy(v.begin(), v.end(), rates.begin());
  HigherOrderMotion<> motion(sample.model, order);
  motion.evaluate(sample.q, rates);
  each_representation([&](auto rep) {
    using Rep = decltype(rep);
    std::vector<Twist<Rep>> sum = sample.partials<Rep>(order);
    while (sum.size() > 2) {
      const std::size_t half = sum.size() / 2;
      for (std::size_t e = 0; e < half; ++e) sum[e] = v[0] * sum[e] + v[1] * sum[half + e];
      sum.resize(half);
    }
    std::vector<TwistRate<Rep>> expected(2);
    motion.jacobian_derivative<Rep>(sample.place, order, expected);
    derivative.expect_equal(entries(sum), entries(expected), 1);
  });
}

/// The point at the distance d from a hinge moves on a circle: ∂^ν J is w × (w × ... (w × d)).
TEST(JacobianPartials, OfOneHingeRepeatAfterFourOrders) {
  Sample sample(chain(JointKind::revolute, 1), 4, Place<>(1, Vec3<>{0.1, 0.2, 0.3}));
  Comparison column("column", agreement<double>);
  each_representation([&](auto rep) {
    using Rep = decltype(rep);
    for (int order = 1; order < 5; ++order)
      column.expect_equal(sample.partials<Rep>(order + 40), sample.partials<Rep>(order), 1);
  });
  EXPECT_FALSE(largest(entries(sample.partials<Hybrid>(40)[0])) == 0);
}

/// A column takes at most 2 ν cross products of six multiplications each, or ν brackets of 18, for every
/// order ν; the partials share at most ν cross products of the derivatives of r.
template <class Rep> long products_of_a_column(int order) {
  const Model model = chain(JointKind::revolute, 4);
  const Tree<Counted> tree = on<Counted>(model);
  const ScrewPath<Counted> path(tree, std::vector<Counted>(4, Counted(0.3)).data(), Place<Counted>(4));
  ScrewPartials<Rep, Counted> partials(path, order);
  Counted::count() = {};
  long columns = 0;
  partials.each({}, [&](const std::vector<int>&, int, const Screw<Counted>&) { ++columns; });
  EXPECT_EQ(columns, std::lround(std::pow(4, order + 1)));
  return Counted::count().products / columns;
}
TEST(JacobianPartials, TakeOperationsInProportionToTheirNumberAndOrder) {
  for (int order = 1; order < 7; ++order) {
    EXPECT_LE(products_of_a_column<BodyFixed>(order), 18 * order);
    EXPECT_LE(products_of_a_column<Spatial>(order), 18 * order);
    EXPECT_LE(products_of_a_column<Hybrid>(order), 6 * 3 * order);
    EXPECT_LE(products_of_a_column<Mixed>(order), 6 * 3 * order);
  }
}

/// D_k D_l - D_l D_k is the derivative along [e_k, e_l]; D_k is the outer derivative.
TEST(JacobianPartials, OfSecondOrderWithinABallJointDifferByTheBracketOfTheirDirections) {
  Comparison commutator("commutator", agreement<double>);
  Sample sample(chain(JointKind::spherical, 3), 3, Place<>(3, Vec3<>{0.1, 0.2, 0.3}));
  const std::size_t n = 9;
  each_representation([&](auto rep) {
    const auto D = sample.partials<decltype(rep)>(1), DD = sample.partials<decltype(rep)>(2);
    for (const std::size_t ball : {0U, 3U, 6U})
      for (std::size_t j = 0; j < n; ++j) {
        const std::size_t x = ball, y = ball + 1, z = ball + 2;
        commutator.expect_equal(DD[(x * n + y) * n + j] - DD[(y * n + x) * n + j], D[z * n + j], 1);
        commutator.expect_equal(DD[(y * n + z) * n + j] - DD[(z * n + y) * n + j], D[x * n + j], 1);
      }
  });
}

/// (D_u + D_w)^n = Σ_k binomial(n, k) D_w^k D_u^(n - k) between joints of one velocity, which commute.
TEST(JacobianPartials, AlongTwoRepeatedDirectionsAreThoseOfTheirSum) {
  Sample sample(chain(JointKind::revolute, 4), 5, Place<>(4, Vec3<>{0.1, 0.2, 0.3}));
  constexpr int n = 15;
  const std::vector<double> u{0.3, -0.2, 0.5, 0.1}, w{-0.4, 0.1, 0.2, 0.6}, both{-0.1, -0.1, 0.7, 0.7};
  const auto repeated = [](std::vector<double> to, const std::vector<double>& direction, int times) {
    for (int k = 0; k < times; ++k) to.insert(to.end(), direction.begin(), direction.end());
    return to;
  };
  each_representation([&](auto rep) {
    using Rep = decltype(rep);
    Comparison same("D", agreement<double>);
    std::vector<Twist<Rep>> sum(4, Twist<Rep>{});
    double binomial = 1, size = 0;
    for (int k = 0; k <= n; ++k) {
      const auto term = sample.along<Rep>(n, repeated(repeated({}, u, n - k), w, k));
      for (std::size_t j = 0; j < 4; ++j) {
        sum[j] = sum[j] + binomial * term[j];
        size = std::max(size, binomial * (norm(term[j].w) + norm(term[j].v)));
      }
      binomial = binomial * (n - k) / (k + 1);
    }
    const auto expected = sample.along<Rep>(n, repeated({}, both, n));
    for (std::size_t j = 0; j < 4; ++j) same.expect_equal(sum[j], expected[j], size);
  });
}

TEST(JacobianPartials, AreNotComputedFurtherWhenTheCallerEndsThem) {
  Sample sample(chain(JointKind::revolute, 4), 1, 4);
  constexpr int run = 40;
  std::vector<double> directions;
  for (int k = 0; k < 2 * run; ++k) directions.insert(directions.end(), 4, k < run ? 1 : -1);
  const auto calls = [&](int last) {
    int n = 0;
    std::vector<Twist<Mixed>> J(4);
    jacobian_derivative_along<Mixed>(sample.model, sample.workspace, sample.q, 4, 2 * run, directions, J,
                                     [&] { return ++n != last; });
    return n;
  };
  const int all = calls(-1);
  EXPECT_GT(all, 50);
  for (int last = 1; last <= all; last += 19) EXPECT_EQ(calls(last), last);
}

TEST(JacobianPartialsErrors, NameTheValueAndTheRule) {
  Sample sample(chain(JointKind::revolute, 4), 1, 4);
  std::vector<Twist<BodyFixed>> J(16);
  const auto partials = [&](int order, int frame) {
    return message_of([&] { jacobian_partials(sample.model, sample.workspace, sample.q, frame, order, J); });
  };
  EXPECT_EQ(partials(1, 4), "no error");
  EXPECT_EQ(partials(1, 5), "frame is 5; model \"chain\" has frames 0 to 4");
  EXPECT_EQ(partials(-1, 4), "order is -1; expected 0 or more");
  EXPECT_EQ(partials(13, 4), "J has 16 entries; expected nv^(order + 1) = 268435456");
  EXPECT_EQ(partials(2, 4), "J has 16 entries; expected nv^(order + 1) = 64");
  const auto along = [&](int order, std::size_t directions) {
    return message_of([&] {
      jacobian_derivative_along(sample.model, sample.workspace, sample.q, 4, order,
                                std::vector<double>(directions), std::span(J).first(4));
    });
  };
  EXPECT_EQ(along(2, 8), "no error");
  EXPECT_EQ(along(2, 7), "directions has 7 entries; expected order nv = 8");
  EXPECT_EQ(along(13, 52), "no error");
  EXPECT_EQ(along(-1, 0), "order is -1; expected 0 or more");
  std::vector<double> alternating;
  for (int k = 0; k < 70; ++k) alternating.insert(alternating.end(), 4, k % 2);
  EXPECT_EQ(message_of([&] {
              jacobian_derivative_along(sample.model, sample.workspace, sample.q, 4, 70, alternating,
                                        std::span(J).first(4));
            }),
            "the derivative along 70 directions, 70 of them unlike the one before, does not fit into memory");
}

TEST(JacobianPartialsErrors, ATensorBeyondAllMemoryIsRefused) {
  Sample sample(chain(JointKind::revolute, 32), 1, 32);  // 32^13 = 2^65
  std::vector<Twist<BodyFixed>> none;
  EXPECT_THROW(jacobian_partials(sample.model, sample.workspace, sample.q, 32, 12, none),
               std::invalid_argument);
}

}  // namespace
}  // namespace axode::test
